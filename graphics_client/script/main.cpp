#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/command_line/command_line.h"
#include "graphics_client/mirror/client_program.h"
#include "graphics_client/script/verbs.h"

namespace {

/// Of `watch`: a sample in a quarter of an hour.
constexpr double kMinRate_Hz = 0.001;

using namespace haptics;

constexpr double kMaxTimeout_s = 86'400;
constexpr double kMaxTelemetryRate_Hz = 1000;  // the server sends no faster

void addCommonOptions(Command& app, CommonOptions& common) {
  addServerOptions(app, common.server, common.credentials, "viewer.credentials or editor.credentials");
  app.option("--timeout", common.timeout_s,
             "Give up after this time without a connection or news of what is waited for")
      .typeName("SECONDS")
      .range(0.1, kMaxTimeout_s)
      .showDefault();
  app.flag("--json", common.json, "Results as JSON, for scripts");
}

Command addApply(Command& app, ApplyOptions& options) {
  Command verb = app.verb("apply", "Change the scene: all operations of a scene file, or none");
  verb.option("scene", options.scene, "Scene file (protobuf text format); - reads standard input")
      .typeName("FILE")
      .required();
  verb.list(
          "--upload",
          [&options](const std::string& pair) -> Result<void> {
            const auto middle = pair.find('=');
            if (middle == std::string::npos) return refused("", pair + ": should be NAME=FILE");
            options.uploads[pair.substr(0, middle)] = pair.substr(middle + 1);
            return {};
          },
          "Send a file of this machine: what the scene calls file or image: \"NAME\" is FILE here. What lies beside "
          "the scene "
          "by its name is sent by itself")
      .typeName("NAME=FILE");
  verb.footer(
      "Waits until the change is felt and says from which tick on.\n\n"
      "Examples:\n"
      "  hapticctl apply table.scene\n"
      "  echo 'operations { set_material { object { name: \"torus\" } material { stiffness_N_per_m: 400 } } }' \\\n"
      "    | hapticctl apply -\n"
      "  echo 'operations { add { name: \"cup\" mesh { file: \"cup\" unit_m: 0.001 } } }' \\\n"
      "    | hapticctl apply - --upload cup=models/cup.stl");
  return verb;
}

Command addGet(Command& app, std::string& name) {
  Command verb = app.verb("get", "Print the scene as a file that apply takes");
  verb.option("name", name, "Only this object").typeName("NAME");
  verb.footer(
      "Into a file, it writes meshes and other assets beside it, and any server, World or client opens it. Elsewhere "
      "they are\n"
      "named by their hash, for this server alone.\n\n"
      "Examples:\n  hapticctl get > now.scene\n  hapticctl --json get torus");
  return verb;
}

Command addWatch(Command& app, WatchOptions& options) {
  Command verb = app.verb("watch", "Print what the servo feels, a line for each sample");
  const Option rate = verb.option("--rate", options.rate_Hz, "Samples a second")
                          .typeName("HZ")
                          .range(kMinRate_Hz, kMaxTelemetryRate_Hz)
                          .showDefault();
  verb.option("--seconds", options.duration_s, "Stop after this time (default: at Ctrl-C)")
      .typeName("SECONDS")
      .range(0.0, kMaxTimeout_s);
  const Option udp = verb.flag("--udp", options.datagrams,
                               "By UDP where the server offers it (without TLS) and the network lets it through");
  verb.flag("--every-tick", options.everyTick, "Every tick, and on standard error each gap and why it is there")
      .excludes(rate)
      .excludes(udp);
  verb.footer(
      "Examples:\n  hapticctl watch\n  hapticctl --json watch --rate 100 --seconds 5 > forces.jsonl\n"
      "  hapticctl --json watch --every-tick --seconds 5 > ticks.jsonl");
  return verb;
}

/// Three numbers with commas between them, as the server takes a force or a torque.
TextTaker threeNumbers(Vec3& value, double most) {
  return [&value, most](const std::string& text) -> Result<void> {
    Vec3 read(0);
    char rest = 0;
    const bool isSound = std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &read.x, &read.y, &read.z, &rest) == 3;
    const auto fits = [most](double number) { return number >= -most && number <= most; };
    if (!isSound || !fits(read.x) || !fits(read.y) || !fits(read.z))
      return refused("",
                     text + ": give three numbers such as 0,0,-1.5, each within " + std::to_string(std::lround(most)));
    value = read;
    return {};
  };
}

