#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string_view>

#include "common/wire/convert.h"
#include "haptics/v1/options.pb.h"

namespace haptics::convert_state_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double mostOf(std::string_view scalar) { return materialScalar(scalar).options().GetExtension(v1::scalar).most(); }

ObjectRecord record(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  ObjectRecord r;
  r.id = 1 + seed;
  r.name = "object-" + std::to_string(seed);
  r.revision = 3 + seed;
  r.mesh = Hasher().add(seed).finish();
  r.pose = {glm::angleAxis(number(random), glm::normalize(Vec3(number(random), 1, 2))),
            {number(random), number(random), number(random)}};
  r.material.color = {0.1F, 0.2F, 0.3F};
  forEachMaterialScalar([&](std::string_view name, double& value) { value = mostOf(name) * (2 + number(random)) / 3; },
                        r.material);
  return r;
}

v1::ObjectState state(std::uint64_t seed) {
  v1::ObjectState message;
  toWire(record(seed), message);
  return message;
}

TEST(ObjectState, ComesBackBitForBit) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    v1::ObjectState arrived;
    ASSERT_TRUE(arrived.ParseFromString(state(seed).SerializeAsString()));
    const auto back = fromWire(arrived);
    ASSERT_TRUE(back) << back.error().text();
    EXPECT_EQ(*back, record(seed));
    EXPECT_EQ(back->hash(), record(seed).hash());
  }
}

/// The hash has them so (proto/README.md).
TEST(ObjectState, HasNumbersOfAMaterialInTheOrderOfTheirFields) {
  const ObjectRecord one = record(1);
  int last = 0;
  forEachMaterialScalar(
      [&](std::string_view name, double /*value*/) {
        const auto* field = v1::ObjectState::descriptor()->FindFieldByName(std::string(name));
        ASSERT_NE(field, nullptr) << name;
        EXPECT_GT(field->number(), last) << name;
        last = field->number();
      },
      one.material);
}

TEST(ObjectState, KeepsARotationThatIsNotQuiteOfUnitLength) {
  v1::ObjectState message = state(1);
  message.mutable_pose()->mutable_rotation()->set_w(1.0005);
  message.mutable_pose()->mutable_rotation()->set_x(0);
  message.mutable_pose()->mutable_rotation()->set_y(0);
  message.mutable_pose()->mutable_rotation()->set_z(0);
  const auto back = fromWire(message);
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(back->pose.rotation.w, 1.0005);
}

TEST(ObjectState, IsRefusedNamingTheFieldThatIsBad) {
  std::vector<std::pair<std::string, std::function<void(v1::ObjectState&)>>> cases = {
      {"id", [](auto& m) { m.set_id(0); }},
      {"name", [](auto& m) { m.set_name(""); }},
      {"name", [](auto& m) { m.set_name("a\nb"); }},
      {"mesh", [](auto& m) { m.set_mesh("short"); }},
      {"pose.position", [](auto& m) { m.clear_pose(); }},
      {"pose.rotation", [](auto& m) { m.mutable_pose()->clear_rotation(); }},
      {"pose.position.x", [](auto& m) { m.mutable_pose()->mutable_position()->set_x(kNaN); }},
      {"pose.rotation", [](auto& m) { m.mutable_pose()->mutable_rotation()->set_y(kNaN); }},
      {"pose.rotation", [](auto& m) { m.mutable_pose()->mutable_rotation()->set_y(7); }},
      {"stiffness_N_per_m", [](auto& m) { m.set_stiffness_n_per_m(0); }},
      {"color.blue", [](auto& m) { m.mutable_color()->set_blue(2); }},
  };
  const ObjectRecord one = record(1);
  forEachMaterialScalar(
      [&](std::string_view name, double /*value*/) {
        for (const double bad : {-1e-9, 1.01 * mostOf(name), kNaN}) {
          cases.emplace_back(name, [name, bad](v1::ObjectState& m) {
            m.GetReflection()->SetDouble(&m, m.GetDescriptor()->FindFieldByName(std::string(name)), bad);
          });
        }
      },
      one.material);
  for (const auto& [field, spoil] : cases) {
    v1::ObjectState message = state(4);
    spoil(message);
    const auto back = fromWire(message);
    ASSERT_FALSE(back) << field;
    EXPECT_EQ(back.error().field, field);
    EXPECT_FALSE(back.error().reason.empty());
  }
}

Commit someCommit() {
  Commit commit;
  commit.revision = 12;
  commit.prevRoot = Hasher().add(1.0).finish();
  commit.root = Hasher().add(2.0).finish();
  commit.put = {record(1), record(2)};
  commit.removed = {9, 8};
  return commit;
}

