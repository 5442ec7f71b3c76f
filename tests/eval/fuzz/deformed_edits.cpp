#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/mesh/import.h"
#include "common/wire/convert.h"
#include "haptic_server/scene/scene_service.h"
#include "haptic_server/servo/servo_loop.h"
#include "tests/eval/fuzz/fuzz.h"
#include "tests/eval/fuzz/live_world.h"
#include "tests/eval/fuzz/random_edits.h"
#include "tests/eval/report.h"
#include "tests/eval/table1/interruption.h"

namespace haptics::eval {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

constexpr double kRate_Hz = 1000;
constexpr int kEditsOfWorld = 10;
constexpr std::uint64_t kTicksOfEdit = 30;
constexpr std::uint64_t kWorldsToALine = 100;
constexpr SessionId kEditor = 1;
constexpr double kDenormal = 5e-324, kFloatHuge = 3e38;

/// A number field of a message, or one of a list of them.
struct Place {
  Message* message;
  const FieldDescriptor* field;
  int index;  // -1: it is no list
};

void gather(Message& message, std::vector<Place>& places) {
  const auto& reflection = *message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 0;
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      for (int i = 0; i < count; ++i) gather(*reflection.MutableRepeatedMessage(&message, field, i), places);
      if (!field->is_repeated()) gather(*reflection.MutableMessage(&message, field), places);
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE ||
               field->cpp_type() == FieldDescriptor::CPPTYPE_FLOAT) {
      if (!field->is_repeated()) places.push_back({&message, field, -1});
      for (int i = 0; i < count; ++i) places.push_back({&message, field, i});
    }
  }
}

/// Edits with numbers at and beyond what means something, and lattices that bring objects to next to nothing.
class DegenerateEdits {
 public:
  explicit DegenerateEdits(std::uint64_t seed) : random_(seed), usual_(seed) {}

  [[nodiscard]] v1::Transaction next(const SceneVersion& scene, AssetStore& store) {
    v1::Transaction transaction;
    if (!scene.objects().empty() && random_.chance(0.4)) {
      const auto count = static_cast<int>(scene.objects().size());
      auto& set = *transaction.add_operations()->mutable_set_deformation();
      set.mutable_object()->set_id(scene.objects()[static_cast<std::size_t>(random_.below(count))]->id);
      collapse(*set.mutable_deformation()->mutable_lattice());
      return transaction;
    }
    transaction = usual_.next(scene);
    for (v1::Operation& operation : *transaction.mutable_operations()) {
      if (operation.has_add()) degrade(*operation.mutable_add()->mutable_mesh(), store);
      if (operation.has_remesh()) degrade(*operation.mutable_remesh()->mutable_mesh(), store);
    }
    return transaction;
  }

  /// Sets some of its numbers to what no one would.
  void mutate(v1::Transaction& transaction) {
    std::vector<Place> places;
    gather(transaction, places);
    if (places.empty()) return;
    for (int i = 1 + random_.below(3); i > 0; --i) {
      const auto& [message, field, index] =
          places[static_cast<std::size_t>(random_.below(static_cast<int>(places.size())))];
      const auto& reflection = *message->GetReflection();
      if (field->cpp_type() == FieldDescriptor::CPPTYPE_FLOAT) {
        const auto value = static_cast<float>(std::clamp(extreme(0), -kFloatHuge, kFloatHuge));
        if (index >= 0)
          reflection.SetRepeatedFloat(message, field, index, value);
        else
          reflection.SetFloat(message, field, value);
      } else if (index >= 0) {
        reflection.SetRepeatedDouble(message, field, index,
                                     extreme(reflection.GetRepeatedDouble(*message, field, index)));
      } else {
        reflection.SetDouble(message, field, extreme(reflection.GetDouble(*message, field)));
      }
    }
  }

 private:
  [[nodiscard]] double extreme(double usual) {
    constexpr std::array kAbsolute{0.0,  -0.0, kDenormal, 1e-310, 1e-45, 1e-38, 1e-12, 1e-9, 1e-6,
                                   1e-3, 1.0,  1e3,       1e6,    1e9,   1e38,  3e38,  1e300};
    constexpr std::array kNot{std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()};
    if (random_.chance(0.05)) return random_.sign() * kNot[static_cast<std::size_t>(random_.below(2))];
    if (random_.chance(0.4)) return usual * std::pow(10.0, random_.between(-8, 8));
    const double value = kAbsolute[static_cast<std::size_t>(random_.below(static_cast<int>(kAbsolute.size())))];
    return random_.chance(0.2) ? -value : value;
  }

