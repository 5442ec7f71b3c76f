#include "haptic_server/recording/recording_format.h"

#include <bit>
#include <cmath>
#include <limits>

#include "haptic_server/recording/state_image.h"

namespace haptics {
namespace {

constexpr double kMaxRate_Hz = 1e6;

static_assert(sizeof(StepInput) == 96, "what is new in it goes into appendTick() and tickFrom()");
static_assert(sizeof(HandleReading) == 64, "what is new in it goes into appendHandle() and handleFrom()");
static_assert(sizeof(StepConfig) == 216, "what is new in it goes into toMessage() and factsFrom()");

void putWord(std::string& bytes, std::uint64_t word) {
  for (int i = 0; i < 8; ++i) bytes += static_cast<char>(word >> (8 * i));
}
void putVector(std::string& bytes, Vec3 v) {
  for (const double x : {v.x, v.y, v.z}) putWord(bytes, std::bit_cast<std::uint64_t>(x));
}

[[nodiscard]] std::uint64_t takeWord(std::string_view& bytes) {
  std::uint64_t word = 0;
  for (std::size_t i = 8; i-- > 0;) word = word << 8 | static_cast<unsigned char>(bytes[i]);
  bytes.remove_prefix(8);
  return word;
}
[[nodiscard]] Vec3 takeVector(std::string_view& bytes) {
  Vec3 v;
  for (double* x : {&v.x, &v.y, &v.z}) *x = std::bit_cast<double>(takeWord(bytes));
  return v;
}

[[nodiscard]] bool isAtLeastZero(double value) { return std::isfinite(value) && value >= 0; }
[[nodiscard]] bool isPositive(double value) { return std::isfinite(value) && value > 0; }

void setLead(const ObserverSettings& lead, v1::RecordedLead& message) {
  message.set_mass_kg(lead.mass_kg);
  message.set_viscous_friction_ns_per_m(lead.viscousFriction_Ns_per_m);
  message.set_delay_s(lead.delay_s);
  message.set_bandwidth_hz(lead.bandwidth_Hz);
  message.set_contact_lead_s(lead.contactLead_s);
  message.set_hard_bandwidth_hz(lead.hardBandwidth_Hz);
  message.set_soft_up_to_n_per_m(lead.softUpTo_N_per_m);
  message.set_hard_from_n_per_m(lead.hardFrom_N_per_m);
}

[[nodiscard]] Result<ObserverSettings> leadFrom(const v1::RecordedLead& lead) {
  for (const double value : {lead.mass_kg(), lead.viscous_friction_ns_per_m(), lead.delay_s(), lead.contact_lead_s(),
                             lead.soft_up_to_n_per_m()}) {
    if (!isAtLeastZero(value)) return refused("lead", "has a number that is not finite and at least 0");
  }
  if (!isPositive(lead.bandwidth_hz())) return refused("lead.bandwidth_hz", "is not finite and above 0");
  if (!isPositive(lead.hard_bandwidth_hz())) return refused("lead.hard_bandwidth_hz", "is not finite and above 0");
  if (!(lead.hard_from_n_per_m() > lead.soft_up_to_n_per_m()))
    return refused("lead.hard_from_N_per_m", "is not above soft_up_to_N_per_m");
  return ObserverSettings{.mass_kg = lead.mass_kg(),
                          .viscousFriction_Ns_per_m = lead.viscous_friction_ns_per_m(),
                          .delay_s = lead.delay_s(),
                          .bandwidth_Hz = lead.bandwidth_hz(),
                          .hardBandwidth_Hz = lead.hard_bandwidth_hz(),
                          .softUpTo_N_per_m = lead.soft_up_to_n_per_m(),
                          .hardFrom_N_per_m = lead.hard_from_n_per_m(),
                          .contactLead_s = lead.contact_lead_s()};
}

void setConfig(const StepConfig& config, v1::RecordingHead& head) {
  head.set_period_s(config.period_s);
  head.set_max_force_n(config.maxForce_N);
  head.set_position_step_m(config.positionStep_m);
  head.set_stable_lateral_n_per_m(config.stableLateral_N_per_m);
  head.set_rise_s(config.rise_s);
  head.set_max_grip_nm(config.maxGrip_Nm);
  head.set_work_per_s(config.work_per_s);
  if (config.observer) setLead(*config.observer, *head.mutable_lead());
  if (const RotationConfig& rotation = config.rotation; !(rotation == RotationConfig{})) {
    v1::RecordedRotation& message = *head.mutable_rotation();
    message.set_radius_m(rotation.radius_m);
    message.set_max_torque_nm(rotation.maxTorque_Nm);
    if (rotation.observer) setLead(*rotation.observer, *message.mutable_lead());
  }
}

/// What a hand's step is configured with. Refused, without "head.": values that no server has.
[[nodiscard]] Result<StepConfig> configFrom(const v1::RecordingHead& head, double rate_Hz) {
  constexpr double kRounding = 1e-6;
  if (!(std::abs(head.period_s() * rate_Hz - 1) <= kRounding)) return refused("period_s", "is not that of the rate");
  if (!(head.max_force_n() >= 0)) return refused("max_force_N", "is not at least 0");
  if (!(head.position_step_m() >= 0)) return refused("position_step_m", "is not at least 0");
  if (!(head.stable_lateral_n_per_m() >= 0)) return refused("stable_lateral_N_per_m", "is not at least 0");
  const double work_per_s = head.has_work_per_s() ? head.work_per_s() : std::numeric_limits<double>::infinity();
  if (!(work_per_s > 0)) return refused("work_per_s", "is not above 0");
  if (!isAtLeastZero(head.rise_s())) return refused("rise_s", "is not finite and at least 0");
  if (!isAtLeastZero(head.max_grip_nm())) return refused("max_grip_Nm", "is not finite and at least 0");
  StepConfig config;
  config.period_s = head.period_s();
  config.maxForce_N = head.max_force_n();
  config.positionStep_m = head.position_step_m();
  config.stableLateral_N_per_m = head.stable_lateral_n_per_m();
  config.rise_s = head.rise_s();
  config.maxGrip_Nm = head.max_grip_nm();
  config.work_per_s = work_per_s;
  if (head.has_lead()) {
    auto lead = leadFrom(head.lead());
    if (!lead) return tl::unexpected(std::move(lead.error()));
    config.observer = *lead;
  }
  if (head.has_rotation()) {
    const v1::RecordedRotation& rotation = head.rotation();
    if (!isPositive(rotation.radius_m())) return refused("rotation.radius_m", "is not finite and above 0");
    if (!isAtLeastZero(rotation.max_torque_nm()))
      return refused("rotation.max_torque_Nm", "is not finite and at least 0");
    config.rotation = {.radius_m = rotation.radius_m(), .maxTorque_Nm = rotation.max_torque_nm()};
    if (rotation.has_lead()) {
      auto lead = leadFrom(rotation.lead());
      if (!lead) return tl::unexpected(std::move(lead.error()).within("rotation."));
      config.rotation.observer = *lead;
    }
  }
  return config;
}

/// Binds every member: a new one is recorded, or of no concern to ServoSceneBuilder, by decision.
void setLimits(const DeviceLimits& limits, v1::RecordedLimits& message) {
  const auto& [encoderStep_m, stableLateral_N_per_m, period_s, stiffest_N_per_m, maxDamping_Ns_per_m,
               stiffestTorsion_Nm_per_rad, stiffestGrip_Nm_per_rad, hands, observed] = limits;
  message.set_stiffest_n_per_m(stiffest_N_per_m);
  message.set_max_damping_ns_per_m(maxDamping_Ns_per_m);
  message.set_stiffest_torsion_nm_per_rad(stiffestTorsion_Nm_per_rad);
  message.set_stiffest_grip_nm_per_rad(stiffestGrip_Nm_per_rad);
  message.set_hands(static_cast<std::uint32_t>(hands));
  message.set_unobserved(!observed);
}

[[nodiscard]] Result<DeviceLimits> limitsFrom(const v1::RecordedLimits& limits, double period_s) {
  if (!(limits.stiffest_n_per_m() >= 0)) return refused("stiffest_N_per_m", "is not at least 0");
  if (!(limits.max_damping_ns_per_m() >= 0)) return refused("max_damping_Ns_per_m", "is not at least 0");
  if (!(limits.stiffest_torsion_nm_per_rad() >= 0)) return refused("stiffest_torsion_Nm_per_rad", "is not at least 0");
  const double stiffestGrip = limits.has_stiffest_grip_nm_per_rad() ? limits.stiffest_grip_nm_per_rad()
                                                                    : std::numeric_limits<double>::infinity();
  if (!(stiffestGrip >= 0)) return refused("stiffest_grip_Nm_per_rad", "is not at least 0");
  if (limits.hands() < 1 || limits.hands() > kMaxHands)
    return refused("hands", "is not 1 to " + std::to_string(kMaxHands));
  return DeviceLimits{.period_s = period_s,
                      .stiffest_N_per_m = limits.stiffest_n_per_m(),
                      .maxDamping_Ns_per_m = limits.max_damping_ns_per_m(),
                      .stiffestTorsion_Nm_per_rad = limits.stiffest_torsion_nm_per_rad(),
                      .stiffestGrip_Nm_per_rad = stiffestGrip,
                      .hands = static_cast<int>(limits.hands()),
                      .observed = !limits.unobserved()};
}

}  // namespace

v1::RecordingHead toMessage(const RecordingFacts& facts) {
  v1::RecordingHead head;
  head.set_server(facts.server);
  head.set_step_sources(facts.stepSources);
  head.set_state_layout(stateLayout());
  head.set_began_unix_ns(facts.began_unix_ns);
  head.set_device(facts.device);
  head.set_rate_hz(facts.rate_Hz);
  head.set_why(facts.why);
  setConfig(facts.config, head);
  setLimits(facts.limits, *head.mutable_limits());
  if (facts.secondHand) {
    v1::RecordingHead& second = *head.mutable_second_hand();
    second.set_device(facts.secondHand->device);
    setConfig(facts.secondHand->config, second);
  }
  return head;
}

Result<RecordingFacts> factsFrom(const v1::RecordingHead& head) {
  if (!isPositive(head.rate_hz()) || head.rate_hz() > kMaxRate_Hz)
    return refused("head.rate_hz", "is no rate of a servo; it should be above 0 and at most 1e6");
  auto config = configFrom(head, head.rate_hz());
  if (!config) return tl::unexpected(std::move(config.error()).within("head."));
  RecordingFacts facts{.server = head.server(),
                       .stepSources = head.step_sources(),
                       .began_unix_ns = head.began_unix_ns(),
                       .device = head.device(),
                       .rate_Hz = head.rate_hz(),
                       .why = head.why(),
                       .config = *config};
  if (head.has_second_hand()) {
    auto second = configFrom(head.second_hand(), head.rate_hz());
    if (!second) return tl::unexpected(std::move(second.error()).within("head.second_hand."));
    facts.secondHand = HandFacts{head.second_hand().device(), *second};
  }
  facts.isWithoutLimits = !head.has_limits();
  if (head.has_limits()) {
    auto limits = limitsFrom(head.limits(), config->period_s);
    if (!limits) return tl::unexpected(std::move(limits.error()).within("head.limits."));
    facts.limits = *limits;
  }
  return facts;
}

void appendTick(const RecordedTick& tick, std::string& bytes) {
  const DevicePose& device = tick.input.device;
  const DeviceStatus& status = device.status;
  putWord(bytes, tick.input.tick);
  putWord(bytes, tick.input.time_ns);
  putWord(bytes, tick.scene);
  std::uint64_t conditions = 0;
  for (const std::uint8_t byte : {status.actions, static_cast<std::uint8_t>(status.buttons), status.homedAxes,
                                  static_cast<std::uint8_t>(status.homed), static_cast<std::uint8_t>(status.fault),
                                  static_cast<std::uint8_t>(tick.fault), static_cast<std::uint8_t>(device.state)})
    conditions = conditions << 8 | byte;
  putWord(bytes, conditions);
  putWord(bytes, std::uint64_t{status.buttons >> 8} << 32 | status.age_us);
  putVector(bytes, device.position);
  putVector(bytes, tick.force_N);
}

Result<RecordedTick> tickFrom(std::string_view bytes) {
  RecordedTick tick;
  DevicePose& device = tick.input.device;
  tick.input.tick = takeWord(bytes);
  tick.input.time_ns = takeWord(bytes);
  tick.scene = takeWord(bytes);
  const std::uint64_t conditions = takeWord(bytes);
  const auto byte = [conditions](int i) { return static_cast<std::uint8_t>(conditions >> (8 * i)); };
  device.state = static_cast<DeviceState>(byte(0));
  tick.fault = static_cast<Fault>(byte(1));
  const std::uint64_t ageAndButtons = takeWord(bytes);
  const std::uint64_t moreButtons = ageAndButtons >> 32;
  device.status = {.fault = static_cast<DeviceFault>(byte(2)),
                   .homed = byte(3) != 0,
                   .homedAxes = byte(4),
                   .actions = byte(6),
                   .buttons = static_cast<std::uint32_t>(moreButtons << 8 | byte(5)),
                   .age_us = static_cast<std::uint32_t>(ageAndButtons)};
  const bool known = device.state <= DeviceState::kStopped && tick.fault <= Fault::kDeviceLost &&
                     device.status.fault <= kLastDeviceFault && byte(3) <= 1 && byte(6) <= kAllHandActions &&
                     byte(7) == 0 && moreButtons >> 24 == 0;
  if (!known) return refused("ticks", "has a state of the device or a fault that this version does not know");
  device.position = takeVector(bytes);
  tick.force_N = takeVector(bytes);
  return tick;
}

bool turns(const RecordedTick& tick) noexcept {
  const Quat& q = tick.input.device.rotation;
  return q.w != 1 || !sameBits({q.x, q.y, q.z}, Vec3(0)) || !sameBits(tick.torque_Nm, Vec3(0));
}

void appendTurn(const RecordedTick& tick, std::string& bytes) {
  const Quat& q = tick.input.device.rotation;
  putWord(bytes, std::bit_cast<std::uint64_t>(q.w));
  putVector(bytes, {q.x, q.y, q.z});
  putVector(bytes, tick.torque_Nm);
}

void takeTurn(std::string_view bytes, RecordedTick& tick) {
  const double w = std::bit_cast<double>(takeWord(bytes));
  const Vec3 v = takeVector(bytes);
  tick.input.device.rotation = {w, v.x, v.y, v.z};
  tick.torque_Nm = takeVector(bytes);
}

void appendHandle(const HandleReading& handle, std::string& bytes) {
  putVector(bytes, handle.velocity);
  putVector(bytes, handle.appliedForce_N);
  putWord(bytes, std::bit_cast<std::uint64_t>(handle.gripper_rad));
  putWord(bytes, handle.measured);
}

Result<HandleReading> handleFrom(std::string_view bytes) {
  HandleReading handle;
  handle.velocity = takeVector(bytes);
  handle.appliedForce_N = takeVector(bytes);
  handle.gripper_rad = std::bit_cast<double>(takeWord(bytes));
  handle.measured = takeWord(bytes);
  if (handle.measured > HandleReading::kAll)
    return refused("ticks.handles", "has a measurement that this version does not know");
  return handle;
}

void appendWrench(const Wrench& wrench, std::string& bytes) {
  putVector(bytes, wrench.force_N);
  putVector(bytes, wrench.torque_Nm);
}

Wrench wrenchFrom(std::string_view bytes) {
  const Vec3 force_N = takeVector(bytes);
  return {force_N, takeVector(bytes)};
}

void appendGrip(double moment_Nm, std::string& bytes) { putWord(bytes, std::bit_cast<std::uint64_t>(moment_Nm)); }

double gripFrom(std::string_view bytes) { return std::bit_cast<double>(takeWord(bytes)); }

bool wroteSame(const RecordedTick& tick, Vec3 force_N, Vec3 torque_Nm, double grip_Nm) noexcept {
  return sameBits(tick.force_N, force_N) && sameBits(tick.torque_Nm, torque_Nm) &&
         std::bit_cast<std::uint64_t>(tick.grip_Nm) == std::bit_cast<std::uint64_t>(grip_Nm);
}

bool sameBits(Vec3 a, Vec3 b) noexcept {
  const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x); };
  return bits(a.x) == bits(b.x) && bits(a.y) == bits(b.y) && bits(a.z) == bits(b.z);
}

}  // namespace haptics