Command addPush(Command& app, PushOptions& options) {
  constexpr double kMaxForce_N = 100, kMaxTorque_Nm = 10;  // as the server
  Command verb =
      app.verb("push", "Add a force to what the scene gives the hand, for a while, and say what it had of it");
  verb.option("force", threeNumbers(options.wrench.force_N, kMaxForce_N), "Newtons, in the scene's frame")
      .typeName("X,Y,Z")
      .required();
  verb.option("--torque", threeNumbers(options.wrench.torque_Nm, kMaxTorque_Nm),
              "Besides, Nm, of a device that gives torques")
      .typeName("X,Y,Z");
  verb.option("--seconds", options.duration_s, "Then it goes, as it does at Ctrl-C")
      .typeName("SECONDS")
      .range(0.1, kMaxTimeout_s)
      .showDefault();
  verb.option("--hand", options.hand, "Which one").typeName("N").range(1, 2).showDefault();
  verb.footer(
      "It comes and goes at 30 N/s, no device gets more than it bears, and a fault ends it. On a real device: begin "
      "with\n"
      "half a newton, and hold the grip.\n\n"
      "Examples:\n  hapticctl push 0,0,-1\n  hapticctl push 0.5,0,0 --seconds 5");
  return verb;
}

/// The format that a file's name says, if any.
std::optional<ExportFormat> formatOf(const std::filesystem::path& file) {
  static const std::map<std::string, ExportFormat> kByEnding{{".h5", ExportFormat::kHdf5},
                                                             {".hdf5", ExportFormat::kHdf5},
                                                             {".csv", ExportFormat::kCsv},
                                                             {".mcap", ExportFormat::kMcap}};
  std::string ending = file.extension().string();
  for (char& letter : ending) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  const auto found = kByEnding.find(ending);
  return found == kByEnding.end() ? std::nullopt : std::optional(found->second);
}

Command addExport(Command& app, ExportOptions& options) {
  static const std::map<std::string, ExportFormat> kByName{
      {"hdf5", ExportFormat::kHdf5}, {"csv", ExportFormat::kCsv}, {"mcap", ExportFormat::kMcap}};
  Command verb = app.verb("export", "Write every tick of a recording, or of a running server, as HDF5, CSV or MCAP");
  const Option recording = verb.option("recording", options.recording, "A recording of the server; without it --live")
                               .typeName("RECORDING")
                               .existingFile();
  verb.option("--out", options.out, "The file; ends with .h5, .csv or .mcap, or --format says what it is")
      .typeName("FILE")
      .required();
  const Option format = verb.choice("--format", options.format, kByName, "hdf5, csv or mcap").typeName("FORMAT");
  const Option live = verb.flag("--live", options.live, "Of the running server, from now on").excludes(recording);
  verb.option("--seconds", options.duration_s, "Of a live session; Ctrl-C ends it before, with what there is")
      .typeName("SECONDS")
      .range(0.1, kMaxTimeout_s)
      .needs(live)
      .showDefault();
  verb.then([&options, recording, format, live]() -> Result<void> {
    if (!recording.given() && !live.given()) return refused("", "a recording, or --live is required");
    const auto byName = formatOf(options.out);
    if (!format.given() && !byName)
      return refused("--out: " + options.out.string(), "ends with none of .h5, .csv, .mcap; give --format");
    if (!format.given()) options.format = *byName;
    if (byName && *byName != options.format)
      return refused("--out: " + options.out.string(), "ends otherwise than --format says; leave --format out");
    return {};
  });
  verb.footer(
      "A file is whole or is not there: it is written as FILE.part. Ticks that are missing are counted, and in HDF5 "
      "listed. Where the server of a live session goes away or restarts, the file ends there and notes why; the exit "
      "status is then 3.\n\n"
      "Examples:\n"
      "  hapticctl export session.recording --out session.h5\n"
      "  hapticctl export session.recording --out session.mcap\n"
      "  hapticctl export --live --seconds 60 --out session.csv");
  return verb;
}

