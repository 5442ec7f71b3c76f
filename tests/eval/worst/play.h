#pragma once

#include <array>
#include <memory>
#include <vector>

#include "haptic_server/engine/step/haptic_step.h"
#include "haptic_server/servo/cache_warmer.h"
#include "tests/eval/renderer.h"
#include "tests/eval/worst/families.h"

namespace haptics::eval {

/// What makes a scene of a family and a hand's motion in it. Numbers in [0, 1).
struct Genome {
  static constexpr std::size_t kMotionGenes = 26;

  std::array<double, Family::kGenes> scene{};
  std::array<double, kMotionGenes> motion{};
};

/// A hand that makes for one place after another, at 0.02 to 5 m/s, and is drawn back where it is too far from the IHIP.
class WorstHand {
 public:
  explicit WorstHand(const Genome& genome) : genes_(genome.motion) {}
  [[nodiscard]] static Vec3 start() { return {0, 0, 0.09}; }
  /// @param period_s  Of a tick.
  Vec3 next(Vec3 ihip, double period_s);

 private:
  static constexpr std::size_t kTargets = 5;
  static constexpr std::size_t kEach = 5;  ///< Genes: a place, a speed, a time.
  static_assert(kTargets * kEach + 1 == Genome::kMotionGenes);

  std::array<double, Genome::kMotionGenes> genes_;
  std::size_t target_ = 0;
  double left_s_ = 0;  ///< Until the next target.
  double speed_m_per_s_ = 0;
  Vec3 place_ = start();
  Vec3 hip_ = start();
  Vec3 velocity_m_per_s_{0};
};

/// Ticks as the servo makes them, rehearsals and an adoption in every fifth of a second included.
class Play {
 public:
  struct Settings {
    double rate_Hz = 1000;
    bool bounded = true;  ///< False: without an allowance.
  };
  struct Tick {
    double ns = 0;
    std::int64_t units = 0;  ///< Spent by the contact and what follows it.
    bool allowanceSpent = false;
  };

  Play(std::shared_ptr<const ServoScene> scene, const Genome& genome, const Settings& settings);

  Tick tick();
  /// The next tick: instructions of it, and the shortest of some runs of it in ns. It is not made.
  struct Cost {
    double instructions = 0;
    double ns = 0;
  };
  [[nodiscard]] Cost costOfNext();
  [[nodiscard]] double timeOfNext_ns();

 private:
  /// All that a tick changes.
  struct Servo {
    HapticState state;
    CacheWarmer cacheWarmer;
    std::shared_ptr<const ServoScene> scene;
  };
  std::int64_t run(Servo& servo, Vec3 hip) const;
  [[nodiscard]] Vec3 hipOfNext() const;

  Settings settings_;
  StepConfig config_;
  std::array<std::shared_ptr<const ServoScene>, 2> scenes_;  ///< By turns: the same, but for where its first object is.
  std::unique_ptr<Servo> servo_;
  WorstHand hand_;
  Vec3 hip_ = WorstHand::start();
  std::uint64_t tick_ = 0;
};

/// Ticks of a method of rendering under the same scene and hand, ns each. Of shapes at rest.
[[nodiscard]] std::vector<double> playWith(Renderer& method, const ServoScene& scene, const Genome& genome, int ticks);

}  // namespace haptics::eval
