// One hash for all forces and torques of each scene, and one of all: the same on every processor and with every C library.
// Usage: force_hash [--ticks N] [--drop-caches] [--folder DIR]... SCENE...; models are looked for beside the scene and in the folders.

#include <array>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/wire/convert.h"
#include "haptic_server/device/exploration_planner.h"
#include "haptic_server/device/exploring_hand.h"
#include "haptic_server/device/simulated_device.h"
#include "haptic_server/engine/step/haptic_step.h"
#include "haptic_server/engine/step/tool_step.h"
#include "haptic_server/scene/asset_library.h"
#include "haptic_server/scene/sequencer.h"
#include "haptic_server/scene/servo_scene_builder.h"
#include "haptic_server/servo/server_step_config.h"
#include "haptic_server/servo/stiffness_limit.h"
#include "tests/portability/scripted_hand.h"

namespace haptics::portability {
namespace {

constexpr double kRate_Hz = 1000;

/// FNV-1a, 64 bits.
class Hash {
 public:
  void add(std::uint64_t word) noexcept {
    for (int byte = 0; byte < 8; ++byte) value_ = (value_ ^ (word >> (8 * byte) & 0xff)) * 0x100000001b3;
  }
  void add(Vec3 v) noexcept {
    for (int d = 0; d < 3; ++d) add(std::bit_cast<std::uint64_t>(v[d]));
  }
  [[nodiscard]] std::uint64_t value() const noexcept { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325;
};

struct Felt {
  Hash hash;
  std::uint64_t ticks = 0, touching = 0, sliding = 0;

  void add(const TelemetrySample& sample, Vec3 torque_Nm) noexcept {
    hash.add(sample.force.contact);
    hash.add(sample.force.written);
    hash.add(torque_Nm);
    ++ticks;
    if (sample.object != 0) ++touching;
    if (sample.frictionState == FrictionState::kSliding) ++sliding;
  }
};

std::shared_ptr<const ExplorationPlan> planOf(const ServoScene& scene) {
  std::vector<ExploredObject> objects;
  for (const ServoObject& o : scene.objects) objects.push_back({o.id, o.surface, o.pose, o.motion != nullptr});
  return std::make_shared<const ExplorationPlan>(ExplorationPlanner().plan(objects));
}

/// A scene as the server makes it, for a device that turns.
struct Stage {
  DevicePreset preset = findDevicePreset("sigma.7").value();
  HandPreset hand = findHandPreset(kDefaultHandPreset).value();
  ExploringHand exploring{hand, preset.maxForce_N};
  SimulatedDevice device{{preset, hand, 1 / kRate_Hz, 0}, exploring};
  StepConfig config = serverStepConfig(device.info(), kRate_Hz);
  AssetStore store;
  std::unique_ptr<const ServoScene> scene;

  [[nodiscard]] Result<void> load(const std::string& file, std::vector<std::filesystem::path> folders) {
    folders.insert(folders.begin(), std::filesystem::absolute(file).parent_path());
    static const SurfaceLimits bears = surfaceLimits(device.info(), kRate_Hz, true);
    const DeviceLimits limits{config.positionStep_m,   config.stableLateral_N_per_m, config.period_s,
                              bears.stiffness_N_per_m, bears.damping_Ns_per_m,       bears.torsion_Nm_per_rad};
    const auto message = readSceneFile(file);
    if (!message) return tl::unexpected(message.error());
    const auto transaction = fromWire(*message);
    if (!transaction) return tl::unexpected(transaction.error());
    AssetLibrary library(std::move(folders), store, limits);
    Sequencer sequencer(1, library);
    const EditOutcome outcome = sequencer.submit(kServerSession, 1, *transaction);
    if (const auto* error = std::get_if<Error>(&outcome)) return tl::unexpected(*error);
    scene = ServoSceneBuilder(planOf, limits).make(sequencer, 0, ServoSceneBuilder::Plan::kReplan);
    return {};
  }

  /// With a new state.
  template <class Read, class Write>
  void play(std::uint64_t ticks, bool dropsCaches, Felt& felt, Read read, Write write) const {
    const auto state = std::make_unique<HapticState>(config);
    (void)adoptScene(*scene, *state, 0);  // nothing is in contact
    for (std::uint64_t tick = 0; tick < ticks; ++tick) {
      if (dropsCaches && tick > 0 && !state->connect(*scene)) std::abort();
      const TelemetrySample sample = hapticStep(*scene, *state, config, {tick, 0, read(tick, *state)});
      const Vec3 torque_Nm = writtenTorque_Nm(*state);
      write(sample.force.written, torque_Nm);
      felt.add(sample, torque_Nm);
    }
  }
};

Result<Felt> feel(const std::string& file, const std::vector<std::filesystem::path>& folders, std::uint64_t ticks,
                  bool dropsCaches) {
  Stage stage;
  if (const auto loaded = stage.load(file, folders); !loaded) return tl::unexpected(loaded.error());
  Felt felt;
  ScriptedHand scripted(*stage.scene);
  stage.play(
      ticks / 2, dropsCaches, felt,
      [&](std::uint64_t tick, const HapticState& state) { return scripted.at(tick, state); }, [](Vec3, Vec3) {});
  stage.device.follow(stage.scene->plan.get());
  stage.play(
      ticks - ticks / 2, dropsCaches, felt,
      [&](std::uint64_t tick, const HapticState&) { return stage.device.read(tick); },
      [&](Vec3 force_N, Vec3 torque_Nm) {
        stage.device.writeTorque(torque_Nm);
        stage.device.write(force_N);
      });
  return felt;
}

int run(std::span<char*> arguments) {
  std::uint64_t ticks = 100'000;
  bool dropsCaches = false;
  std::vector<std::filesystem::path> folders;
  std::vector<std::string> scenes;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view argument = arguments[i];
    const bool hasValue = i + 1 < arguments.size();
    if (argument == "--ticks" && hasValue) {
      ticks = std::strtoull(arguments[++i], nullptr, 10);
    } else if (argument == "--folder" && hasValue) {
      folders.emplace_back(arguments[++i]);
    } else if (argument == "--drop-caches") {
      dropsCaches = true;
    } else {
      scenes.emplace_back(argument);
    }
  }
  if (scenes.empty()) {
    std::fputs("usage: force_hash [--ticks N] [--drop-caches] [--folder DIR]... SCENE...\n", stderr);
    return 2;
  }
  Hash all;
  for (const std::string& scene : scenes) {
    const std::string name = std::filesystem::path(scene).stem().string();
    const auto felt = feel(scene, folders, ticks, dropsCaches);
    if (!felt) {
      std::fprintf(stderr, "%s: %s\n", name.c_str(), felt.error().text().c_str());
      return 1;
    }
    all.add(felt->hash.value());
    const auto percent = [&](std::uint64_t part) {
      return 100.0 * static_cast<double>(part) / static_cast<double>(felt->ticks);
    };
    std::printf("%-14s %016llx %5.1f %% in contact, %5.1f %% sliding\n", name.c_str(),
                static_cast<unsigned long long>(felt->hash.value()), percent(felt->touching), percent(felt->sliding));
    std::fflush(stdout);
  }
  std::printf("%-14s %016llx\n", "all", static_cast<unsigned long long>(all.value()));
  return 0;
}

}  // namespace
}  // namespace haptics::portability

int main(int argc, char** argv) { return haptics::portability::run({argv + 1, static_cast<std::size_t>(argc - 1)}); }