Command addPlot(Command& app, PlotOptions& options) {
  Command verb = app.verb("plot", "Draw a recording: force, penetration, path, spectrum, energy by cause");
  verb.option("recording", options.recording, "A recording of the server, or what export made of one as HDF5")
      .typeName("RECORDING")
      .required()
      .existingFile();
  verb.option("--out", options.out, "The picture; .png, .svg or .pdf").typeName("FILE").required();
  verb.option("--title", options.title, "Above it (default: the recording's name)").typeName("TEXT");
  verb.footer(
      "Examples:\n  hapticctl plot session.recording --out session.png\n  hapticctl plot session.h5 --out session.svg");
  return verb;
}

/// Of "1,2.5", so many as `into` names.
Result<void> takeNumbers(const std::string& text, const std::vector<std::function<void(double)>>& into) {
  const char* at = text.data();
  const char* const end = at + text.size();
  for (std::size_t i = 0; i < into.size(); ++i) {
    double number = 0;
    const auto [after, error] = std::from_chars(at, end, number);
    const bool isLast = i + 1 == into.size();
    if (error != std::errc() || (isLast ? after != end : after == end || *after != ','))
      return refused("", text + ": should be " + std::to_string(into.size()) + " numbers with commas between them");
    into[i](number);
    at = after + 1;
  }
  return {};
}

/// Bits of "0,3"; none of "none".
Result<std::uint32_t> buttonsFrom(const std::string& text) {
  std::uint32_t bits = 0;
  if (text == "none") return bits;
  constexpr unsigned kButtons = 32;
  const char* const end = text.data() + text.size();
  for (const char* at = text.data();; ++at) {
    unsigned button = 0;
    const auto [after, error] = std::from_chars(at, end, button);
    if (error != std::errc() || button >= kButtons || (after != end && *after != ','))
      return refused("", text + ": should be numbers of buttons, 0 to 31, with commas between them, or none");
    bits |= 1U << button;
    if (after == end) return bits;
    at = after;
  }
}

Command addWorkspace(Command& app, v1::SetWorkspace& asked) {
  Command verb = app.verb("workspace", "Move a hand's workspace while it is felt, and bind its buttons");
  verb.option(
          "--hand",
          [&asked](const std::string& text) -> Result<void> {
            if (text != "1" && text != "2") return refused("", text + ": should be 1 or 2");
            asked.set_hand(text == "2" ? 1 : 0);
            return {};
          },
          "Of the server's first or second hand")
      .typeName("1|2")
      .showDefault("1");
  verb.option(
          "--offset",
          [&asked](const std::string& text) {
            v1::Vector3& to = *asked.mutable_offset();
            return takeNumbers(
                text, {[&](double x) { to.set_x(x); }, [&](double y) { to.set_y(y); }, [&](double z) { to.set_z(z); }});
          },
          "Where its origin glides, metres")
      .typeName("X,Y,Z");
  verb.option(
          "--scale",
          [&asked](const std::string& text) {
            return takeNumbers(text, {[&](double scale) { asked.set_scale(scale); }});
          },
          "Metres of the scene per metre of the hand, 0.1 to 10")
      .typeName("S");
  verb.option(
          "--rotation",
          [&asked](const std::string& text) {
            v1::Quaternion& to = *asked.mutable_rotation();
            return takeNumbers(text, {[&](double w) { to.set_w(w); }, [&](double x) { to.set_x(x); },
                                      [&](double y) { to.set_y(y); }, [&](double z) { to.set_z(z); }});
          },
          "As a unit quaternion")
      .typeName("W,X,Y,Z");
  const auto bind = [&](const std::string& name, void (v1::SetWorkspace::*set)(std::uint32_t),
                        const std::string& about) {
    verb.option(
            name,
            [&asked, set](const std::string& text) -> Result<void> {
              const auto bits = buttonsFrom(text);
              if (!bits) return tl::unexpected(bits.error());
              (asked.*set)(*bits);
              return {};
            },
            about)
        .typeName("N,..|none");
  };
  bind("--clutch", &v1::SetWorkspace::set_clutch_buttons, "Buttons with which the workspace moves with the hand");
  bind("--grasp", &v1::SetWorkspace::set_grasp_buttons, "Buttons with which the hand holds the body that it touches");
  bind("--mark", &v1::SetWorkspace::set_mark_buttons, "Buttons that mark the recording");
  bind("--next-tool", &v1::SetWorkspace::set_next_tool_buttons, "Buttons that give the hand the scene's next tool");
  verb.option(
          "--bubble",
          [&asked](const std::string& text) {
            v1::Bubble& to = *asked.mutable_bubble();
            v1::Vector3& centre = *to.mutable_centre();
            return takeNumbers(text,
                               {[&](double x) { centre.set_x(x); }, [&](double y) { centre.set_y(y); },
                                [&](double z) { centre.set_z(z); }, [&](double radius) { to.set_radius_m(radius); }});
          },
          "Beyond this sphere of the device the workspace moves by itself; radius 0: none")
      .typeName("X,Y,Z,RADIUS");
  verb.footer(
      "What is not given stays as it is. Examples:\n"
      "  hapticctl workspace --scale 2 --offset 0.05,0,0 --clutch 0\n"
      "  hapticctl workspace --hand 2 --grasp 0 --mark 1\n"
      "  hapticctl workspace --bubble 0,0,0.05,0.04");
  return verb;
}