  /// Control points on one point, line or plane, or nearly, or far out.
  void collapse(v1::Lattice& lattice) {
    const std::array<std::uint32_t, 3> points{count(), count(), count()};
    const double half_m = random_.chance(0.8) ? 0.12 : std::pow(10.0, random_.between(-7, 2));
    lattice.set_points_x(points[0]);
    lattice.set_points_y(points[1]);
    lattice.set_points_z(points[2]);
    for (v1::Vector3* low : {lattice.mutable_low_m()}) low->set_x(-half_m), low->set_y(-half_m), low->set_z(-half_m);
    for (v1::Vector3* size : {lattice.mutable_size_m()})
      size->set_x(2 * half_m), size->set_y(2 * half_m), size->set_z(2 * half_m);
    std::array<double, 3> scale;
    for (double& s : scale) s = scales_[static_cast<std::size_t>(random_.below(static_cast<int>(scales_.size())))];
    const double noise_m = random_.chance(0.5) ? 0 : std::pow(10.0, random_.between(-40, -2));
    const Vec3 to = random_.chance(0.7) ? Vec3(0) : 0.05 * random_.direction();
    for (std::uint32_t i = 0; i < points[0] * points[1] * points[2]; ++i) {
      const std::array at{i % points[0], i / points[0] % points[1], i / points[0] / points[1]};
      for (int k = 0; k < 3; ++k) {
        const auto n = static_cast<std::size_t>(k);
        const double rest_m = half_m * (2.0 * at[n] / (points[n] - 1) - 1);
        lattice.add_control_m(static_cast<float>(to[k] + scale[n] * rest_m + random_.between(-noise_m, noise_m)));
      }
    }
  }

  [[nodiscard]] std::uint32_t count() { return 2 + static_cast<std::uint32_t>(random_.below(3)); }

  void degrade(v1::MeshSource& mesh, AssetStore& store) {
    if (random_.chance(0.1)) mesh.mutable_simplify()->set_error(std::pow(10.0, random_.between(-2, 1)));
    if (mesh.has_box() && random_.chance(0.5)) {
      v1::Vector3& size = *mesh.mutable_box()->mutable_size_m();
      if (random_.chance(0.5)) size.set_x(std::pow(10.0, random_.between(-9, -1)));
      if (random_.chance(0.5)) size.set_z(std::pow(10.0, random_.between(-9, -1)));
    } else if (random_.chance(0.3)) {
      if (auto asset = soup(store)) {
        mesh.set_asset(asset->name.hash.asBytes());
        held_.push_back(std::move(asset));
      }
    }
  }

  /// Long triangles, and such as are nearly none. Null: none are left.
  [[nodiscard]] std::shared_ptr<const MeshAsset> soup(AssetStore& store) {
    const double size_m = random_.chance(0.8) ? 0.05 : std::pow(10.0, random_.between(-6, 1));
    std::vector<Vec3> vertices;
    std::vector<TriangleIndices> triangles;
    const int many = random_.chance(0.3) ? 3000 : 1 + random_.below(60);
    for (int t = 0; t < many; ++t) {
      const auto first = static_cast<std::uint32_t>(vertices.size());
      const Vec3 a = size_m * random_.direction(), b = random_.chance(0.8) ? size_m * random_.direction() : a;
      const double off_m = random_.chance(0.5) ? size_m : std::pow(10.0, random_.between(-40, -3));
      vertices.insert(vertices.end(), {a, b, 0.5 * (a + b) + off_m * random_.direction()});
      triangles.push_back({first, first + 1, first + 2});
    }
    auto mesh = canonicalise(vertices, std::move(triangles), {});
    return mesh && !mesh->mesh.triangles.empty() ? store.intern(std::move(mesh->mesh)) : nullptr;
  }

  static constexpr std::array scales_{0.0, 1.0, 1.0, -1.0, 1e-3, 1e-9, 1e-30, 1e-42, 10.0, 1e4};
  Random random_;
  RandomEdits usual_;
  std::vector<std::shared_ptr<const Asset>> held_;
};

/// Looks at every force that is written.
class JudgedDevice final : public Device {
 public:
  JudgedDevice(const DevicePreset& preset, std::uint64_t seed)
      : hand_(seed), device_({.device = preset, .hand = handPresets().front(), .period_s = 1 / kRate_Hz}, hand_) {}

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return device_.info(); }
  [[nodiscard]] DeviceReading read(std::uint64_t tick) noexcept override { return device_.read(tick); }
  void write(Vec3 force_N) noexcept override {
    const double most_N = info().maxForce_N * (1 + 1e-9);
    if (!(glm::dot(force_N, force_N) <= most_N * most_N)) ++wrong_;
    device_.write(force_N);
  }
  void writeTorque(Vec3 torque_Nm) noexcept override {
    if (!std::isfinite(glm::dot(torque_Nm, torque_Nm))) ++wrong_;
    device_.writeTorque(torque_Nm);
  }
  void stop() noexcept override {}
  [[nodiscard]] std::uint64_t wrong() const noexcept { return wrong_; }

 private:
  WanderingHand hand_;
  SimulatedDevice device_;
  std::uint64_t wrong_ = 0;
};

