// Boxes close on the IHIP: S31.

#include <cmath>

#include "tests/eval/random_motion.h"
#include "tests/eval/scenes/scenes.h"

namespace haptics::eval {
namespace {

constexpr int kBoxes = 5;
constexpr double kSlowest_m_per_s = 0.05;
constexpr double kFastest_m_per_s = 1;

/// A box at a time comes from each side: its face goes past the IHIP, stays, and goes back.
class Crushed final : public RandomMotion {
 public:
  explicit Crushed(Random from) : RandomMotion(from) {
    addBed();
    for (int i = 0; i < kBoxes; ++i) addBox();
    startHip({0, 0, 0.003});
  }

 private:
  struct Box {
    Vec3 direction;     // to it, unit
    double half_m = 0;  // along that
    Vec3 place;
    Quat upright;
    Vec3 tiltAxis;
    double tilt_rad = 0;
    double tiltRate_rad_per_s = 0;
    bool closing = false;
    Vec3 goal;
    double speed_m_per_s = 0;
    int stays = 0;  // ticks
  };

  /// Below all, at rest.
  void addBed() {
    constexpr Vec3 kSize(0.08, 0.08, 0.02);
    boxes_.push_back({});
    add(shapes::box(kSize, 2), {{1, 0, 0, 0}, {0, 0, -kSize.z / 2}});
  }

  void addBox() {
    Box box;
    do {
      box.direction = random().direction();
    } while (box.direction.z < -0.2);  // the bed is there
    const Vec3 size(random().between(0.02, 0.06), random().between(0.02, 0.06), random().between(0.01, 0.03));
    box.half_m = size.z / 2;
    const Vec3 up(0, 0, 1);
    const Vec3 axis = glm::cross(up, box.direction);
    box.upright = glm::angleAxis(std::acos(box.direction.z), glm::normalize(axis));
    box.tiltAxis = random().direction();
    box.tilt_rad = random().between(0, 0.3);
    box.tiltRate_rad_per_s = random().between(0, 10);
    box.place = box.direction * (box.half_m + random().between(0.04, 0.06));
    turnBack(box, Vec3(0));
    boxes_.push_back(box);
    add(shapes::box(size, 1 + random().below(3)), poseOf(box));
  }

  [[nodiscard]] Pose poseOf(const Box& box) const {
    const double turn = box.tilt_rad * std::sin(box.tiltRate_rad_per_s * time_s_);
    return {glm::angleAxis(turn, box.tiltAxis) * box.upright, box.place};
  }

  /// To the IHIP and up to 10 mm past it, or away.
  void turnBack(Box& box, Vec3 ihip) {
    box.closing = !box.closing;
    const double gap = box.closing ? random().between(-kDeepest_m, 0.002) : random().between(0.02, 0.05);
    const Vec3 aside = 0.005 * random().between(0, 1) * random().direction();
    box.goal = ihip + aside + box.direction * (box.half_m + gap);
    box.speed_m_per_s = kSlowest_m_per_s * std::pow(kFastest_m_per_s / kSlowest_m_per_s, random().between(0, 1));
    box.stays = random().below(200);
  }

  void moveBodies(Vec3 ihip) override {
    time_s_ += kPeriod_s;
    for (std::size_t i = 1; i < boxes_.size(); ++i) {
      Box& box = boxes_[i];
      const Vec3 way = box.goal - box.place;
      const double left = glm::length(way);
      const double step = box.speed_m_per_s * kPeriod_s;
      box.place += left > step ? way * (step / left) : way;
      if (left <= step && --box.stays <= 0) turnBack(box, ihip);
      setPose(i, poseOf(box));
    }
  }

  std::vector<Box> boxes_;  // the first one is the bed
  double time_s_ = 0;
};

}  // namespace

std::unique_ptr<RandomMotion> makeCrushed(Random random) { return std::make_unique<Crushed>(random); }

/// The IHIP is in no box for more than a tick in a row: where boxes close on it, it is put out of them.
SceneResult crushBetweenBoxes(Renderer& method, Random& random) {
  constexpr int kRuns = 24;
  constexpr int kTicks = 4000;
  MotionCounts counts;
  for (int i = 0; i < kRuns; ++i) {
    const auto motion = makeCrushed(Random(static_cast<std::uint64_t>(random.below(1 << 30))));
    leadThrough(method, *motion, kTicks, random, counts);
  }
  return {{{"ticks", counts.ticks},
           {"contact_ticks", counts.contact},
           {"inside_ticks", counts.inside.all()},
           {"inside_ticks_in_a_row", counts.inside.longest()},
           {"inside_depth_max_mm", counts.inside.deepest_m() * 1e3},
           {"non_finite_ticks", counts.notFinite}},
          counts.inside.longest() <= 1 && counts.notFinite == 0 && counts.contact > counts.ticks / 10};
}

}  // namespace haptics::eval
