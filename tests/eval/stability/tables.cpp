#include "tests/eval/stability/tables.h"

#include "haptic_server/engine/force/predictive_observer.h"
#include "tests/eval/or_throw.h"

namespace haptics::eval {
namespace {

constexpr double kServo_Hz = 1000;

std::vector<DevicePreset> devices(Scope scope) {
  if (scope == Scope::kShort) {
    return {orThrow(findDevicePreset("omni")), orThrow(findDevicePreset("desktop")),
            orThrow(findDevicePreset("omega.3"))};
  }
  return {devicePresets().begin(), devicePresets().end()};
}

std::vector<HandPreset> hands(Scope scope) {
  const auto all = handPresets();
  const std::size_t count = scope == Scope::kFull ? all.size() : 2;  // a firmer hand hides what a lighter one shows
  return {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count)};
}

struct Pace {
  double rate_Hz, delay_s;
};
std::vector<Pace> paces(Scope scope) {
  std::vector<Pace> paces;
  for (const double rate : {1e3, 4e3, 10e3}) {
    const bool slow = rate == kServo_Hz;
    if (!slow && scope == Scope::kShort) continue;
    paces.push_back({rate, 0});
    paces.push_back({rate, 1 / rate});
    if (scope == Scope::kShort || (scope == Scope::kCoarse && !slow)) continue;
    for (const double delay_s : {2e-3, 5e-3, 10e-3}) {
      if (delay_s <= PredictiveObserver::longestDelay_s(1 / rate)) paces.push_back({rate, delay_s});
    }
  }
  return paces;
}

Record recordOf(const Loop& loop, double critical) {
  return {{"method", loop.method->name},
          {"scene", loop.ground->name},
          {"device", loop.device.name},
          {"hand", loop.hand.name},
          {"rate_Hz", loop.rate_Hz},
          {"delay_ms", loop.delay_s * 1e3},
          {"B_Ns_per_m", loop.damping_Ns_per_m},
          {"K_crit_N_per_m", critical},
          {"K_crit_over_preset", critical / loop.device.maxStiffness_N_per_m}};
}

bool isJudged(const Loop& loop) {
  return loop.method->name == kOursMethod && loop.rate_Hz == kServo_Hz && loop.delay_s <= 1 / kServo_Hz &&
         (loop.hand.name == "none" || loop.hand.name == "light");
}

}  // namespace

std::vector<Record> measureCritical(Scope scope, const CaseChoice& isChosen) {
  const TestSurface wall = makeWall();
  std::vector<Loop> loops;
  for (const MethodEntry& method : stabilityMethods()) {
    for (const Pace pace : paces(scope)) {
      // Faster servos are compared with nothing and ours only, unless all is asked for.
      const bool plain = method.name == "nothing" || method.name == kOursMethod;
      if (scope == Scope::kCoarse && pace.rate_Hz > kServo_Hz && !plain) continue;
      for (const HandPreset& hand : hands(scope)) {
        for (const DevicePreset& device : devices(scope)) {
          loops.push_back({&method, &wall, device, hand, pace.rate_Hz, pace.delay_s});
        }
      }
    }
  }
  std::vector<Record> records;
  std::size_t at = 0;
  for (const Loop& loop : loops) {
    if (!isChosen(at++, loops.size())) continue;
    const double critical = criticalStiffness_N_per_m(loop);
    Record record = recordOf(loop, critical);
    record["pass"] = !isJudged(loop) || critical >= kRequired_N_per_m;
    records.push_back(std::move(record));
  }
  return records;
}

std::vector<Record> measureZWidth(Scope scope, const CaseChoice& isChosen) {
  const TestSurface wall = makeWall();
  std::vector<Loop> loops;
  if (scope == Scope::kShort) return {};
  const std::vector<double> dampings =
      scope == Scope::kFull ? std::vector<double>{0, 0.3, 1, 2, 4, 8, 15, 30, 60} : std::vector<double>{0, 1, 4, 15};
  for (const MethodEntry& method : stabilityMethods()) {
    for (const DevicePreset& device : devices(scope)) {
      if (device.name == "touch") continue;
      for (const double damping : dampings) {
        loops.push_back({&method, &wall, device, handPresets().front(), kServo_Hz, 1 / kServo_Hz, damping});
      }
    }
  }
  std::vector<Record> records;
  std::size_t at = 0;
  for (const Loop& loop : loops) {
    if (!isChosen(at++, loops.size())) continue;
    Record record = recordOf(loop, criticalStiffness_N_per_m(loop));
    record["scene"] = "z_width";
    record["pass"] = true;
    records.push_back(std::move(record));
  }
  return records;
}