TEST(Commit, ComesBackWhole) {
  const Commit sent = someCommit();
  v1::Commit message;
  toWire(someCommit(), message);
  toWire(sent, message);  // into a message that was used
  const auto back = fromWire(message);
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(back->revision, sent.revision);
  EXPECT_EQ(back->prevRoot, sent.prevRoot);
  EXPECT_EQ(back->root, sent.root);
  EXPECT_EQ(back->put, sent.put);
  EXPECT_EQ(back->removed, sent.removed);
}

TEST(Commit, IsRefusedNamingTheFieldThatIsBad) {
  const std::vector<std::pair<std::string, std::function<void(v1::Commit&)>>> cases = {
      {"prev_root", [](auto& m) { m.clear_prev_root(); }},
      {"root", [](auto& m) { m.set_root(std::string(31, 'x')); }},
      {"put[1].name", [](auto& m) { m.mutable_put(1)->clear_name(); }},
  };
  for (const auto& [field, spoil] : cases) {
    v1::Commit message;
    toWire(someCommit(), message);
    spoil(message);
    const auto back = fromWire(message);
    ASSERT_FALSE(back) << field;
    EXPECT_EQ(back.error().field, field);
  }
}

TEST(Commit, OfTheMostOperationsFitsAFrame) {
  Commit commit = someCommit();
  ObjectRecord largest = record(3);
  largest.name = std::string(kMaxNameLength, 'x');
  largest.id = largest.revision = std::numeric_limits<std::uint64_t>::max();
  commit.put.assign(kMaxOperations, largest);
  v1::Envelope envelope;
  toWire(commit, *envelope.mutable_commit());
  EXPECT_LT(envelope.ByteSizeLong(), std::size_t{1} << 20);
}

