#include "tests/eval/advise/independent_check.h"

#include <algorithm>
#include <iterator>
#include <numbers>

#include "tests/eval/advise/felt_forces.h"
#include "tests/eval/random.h"

namespace haptics::eval {
namespace {

std::vector<LoadedObject> withoutTools(std::vector<LoadedObject> scene) {
  std::erase_if(scene, &LoadedObject::held);
  return scene;
}

std::vector<HandStroke> drawnStrokes(const LoadedObject& object, Random& random) {
  constexpr int kDirections = 5;
  std::vector<HandStroke> strokes;
  for (int i = 0; i < kDirections; ++i) {
    const double turn_rad = random.between(0, std::numbers::pi);
    std::ranges::move(strokesOver(object, {&turn_rad, 1}, random.between(0.7, 1.3)), std::back_inserter(strokes));
  }
  return strokes;
}

}  // namespace

std::map<std::string, ForceDifference> checkedAgainst(const std::vector<LoadedObject>& scene,
                                                      const std::vector<LoadedObject>& original, std::uint64_t seed) {
  constexpr double kRate_Hz = 1000;
  const std::vector<LoadedObject> objects = withoutTools(original);
  const ServoScene truth = servoSceneOf(objects);
  const ServoScene written = servoSceneOf(withoutTools(scene));
  Random random(seed);
  std::map<std::string, ForceDifference> found;
  for (const LoadedObject& object : objects) {
    const std::vector<HandStroke> strokes = drawnStrokes(object, random);
    if (strokes.empty()) continue;
    found[object.name] = differenceOf(forcesIn(written, strokes, kRate_Hz), forcesIn(truth, strokes, kRate_Hz));
  }
  return found;
}

}  // namespace haptics::eval