Command addCredentials(Command& app, std::string& folder) {
  Command verb = app.verb("credentials", "Make a server's certificate and its clients' tokens; no server needed");
  verb.option("folder", folder, "Where to; made if missing").typeName("DIR").required();
  verb.footer(
      "Then, on the server's machine:  haptic_server --listen 192.168.1.5:7654 --credentials DIR\n"
      "and on the others, with a copy of DIR/viewer.credentials or DIR/editor.credentials:\n"
      "  hapticctl --connect 192.168.1.5:7654 --credentials editor.credentials status");
  return verb;
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app("Scripted client of haptic_server", "hapticctl");
  app.version("hapticctl " HAPTICS_VERSION);
  app.needVerb();
  app.takeOptionsAfterVerbs();
  app.footer(
      "Exits with 0 when done, 1 when refused or not equal, 2 for wrong usage, 3 without a connection, 130 at Ctrl-C.\n"
      "hapticctl VERB --help shows examples.");
  CommonOptions common;
  ApplyOptions applyOptions;
  WatchOptions watchOptions;
  PushOptions pushOptions;
  ExportOptions exportOptions;
  PlotOptions plotOptions;
  v1::SetWorkspace workspaceAsked;
  std::string name, folder;
  addCommonOptions(app, common);
  const Command applyVerb = addApply(app, applyOptions);
  const Command getVerb = addGet(app, name);
  const Command watchVerb = addWatch(app, watchOptions);
  const Command pushVerb = addPush(app, pushOptions);
  const Command exportVerb = addExport(app, exportOptions);
  const Command plotVerb = addPlot(app, plotOptions);
  const Command workspaceVerb = addWorkspace(app, workspaceAsked);
  const Command credentialsVerb = addCredentials(app, folder);
  const Command statusVerb = app.verb("status", "Print the figures of servo and server")
                                 .footer("Example:\n  hapticctl --json status | jq .missed_ticks");
  const Command dumpVerb = app.verb("dump", "Have the server record its last 10 seconds in a file beside it")
                               .footer("Example:\n  hapticctl dump");
  app.verb("verify", "Fetch the whole scene anew and compare its hash with the server's")
      .footer("Example:\n  hapticctl verify && echo same");
  if (const auto code = app.parse(argc, argv)) return *code == 0 ? kDone : kUsage;
  const auto run = [&]() -> int {
    if (applyVerb.given()) return apply(common, applyOptions);
    if (getVerb.given()) return get(common, name);
    if (watchVerb.given()) return watch(common, watchOptions);
    if (pushVerb.given()) return push(common, pushOptions);
    if (statusVerb.given()) return status(common);
    if (exportVerb.given()) return exportSession(common, exportOptions);
    if (plotVerb.given()) return plot(common, plotOptions);
    if (credentialsVerb.given()) return credentials(common, folder);
    if (dumpVerb.given()) return dump(common);
    if (workspaceVerb.given()) return workspace(common, workspaceAsked);
    return verify(common);
  };
  const int code = run();
  std::cout.flush();
  const bool isWritten = std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good();
  return code != kDone || isWritten ? code
                                    : fail(kRefused, Error{"standard output", "cannot be written; is the disk full?"});
}