TelemetrySample sample() {
  TelemetrySample s;
  s.tick = 123'456'789'012;
  s.time_ns = 5;
  s.sceneRevision = 6;
  s.adoptionTick = 7;
  s.deformationRevision = 8;
  s.hip = {0.1, 0.2, 0.3};
  s.predictedHip = {0.15, 0.25, 0.35};
  s.ihip = {0.4, 0.5, 0.6};
  s.object = 9;
  s.primitive = {PrimitiveKind::kLine, 2, 4'000'000'000};
  s.penetration_m = 0.7;
  s.surfaceNormal = {0, 0, 1};
  s.frictionState = FrictionState::kSliding;
  s.stickingPoint = {1, 2, 3};
  s.height_m = 0.8;
  s.force = {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}, {5, 0, 0}, {6, 7, 8}};
  s.added_N = {7, 8, 9};
  s.energyGiven_J = {-0.9, 0.01, -0.4, 0.02, 0.3, -0.05};
  s.largestEnergySource = {9, EnergyFeature::kMotion, 0.31};
  s.fault = Fault::kDeviceLost;
  s.deviceState = DeviceState::kStopped;
  s.device = {.fault = DeviceFault::kJumped,
              .homed = false,
              .homedAxes = 5,
              .actions = 5,
              .buttons = 0x80000105,
              .age_us = 4'321};
  s.handle = {{0.1, -0.2, 0.3}, {1, 2, -3}, 0.4, HandleReading::kAll};
  s.depenetrated = 12;
  s.depenetratedFrom = 13;
  s.allowanceSpent = 14;
  s.wait_s = 1.5;
  s.missedTicks = 10;
  s.droppedSamples = 11;
  s.servoRate_Hz = 999.5;
  return s;
}

void expectSame(const TelemetrySample& a, const TelemetrySample& b) {
  EXPECT_EQ(a.tick, b.tick);
  EXPECT_EQ(a.time_ns, b.time_ns);
  EXPECT_EQ(a.sceneRevision, b.sceneRevision);
  EXPECT_EQ(a.adoptionTick, b.adoptionTick);
  EXPECT_EQ(a.deformationRevision, b.deformationRevision);
  EXPECT_EQ(a.hip, b.hip);
  EXPECT_EQ(a.predictedHip, b.predictedHip);
  EXPECT_EQ(a.ihip, b.ihip);
  EXPECT_EQ(a.object, b.object);
  EXPECT_EQ(a.primitive, b.primitive);
  EXPECT_EQ(a.penetration_m, b.penetration_m);
  EXPECT_EQ(a.surfaceNormal, b.surfaceNormal);
  EXPECT_EQ(a.frictionState, b.frictionState);
  EXPECT_EQ(a.stickingPoint, b.stickingPoint);
  EXPECT_EQ(a.height_m, b.height_m);
  EXPECT_EQ(a.force.spring, b.force.spring);
  EXPECT_EQ(a.force.damping, b.force.damping);
  EXPECT_EQ(a.force.friction, b.force.friction);
  EXPECT_EQ(a.force.texture, b.force.texture);
  EXPECT_EQ(a.force.contact, b.force.contact);
  EXPECT_EQ(a.force.written, b.force.written);
  EXPECT_EQ(a.added_N, b.added_N);
  EXPECT_EQ(a.energyGiven_J, b.energyGiven_J);
  EXPECT_EQ(a.largestEnergySource, b.largestEnergySource);
  EXPECT_EQ(a.fault, b.fault);
  EXPECT_EQ(a.deviceState, b.deviceState);
  EXPECT_EQ(a.device, b.device);
  EXPECT_EQ(a.handle, b.handle);
  EXPECT_EQ(a.depenetrated, b.depenetrated);
  EXPECT_EQ(a.depenetratedFrom, b.depenetratedFrom);
  EXPECT_EQ(a.allowanceSpent, b.allowanceSpent);
  EXPECT_EQ(a.wait_s, b.wait_s);
  EXPECT_EQ(a.missedTicks, b.missedTicks);
  EXPECT_EQ(a.droppedSamples, b.droppedSamples);
  EXPECT_EQ(a.servoRate_Hz, b.servoRate_Hz);
}

TEST(Telemetry, ComesBackWhole) {
  v1::Telemetry message;
  toWire(sample(), message);
  expectSame(fromWire(message), sample());
}

TEST(Telemetry, HasOfAHandleWhatItsDeviceMeasures) {
  for (const std::uint64_t bit : {HandleReading::kVelocity, HandleReading::kAppliedForce, HandleReading::kGripper}) {
    TelemetrySample measured = sample();
    measured.handle.measured = bit;
    v1::Telemetry message;
    toWire(measured, message);
    EXPECT_EQ(message.has_device_velocity(), bit == HandleReading::kVelocity);
    EXPECT_EQ(message.has_device_applied_force(), bit == HandleReading::kAppliedForce);
    EXPECT_EQ(message.has_device_gripper_rad(), bit == HandleReading::kGripper);
    EXPECT_EQ(fromWire(message).handle.measured, bit);
  }
}

TEST(Telemetry, LeavesNothingOfTheLastSampleInAReusedMessage) {
  v1::Telemetry message;
  toWire(sample(), message);
  toWire(TelemetrySample{}, message);
  expectSame(fromWire(message), TelemetrySample{});
}

TEST(Telemetry, BodiesComeBackBitForBitAndThoseWithoutAPoseAreLeftOut) {
  const BodyState body{12, Pose{glm::normalize(Quat(0.3, 0.1, 0.7, -0.2)), Vec3(0.1, -1.0 / 3, 2)},
                       BodyCondition::kOutOfBounds};
  v1::Telemetry message;
  toWire(body, *message.add_body());
  message.add_body()->set_object(13);
  toWire(body, *message.add_body());
  message.mutable_body(2)->mutable_pose()->mutable_position()->set_x(std::nan(""));
  toWire(body, *message.add_body());
  message.mutable_body(3)->mutable_pose()->mutable_rotation()->set_w(2);
  toWire(body, *message.add_body());
  message.mutable_body(4)->set_object(0);
  EXPECT_EQ(bodiesFromWire(message), std::vector<BodyState>{body});
  for (int i = 0; i < 100; ++i) toWire(body, *message.add_body());
  EXPECT_EQ(bodiesFromWire(message).size(), kMaxMovingBodies);
  toWire(TelemetrySample{}, message);
  EXPECT_TRUE(bodiesFromWire(message).empty()) << "left in a reused message";
}

TEST(Telemetry, OfAnEmptyMessageIsAnEmptySample) { expectSame(fromWire(v1::Telemetry{}), TelemetrySample{}); }

TEST(Telemetry, IgnoresEnumValuesOfANewerServer) {
  for (const int value : {-1, 7, 1'000}) {
    v1::Telemetry message;
    message.mutable_primitive()->set_kind(static_cast<v1::PrimitiveKind>(value));
    message.set_friction_state(static_cast<v1::FrictionState>(value));
    message.set_fault(static_cast<v1::Fault>(value));
    message.set_device_state(static_cast<v1::DeviceState>(value));
    message.set_device_fault(static_cast<v1::DeviceFault>(value == 7 ? static_cast<int>(kLastDeviceFault) + 1 : value));
    const int newerFeature = value == 7 ? static_cast<int>(kEnergyFeatures) + 1 : value;
    message.add_energy()->set_feature(static_cast<v1::Feature>(newerFeature));
    message.mutable_energy(0)->set_energy_j(5);
    expectSame(fromWire(message), TelemetrySample{});
  }
}

TEST(Telemetry, GivesNoCornerThatATriangleLacks) {
  v1::Telemetry message;
  message.mutable_primitive()->set_kind(v1::PRIMITIVE_KIND_VERTEX);
  message.mutable_primitive()->set_local_index(3);
  EXPECT_EQ(fromWire(message).primitive, PrimitiveId{});
}

TEST(HashFromWire, NamesTheFieldAndTheSize) {
  const auto hash = hashFromWire("abc", "welcome.root");
  ASSERT_FALSE(hash);
  EXPECT_EQ(hash.error().text(), "welcome.root: has 3 bytes; a SHA-256 hash has 32");
}

/// Sets a number of a message by its path, as graphics_client/web/limits.js reads it: the first of a list, and a quaternion by
/// its length.
void setNumber(google::protobuf::Message& message, std::istringstream& path, double value) {
  std::string name;
  std::getline(path, name, '.');
  const auto* field = message.GetDescriptor()->FindFieldByName(name);
  ASSERT_NE(field, nullptr) << name;
  const auto* reflection = message.GetReflection();
  using Field = google::protobuf::FieldDescriptor;
  if (field->is_repeated()) return reflection->SetRepeatedFloat(&message, field, 0, static_cast<float>(value));
  switch (field->cpp_type()) {
    case Field::CPPTYPE_DOUBLE:
      return reflection->SetDouble(&message, field, value);
    case Field::CPPTYPE_FLOAT:
      return reflection->SetFloat(&message, field, static_cast<float>(value));
    case Field::CPPTYPE_UINT32:
      return reflection->SetUInt32(&message, field, static_cast<std::uint32_t>(value));
    default:
      break;
  }
  auto& inner = *reflection->MutableMessage(&message, field);
  if (path.good()) return setNumber(inner, path, value);
  inner.GetReflection()->SetDouble(&inner, inner.GetDescriptor()->FindFieldByName("w"), value);
}

v1::ObjectState deformedState(std::array<std::uint32_t, 3> points) {
  v1::ObjectState message = state(1);
  message.mutable_pose()->mutable_rotation()->Clear();
  message.mutable_pose()->mutable_rotation()->set_w(1);
  auto& deformation = *message.mutable_deformation();
  deformation.mutable_softness()->set_stiffness_n_per_m(100);
  deformation.mutable_softness()->set_radius_m(0.01);
  deformation.mutable_softness()->set_degree(2);
  auto& lattice = *deformation.mutable_lattice();
  lattice.mutable_low_m();
  lattice.mutable_size_m()->set_x(1);
  lattice.mutable_size_m()->set_y(1);
  lattice.mutable_size_m()->set_z(1);
  lattice.set_points_x(points[0]);
  lattice.set_points_y(points[1]);
  lattice.set_points_z(points[2]);
  for (std::uint32_t i = 0; i < 3 * points[0] * points[1] * points[2]; ++i) lattice.add_control_m(0);
  return message;
}

/// The list of what the page checks says what is refused here.
TEST(Limits, OfThePageAreThoseOfTheWire) {
  std::ifstream file(SCENES_FOLDER "/../../graphics_client/web/limits.json");
  const auto limits = nlohmann::json::parse(file);
  EXPECT_GT(limits.size(), 15U);
  for (const auto& [path, range] : limits.items()) {
    const bool isCount = path.find("points_") != std::string::npos || path.find("degree") != std::string::npos;
    const auto isTaken = [&path = path](double value) {
      std::array<std::uint32_t, 3> points{2, 2, 2};
      if (const auto at = path.find("points_"); at != std::string::npos && value <= 100) {
        points[static_cast<std::size_t>(path.back() - 'x')] = static_cast<std::uint32_t>(value);
      }
      v1::ObjectState message = deformedState(points);
      std::istringstream names(path);
      setNumber(message, names, value);
      return fromWire(message).has_value();
    };
    const double least = range[0], most = range[1];
    const auto beyond = [&](double limit, double sign) {
      return isCount ? limit + sign : limit + sign * 1e-3 * std::max(1e-9, std::abs(limit));
    };
    EXPECT_TRUE(isTaken(path == "pose.rotation" ? 0.9991 : least)) << path;
    EXPECT_TRUE(isTaken(path == "pose.rotation" ? 1.0009 : most)) << path;
    EXPECT_FALSE(isTaken(beyond(least, -1))) << path;
    EXPECT_FALSE(isTaken(beyond(most, 1))) << path;
    if (!isCount) {
      EXPECT_FALSE(isTaken(kNaN)) << path;
    }
  }
}

}  // namespace
}  // namespace haptics::convert_state_test
