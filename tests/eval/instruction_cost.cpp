#include "tests/eval/instruction_cost.h"

#include <algorithm>

#include "tests/eval/adapters/outside_method.h"
#include "tests/eval/instructions.h"
#include "tests/eval/timing.h"

namespace haptics::eval {
namespace {

/// Goes over a stroke to and fro.
class Strokes {
 public:
  Strokes(Renderer& renderer, std::span<const Vec3> places) : renderer_(renderer), places_(places) {}

  void tick() {
    (void)renderer_.tick({&pose_, 1}, places_[at_]);
    if (at_ + 1 == places_.size()) forth_ = false;
    if (at_ == 0) forth_ = true;
    at_ += forth_ ? 1 : -1;
  }
  void ticks(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) tick();
  }

 private:
  Renderer& renderer_;
  std::span<const Vec3> places_;
  Pose pose_;
  std::size_t at_ = 0;
  bool forth_ = true;
};

/// Of a tick, over as many, or fewer where they are long: an instruction that is counted takes microseconds.
double meanInstructions(Strokes& strokes, int mostTicks) {
  constexpr double kEnough = 1e6;
  const double first = countInstructions([&] { strokes.tick(); });
  const auto ticks = static_cast<std::size_t>(std::clamp(kEnough / first, 1.0, static_cast<double>(mostTicks)));
  return countInstructions([&] { strokes.ticks(ticks); }) / static_cast<double>(ticks);
}

}  // namespace

InstructionCost instructionCostOf(Renderer& renderer, const std::shared_ptr<const CollisionMesh>& surface,
                                  std::span<const Vec3> way, std::span<const Vec3> stroke, int coldTicks,
                                  int countedTicks) {
  constexpr int kBatch = 16;  // a single tick is no longer than reading the clock
  constexpr int kBatches = 200;
  const Pose pose;
  renderer.begin({&surface, 1}, {&pose, 1}, way.front());
  renderer.contactOnly();
  for (const Vec3 hip : way) (void)renderer.tick({&pose, 1}, hip);
  Strokes strokes(renderer, stroke);
  strokes.ticks(2 * stroke.size());

  InstructionCost price;
  if (isOutside(renderer)) {
    Statistics own_ns;
    for (int i = 0; i < kBatches; ++i) {
      strokes.tick();
      if (const auto own = ownTime_ns(renderer)) own_ns.add(*own);
    }
    price.hot_ns = own_ns.quantile(0.5);
    return price;
  }
  Stopwatch hot;
  for (int i = 0; i < kBatches; ++i) hot.time([&] { strokes.ticks(kBatch); });
  price.hot_ns = hot.durations_ns().quantile(0.5) / kBatch;

  if (countedTicks > 0) price.instructions = meanInstructions(strokes, countedTicks);
  Stopwatch cold;
  for (int i = 0; i < coldTicks; ++i) {
    strokes.ticks(stroke.size() / static_cast<std::size_t>(coldTicks));
    sweepCaches();
    cold.time([&] { strokes.tick(); });
  }
  price.cold_ns = cold.durations_ns().quantile(0.5);
  return price;
}

}  // namespace haptics::eval