/// Scene service and servo in virtual time; each edit is felt for some ticks before the next one comes.
class DeformedWorld final : private ReplaySource {
 public:
  explicit DeformedWorld(std::uint64_t seed)
      : random_(seed ^ 0x9E3779B97F4A7C15U), edits_(seed), device_(devicePresets().front(), seed) {}

  void run() { loop_.runFlatOut(*this); }

  std::string wrong;  ///< Empty: nothing.
  std::uint64_t accepted = 0, degenerate = 0, refused = 0, contactTicks = 0;

 private:
  [[nodiscard]] Next next(Tick& tick) noexcept override {
    judge();
    if (!wrong.empty() || tick_ >= kEditsOfWorld * kTicksOfEdit) return Next::kEnd;
    if (tick_ % kTicksOfEdit == 0) edit();
    if (tick_ % 5 == 0) scenes_.executeAll();
    tick = {tick_++, mailbox_.newest()};
    return Next::kTick;
  }
  void releaseBefore(std::uint64_t /*scene*/) noexcept override {}

  void edit() {
    const v1::Transaction usual = edits_.next(scenes_.history()->version, scenes_.assetStore());
    v1::Transaction strange = usual;
    edits_.mutate(strange);
    for (const v1::Transaction* one : {random_.chance(0.7) ? &strange : &usual, &usual}) {
      auto transaction = fromWire(*one);
      if (!transaction) continue;
      bool good = false;
      const auto answer = [&good](const EditOutcome& outcome) {
        good = std::holds_alternative<std::shared_ptr<const AcceptedEdit>>(outcome);
      };
      if (!scenes_.submitEdit(kEditor, ++submitted_, *std::move(transaction), answer)) continue;
      scenes_.executeAll();
      ++(good ? accepted : refused);
      degenerate += good && one == &strange ? 1 : 0;
      if (good) return;
    }
  }

  void judge() noexcept {
    if (device_.wrong() > 0) wrong = "a force is not finite or too large";
    TelemetrySample sample;
    while (loop_.hand().pop(sample)) {
      if (sample.fault == Fault::kNonFiniteForce) wrong = "the step's force was not finite";
      if (sample.object != 0) ++contactTicks;
      for (const Vec3& place : {sample.ihip, sample.surfaceNormal, sample.predictedHip}) {
        if (!std::isfinite(glm::dot(place, place))) wrong = "the sample is not finite";
      }
    }
  }

  [[nodiscard]] std::uint64_t now_ns() const noexcept { return tick_ * 1'000'000; }

  Random random_;
  DegenerateEdits edits_;
  JudgedDevice device_;
  SceneMailbox mailbox_;
  ServoLoop loop_{device_, mailbox_, kRate_Hz, false};
  SceneService scenes_{{.assetFolders = {},
                        .makePlan = {},
                        .takeMotion = [this] { return loop_.hand().takeMotionForBuilder(); },
                        .log = {},
                        .now_ns = [this] { return now_ns(); }},
                       mailbox_};
  std::uint64_t tick_ = 0, submitted_ = 0;
};

}  // namespace

bool runFuzzDeformedEdits(const FuzzOptions& options, const std::filesystem::path& out) {
  Interruption interruption;
  std::vector<Record> findings;
  std::uint64_t done = 0, accepted = 0, degenerate = 0, contactTicks = 0;
  for (; done < options.scenes && !interruption.came(); ++done) {
    DeformedWorld world(options.seed + done);
    world.run();
    accepted += world.accepted;
    degenerate += world.degenerate;
    contactTicks += world.contactTicks;
    if (!world.wrong.empty()) {
      findings.push_back(
          {{"fuzz", "deformed-edits"}, {"seed", options.seed + done}, {"failure", world.wrong}, {"pass", false}});
      showFinding(findings.back());
    }
    showProgress(done + 1, options.scenes, kWorldsToALine, findings.size());
  }
  std::vector<Record> records{{{"fuzz", "deformed-edits"},
                               {"seed", options.seed},
                               {"worlds", done},
                               {"accepted", accepted},
                               {"degenerate", degenerate},
                               {"contact_ticks", contactTicks},
                               {"failed", findings.size()},
                               {"pass", findings.empty()}}};
  std::printf("%s\n", measuresText(records.back()).c_str());
  records.insert(records.end(), findings.begin(), findings.end());
  writeRecords(out, "fuzz", records);
  if (interruption.came()) std::printf("interrupted: this is what was found by then\n");
  return findings.empty();
}

}  // namespace haptics::eval
