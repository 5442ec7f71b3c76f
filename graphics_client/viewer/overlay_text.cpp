#include "graphics_client/viewer/overlay_text.h"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <map>
#include <set>
#include <utility>

#include "common/telemetry/fault_words.h"
#include "common/text/printable.h"
#include "graphics_client/viewer/effect_lines.h"

namespace haptics {
namespace {

constexpr double kMillimetresPerMetre = 1e3;
constexpr double kMillisecondsPerSecond = 1e3;
/// Names longer than this are shortened, so that they stay on the panel (characters).
constexpr std::size_t kLongestName = 26;
const std::string kNothing = "-";

[[gnu::format(printf, 1, 2)]] std::string formatted(const char* format, ...) {
  char text[160];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

std::string shortened(const std::string& name, std::size_t longest = kLongestName) {
  std::string text = printable(name);
  if (text.size() <= longest) return text;
  std::size_t end = longest - 3;
  while ((static_cast<unsigned char>(text[end]) & 0xc0U) == 0x80) --end;  // not within a character
  return text.substr(0, end) + "...";
}

OverlayLine linkLine(const MirrorView& view) {
  switch (view.link) {
    case LinkState::kLive:
      return {"Link", view.isReplay ? "a replay" : "live", Tone::kGood};
    case LinkState::kSyncing:
      return {"Link", "receiving the scene", Tone::kWarning};
    case LinkState::kRefused:
      return {"Link", "refused", Tone::kBad};
    case LinkState::kClosed:
      return {"Link", "not connected", Tone::kWarning};
    case LinkState::kConnecting:
      break;
  }
  return {"Link", "connecting", Tone::kWarning};
}

OverlayLine faultOrRate(const TelemetrySample& sample) {
  switch (sample.fault) {
    case Fault::kNone:
      return {"Servo", formatted("%.0f Hz", sample.servoRate_Hz), Tone::kPlain};
    case Fault::kNonFiniteInput:
      return {"Servo", "FAULT: impossible position", Tone::kBad};
    case Fault::kNonFiniteForce:
      return {"Servo", "FAULT: force not finite", Tone::kBad};
    case Fault::kDeadlinesMissed:
      return {"Servo", "FAULT: deadlines missed" + waitInWords(sample.wait_s), Tone::kBad};
    case Fault::kDeviceStale:
      return {"Servo", "FAULT: device stale", Tone::kBad};
    case Fault::kDeviceLost:
      if (sample.deviceState == DeviceState::kHoming) return {"Servo", "no force before homing", Tone::kWarning};
      return {"Servo", "FAULT: device lost", Tone::kBad};
  }
  return {"Servo", kNothing, Tone::kPlain};
}

OverlayLine deviceLine(const MirrorView& view) {
  if (view.sample && view.sample->device.fault != DeviceFault::kNone) {
    return {"Device", inWords(view.sample->device.fault), Tone::kBad};
  }
  if (view.sample && view.sample->deviceState == DeviceState::kHoming) {
    return {"Device", "wants to be homed", Tone::kWarning};
  }
  return {"Device", view.device.empty() ? kNothing : shortened(view.device)};
}

constexpr double kDegreesPerRadian = 57.29577951308232;

/// What the hand does with the handle, of a device that measures it or has buttons; none of others.
std::optional<OverlayLine> handleLine(const TelemetrySample& sample) {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  const bool clutched = sample.device.does(HandAction::kClutch);
  if (clutched) add("clutched");
  if (sample.device.does(HandAction::kMark)) add("marks");
  for (unsigned bit = 0; bit < 32; ++bit) {
    if ((sample.device.buttons >> bit & 1U) != 0) add(formatted("button %u", bit));
  }
  if (sample.handle.has(HandleReading::kGripper))
    add(formatted("gripper %.1f deg", sample.handle.gripper_rad * kDegreesPerRadian));
  if (sample.handle.has(HandleReading::kVelocity))
    add(formatted("%.0f mm/s", glm::length(sample.handle.velocity) * kMillimetresPerMetre));
  if (sample.handle.has(HandleReading::kAppliedForce))
    add(formatted("applies %.2f N", glm::length(sample.handle.appliedForce_N)));
  if (text.empty()) return std::nullopt;
  return OverlayLine{"Handle", text, clutched ? Tone::kWarning : Tone::kPlain};
}

OverlayLine hashLine(const MirrorView& view) {
  if (view.link != LinkState::kLive) return {"Scene hash", "not compared", Tone::kWarning};
  const std::string start = view.scene->root().hex().substr(0, 8);
  return view.hashesEqual ? OverlayLine{"Scene hash", start + "  equal", Tone::kGood}
                          : OverlayLine{"Scene hash", start + "  NOT equal", Tone::kBad};
}

std::string objectName(const MirrorView& view, std::uint64_t id) {
  if (id == 0) return kNothing;
  const SceneVersion::Object object = view.scene->find(id);
  return object ? shortened(object->name) : "object " + std::to_string(id);
}

std::string primitiveName(const PrimitiveId& primitive) {
  switch (primitive.kind) {
    case PrimitiveKind::kNone:
      break;
    case PrimitiveKind::kPolygon:
      return formatted("polygon %u", primitive.polygon);
    case PrimitiveKind::kLine:
      return formatted("line %u of polygon %u", primitive.localIndex, primitive.polygon);
    case PrimitiveKind::kVertex:
      return formatted("vertex %u of polygon %u", primitive.localIndex, primitive.polygon);
  }
  return kNothing;
}

std::string components(Vec3 v, double scale) {
  return formatted("%+.2f  %+.2f  %+.2f", v.x * scale, v.y * scale, v.z * scale);
}

OverlayLine detailLine(const std::optional<CoarseDetail>& coarse, bool pitsFeltAsBumps) {
  if (pitsFeltAsBumps) return {"Surfaces", "pits drawn, felt as bumps", Tone::kWarning};
  if (!coarse) return {"Surfaces", "drawn as felt"};
  return {"Surfaces",
          formatted("felt %.2g, drawn %.2g mm", coarse->detail_m * kMillimetresPerMetre,
                    coarse->edge_m * kMillimetresPerMetre),
          Tone::kWarning};
}

std::string frictionText(const TelemetrySample& sample) {
  if (sample.frictionState == FrictionState::kNone) return kNothing;
  return formatted("%s, %.2f N", sample.frictionState == FrictionState::kSticking ? "sticking" : "sliding",
                   glm::length(sample.force.friction));
}

std::string textureText(const MirrorView& view, const TelemetrySample& sample) {
  const SceneVersion::Object object = view.scene->find(sample.object);
  if (!object || !object->material.surface.texture) return kNothing;
  return formatted("%+.2f mm, %.2f N", sample.height_m * kMillimetresPerMetre, glm::length(sample.force.texture));
}

OverlayLine secondHandLine(const MirrorView& view, const TelemetrySample& sample) {
  if (sample.fault != Fault::kNone) return {"Hand 2", "FAULT, no force", Tone::kBad};
  const std::string force = formatted("%.2f N", glm::length(sample.force.written));
  if (sample.object == 0) return {"Hand 2", force};
  return {"Hand 2", force + " on " + objectName(view, sample.object), Tone::kGood};
}

/// How many there are, and how many of them the servo moves now.
std::string objectCount(const MirrorView& view) {
  std::string total = std::to_string(view.scene->objects().size());
  if (view.bodies.empty()) return total;
  const auto awake = std::ranges::count_if(
      view.bodies, [](const auto& entry) { return entry.second.condition == BodyCondition::kAwake; });
  return total + ", " + std::to_string(awake) + " moving";
}

/// The first of the bodies that were stopped for good.
std::string stoppedBody(const MirrorView& view) {
  const auto stopped =
      std::ranges::find_if(view.bodies, [](const auto& entry) { return isStopped(entry.second.condition); });
  if (stopped == view.bodies.end()) return {};
  const bool lost = stopped->second.condition == BodyCondition::kOutOfBounds;
  return objectName(view, stopped->first) +
         (lost ? " left the world's bounds and was stopped" : " was stopped: its motion was not finite") +
         "; set its pose to put it back";
}

/// Telemetry says so little that the link must be bad, though no connection was lost.
bool isStale(const MirrorView& view, double age_s) { return view.sample && age_s > kStaleTelemetry_s; }

/// Of a tool; what the device gives of it, where it gives any.
std::string torqueText(double torque_Nm, double written_Nm) {
  constexpr double kMilli = 1e3;
  return formatted("%.1f mNm", kMilli * torque_Nm) +
         (written_Nm != 0 ? formatted(", %.1f given", kMilli * written_Nm) : "");
}

}  // namespace

bool isCurrent(const MirrorView& view, double age_s) {
  return view.link == LinkState::kLive && view.sample && !isStale(view, age_s);
}

std::vector<OverlayLine> statusLines(const MirrorView& view, double age_s, double framesPerSecond,
                                     const std::optional<CoarseDetail>& coarse, bool pitsFeltAsBumps) {
  const TelemetrySample none;
  const TelemetrySample& sample = view.sample.value_or(none);
  const std::size_t known = static_cast<std::size_t>(std::ranges::count_if(
      view.scene->objects(), [&](const SceneVersion::Object& o) { return view.meshes.contains(o->mesh); }));
  const std::size_t total = view.scene->objects().size();
  const bool heard = view.sample.has_value();
  std::vector<OverlayLine> lines{
      linkLine(view),
      {"Server", view.serverName.empty() ? kNothing : shortened(view.serverName)},
      deviceLine(view),
      heard ? faultOrRate(sample) : OverlayLine{"Servo", kNothing},
      {"Missed ticks", heard ? std::to_string(sample.missedTicks) : kNothing},
      {"Telemetry age",
       heard ? formatted("%.1f ms", age_s * kMillisecondsPerSecond) + (view.telemetryByDatagram ? " by UDP" : "")
             : kNothing,
       isStale(view, age_s) ? Tone::kWarning : Tone::kPlain},
      {"Revision", heard ? formatted("%llu, felt: %llu", static_cast<unsigned long long>(view.scene->revision()),
                                     static_cast<unsigned long long>(sample.sceneRevision))
                         : std::to_string(view.scene->revision())},
      hashLine(view),
      {"Objects", known == total ? objectCount(view) : formatted("%zu of %zu received", known, total),
       known == total ? Tone::kPlain : Tone::kWarning},
      {"Picture", framesPerSecond >= kIdleRate_Hz ? formatted("%.0f frames/s", framesPerSecond) : "idle"},
      detailLine(coarse, pitsFeltAsBumps),
  };
  if (sample.depenetrated > 0) {
    lines.push_back({"IHIP depenetrated",
                     formatted("%llu times, last from ", static_cast<unsigned long long>(sample.depenetrated)) +
                         objectName(view, sample.depenetratedFrom),
                     Tone::kWarning});
  }
  if (sample.allowanceSpent > 0) {
    lines.push_back({"Allowance",
                     formatted("spent in %llu ticks", static_cast<unsigned long long>(sample.allowanceSpent)),
                     Tone::kWarning});
  }
  return lines;
}

std::vector<OverlayLine> contactLines(const MirrorView& view) {
  const TelemetrySample none;
  const TelemetrySample& sample = view.sample.value_or(none);
  if (!view.sample) {
    return {{"Force", kNothing},    {"x y z (N)", kNothing}, {"Limit", kNothing},
            {"Contact", kNothing},  {"On", kNothing},        {"Penetration", kNothing},
            {"Friction", kNothing}, {"Texture", kNothing},   {"HIP (mm)", kNothing}};
  }
  const double force_N = glm::length(sample.force.written);
  const bool touching = sample.object != 0;
  const bool atLimit = view.maxForce_N > 0 && force_N >= 0.99 * view.maxForce_N;
  std::vector<OverlayLine> lines{
      {"Force", formatted("%.2f N", force_N) + (atLimit ? "  (at the limit)" : ""),
       atLimit ? Tone::kWarning : Tone::kPlain},
      {"x y z (N)", components(sample.force.written, 1)},
      {"Limit", view.maxForce_N > 0 ? formatted("%.1f N", view.maxForce_N) : kNothing},
      {"Contact", touching ? objectName(view, sample.object) : "none", touching ? Tone::kGood : Tone::kPlain},
      {"On", primitiveName(sample.primitive)},
      {"Penetration", touching ? formatted("%.2f mm", sample.penetration_m * kMillimetresPerMetre) : kNothing},
      {"Friction", frictionText(sample)},
      {"Texture", textureText(view, sample)},
      {"HIP (mm)", formatted("%+.1f  %+.1f  %+.1f", sample.hip.x * kMillimetresPerMetre,
                             sample.hip.y * kMillimetresPerMetre, sample.hip.z * kMillimetresPerMetre)},
  };
  if (view.tool) {
    lines.push_back({"Torque", torqueText(glm::length(view.tool->torque_Nm), glm::length(view.tool->written_Nm))});
  }
  if (view.tool && view.tool->grip) {
    const ToolState::Grip& grip = *view.tool->grip;
    lines.push_back({"Jaws", formatted("%.1f deg", grip.opening_rad * kDegreesPerRadian)});
    lines.push_back({"Grip", torqueText(grip.moment_Nm, grip.written_Nm)});
  }
  if (const auto handle = handleLine(sample)) lines.push_back(*handle);
  if (view.secondHand) lines.push_back(secondHandLine(view, *view.secondHand));
  return lines;
}

std::string overlayTip(const std::string& label) {
  static const std::map<std::string, std::string> tips = {
      {"Link", "The connection to the server"},
      {"Server", "The server's own name"},
      {"Device", "The device that the server drives"},
      {"Servo", "How often a second the server computes the force; nominally 1000"},
      {"Missed ticks", "Times that the servo was late by a whole period, since the server's start"},
      {"Telemetry age", "How old the shown position and force are"},
      {"Revision", "Edits of the scene so far; felt: the one that the hand feels now"},
      {"Scene hash",
       "First digits of the SHA-256 over the scene that is shown; equal: it is the server's, bit for bit"},
      {"Objects", "Objects of the scene, and how many of them move now"},
      {"Picture", "Pictures drawn a second; idle: nothing changes, so nothing is drawn"},
      {"Surfaces", "Whether waves are felt that are too fine to be drawn"},
      {"IHIP depenetrated", "Times that the contact was put out of an object into which it had got"},
      {"Allowance", "Ticks whose work did not fit into their time; the rest came with the next tick"},
      {"Force", "What the device is told to exert on the hand"},
      {"x y z (N)", "The force in the world's axes"},
      {"Limit", "The largest force of the device; a press that is asked for gets less, 1/1.2 of it"},
      {"Contact", "The object that is touched"},
      {"On", "The polygon, line or vertex of its mesh that is touched"},
      {"Penetration", "How deep the hand is: from the HIP to the IHIP"},
      {"Friction", "Whether the contact sticks or slides, and the friction's part of the force"},
      {"Texture", "Height of the texture under the contact, and its part of the force"},
      {"HIP (mm)", "Where the device has the hand, in the world's axes"},
      {"Torque", "What turns the held tool, and how much of it the device gives"},
      {"Jaws", "How far those of the held tool are open"},
      {"Grip", "What opens the gripper, and how much of it the device gives"},
      {"Hand 2", "The second hand's force, and the object that it touches"}};
  const auto at = tips.find(label);
  return at == tips.end() ? std::string() : at->second;
}

std::vector<OverlayLine> withoutDetails(std::vector<OverlayLine> lines) {
  static const std::set<std::string> kDetails = {"Server",   "Missed ticks", "Telemetry age",
                                                 "Revision", "Scene hash",   "Surfaces"};
  std::erase_if(lines, [](const OverlayLine& line) {
    return kDetails.contains(line.label) && line.tone != Tone::kWarning && line.tone != Tone::kBad;
  });
  return lines;
}

std::vector<LegendRow> effectLegend(const MirrorView& view) {
  const std::array all{LegendRow{palette::kPulls, {"Pulls", "springs, guides, magnets"}},
                       LegendRow{palette::kKeepsOut, {"Blocks", "forbidden sides, tubes"}},
                       LegendRow{palette::kDrags, {"Drags", "viscosity, inertia"}},
                       LegendRow{palette::kActs, {"Acts", "pushes, vibrations, textures"}}};
  std::vector<LegendRow> rows;
  for (const LegendRow& row : all) {
    const auto isSo = [&](const Effect& effect) { return effectShade(effect.kind) == row.dot; };
    const bool isThere = std::ranges::any_of(
        view.scene->objects(), [&](const auto& object) { return std::ranges::any_of(object->effects, isSo); });
    if (isThere) rows.push_back(row);
  }
  return rows;
}

Banner bannerFor(const MirrorView& view, double age_s, bool wasLive, bool stateWasReset) {
  const std::string linkText = printable(view.linkText);
  if (view.link == LinkState::kRefused) return {linkText, Tone::kBad};
  if (view.link != LinkState::kLive && view.link != LinkState::kClosed && wasLive) {
    return {"LINK LOST: showing the last known state; " + (linkText.empty() ? std::string("reconnecting") : linkText),
            Tone::kBad};
  }
  if (view.link == LinkState::kConnecting || view.link == LinkState::kClosed) {
    return {linkText.empty() ? "Connecting" : linkText, Tone::kWarning};
  }
  if (view.link == LinkState::kSyncing) return {"Receiving the scene", Tone::kWarning};
  if (stateWasReset) return {"The server was restarted: its state was reset", Tone::kWarning};
  if (isStale(view, age_s)) return {"No news from the servo: the picture is not current", Tone::kWarning};
  if (std::string stopped = stoppedBody(view); !stopped.empty()) return {std::move(stopped), Tone::kWarning};
  return {};
}

const std::vector<OverlayLine>& controlLines() {
  static const std::vector<OverlayLine> lines = {
      {"press", "on an object: touch it"},
      {"wheel", "then: press harder; else: zoom"},
      {"right drag", "orbit; middle: pan"},
      {"t", "touch in space, or on surfaces"},
      {"g", "move, turn the selected one"},
      {"Esc", "let go of the hand"},
      {"r", "show all"},
      {"F1", "all keys; h: hide these"},
  };
  return lines;
}

}  // namespace haptics