std::vector<Record> measureGrounds(Scope scope, const CaseChoice& isChosen) {
  const MethodEntry& ours = stabilityMethods().back();
  const std::vector<TestSurface> grounds{makeOuterEdge(),  makeGroove(),        makeBall(),
                                         makePushedBody(), makeElasticTissue(), makeViscousTissue()};
  std::vector<Record> records;
  std::size_t at = 0;
  const auto all = devices(scope);
  for (const TestSurface& ground : grounds) {
    for (const DevicePreset& device : all) {
      for (const double delay_s : {0.0, 1 / kServo_Hz}) {
        if (!isChosen(at++, grounds.size() * all.size() * 2)) continue;
        // Nothing holds a free device on the top of a sphere.
        const HandPreset& hand = handPresets()[ground.name == "sphere" ? 1 : 0];
        const Loop loop{&ours, &ground, device, hand, kServo_Hz, delay_s};
        const double critical = criticalStiffness_N_per_m(loop);
        Record record = recordOf(loop, critical);
        record["pass"] = critical >= kRequiredMargin * device.maxStiffness_N_per_m;
        records.push_back(std::move(record));
      }
    }
  }
  return records;
}

std::vector<Record> measureRobustness(Scope scope, const CaseChoice& isChosen) {
  struct Off {
    double mass, friction, delay_s, toldMore_s;
  };
  constexpr double kTick_s = 1 / kServo_Hz;
  std::vector<Off> cases;
  for (const double mass : {0.5, 1.0, 2.0}) {
    for (const double friction : {1 / 3.0, 1.0, 3.0}) {
      if (scope == Scope::kShort && (mass == 1 || friction == 1)) continue;
      for (const auto& [delay_s, toldMore_s] :
           {std::pair{0.0, 0.0}, {kTick_s, 0.0}, {0.0, kTick_s}, {kTick_s, -kTick_s}, {kTick_s, kTick_s}}) {
        cases.push_back({mass, friction, delay_s, toldMore_s});
      }
    }
  }
  const TestSurface wall = makeWall();
  const auto all = devices(scope);
  constexpr double kMaxPress_N = 0.45;
  std::vector<Record> records;
  std::size_t at = 0;
  for (const DevicePreset& told : all) {
    for (const Off& off : cases) {
      if (!isChosen(at++, all.size() * cases.size())) continue;
      DevicePreset real = told;
      real.apparentMass_kg *= off.mass;
      real.viscousFriction_Ns_per_m *= off.friction;
      real.coulombFriction_N *= off.friction;
      if (real.coulombFriction_N > kMaxPress_N) continue;  // it would stick under every press
      for (const HandPreset& hand : hands(Scope::kCoarse)) {
        Loop loop{&stabilityMethods().back(), &wall, real, hand, kServo_Hz, off.delay_s};
        loop.toldDevice = &told;
        loop.toldDelayMore_s = off.toldMore_s;
        const double preset = told.maxStiffness_N_per_m;
        const double most = 1.05 * kRequiredMargin * preset;
        const double critical =
            criticalStiffness_N_per_m(loop, {.least = 0.6 * preset, .most = most, .climb = 1.05, .close = 1.05});
        Record record = recordOf(loop, critical);
        record["scene"] = "wall_off_data_sheet";
        record["mass_factor"] = off.mass;
        record["friction_factor"] = off.friction;
        record["delay_told_ms"] = (off.delay_s + off.toldMore_s) * 1e3;
        record["searched_up_to_N_per_m"] = most;
        record["required_over_preset"] = kRequiredMargin;
        record["pass"] = critical >= kRequiredMargin * preset;
        records.push_back(std::move(record));
      }
    }
  }
  return records;
}

}  // namespace haptics::eval
