#include <CLI/CLI.hpp>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "graphics_client/script/verbs.h"

namespace {

using namespace haptics;

constexpr double kMaxTimeout_s = 86'400;
constexpr double kMaxTelemetryRate_Hz = 1000;  // the server sends no faster

void addCommonOptions(CLI::App& app, CommonOptions& common) {
  app.add_option_function<std::string>(
         "--connect",
         [&common](const std::string& text) {
           const auto endpoint = parseEndpoint(text);
           if (!endpoint) throw CLI::ValidationError("--connect", endpoint.error().text());
           common.server = *endpoint;
         },
         "The server")
      ->type_name("HOST:PORT")
      ->default_str(common.server.text());
  app.add_option_function<std::string>(
         "--credentials",
         [&common](const std::string& file) {
           auto credentials = readClientCredentials(file);
           if (!credentials) throw CLI::ValidationError("--credentials", credentials.error().text());
           common.credentials = *std::move(credentials);
         },
         "Of a server that has some: its viewer.credentials or editor.credentials")
      ->type_name("FILE");
  app.add_option("--timeout", common.timeout_s, "Give up after this time without a connection")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.1, kMaxTimeout_s))
      ->capture_default_str();
  app.add_flag("--json", common.json, "Results as JSON, for scripts");
}

CLI::App* addApply(CLI::App& app, ApplyOptions& options) {
  auto* verb = app.add_subcommand("apply", "Change the scene: all operations of a scene file, or none");
  verb->add_option("scene", options.scene, "Scene file (protobuf text format); - reads standard input")
      ->type_name("FILE")
      ->required();
  verb->add_option_function<std::vector<std::string>>(
          "--upload",
          [&options](const std::vector<std::string>& pairs) {
            for (const auto& pair : pairs) {
              const auto middle = pair.find('=');
              if (middle == std::string::npos) throw CLI::ValidationError("--upload", pair + ": should be NAME=FILE");
              options.uploads[pair.substr(0, middle)] = pair.substr(middle + 1);
            }
          },
          "Send a mesh or image of this machine: what the scene calls file or image: \"NAME\" is FILE here")
      ->type_name("NAME=FILE");
  verb->footer(
      "Waits until the change is felt and says from which tick on.\n\n"
      "Examples:\n"
      "  hapticctl apply table.scene\n"
      "  echo 'operations { set_material { object { name: \"torus\" } material { stiffness_N_per_m: 400 } } }' \\\n"
      "    | hapticctl apply -\n"
      "  echo 'operations { add { name: \"cup\" mesh { file: \"cup\" unit_m: 0.001 } } }' \\\n"
      "    | hapticctl apply - --upload cup=models/cup.stl");
  return verb;
}

CLI::App* addGet(CLI::App& app, std::string& name) {
  auto* verb = app.add_subcommand("get", "Print the scene as a file that apply takes");
  verb->add_option("name", name, "Only this object")->type_name("NAME");
  verb->footer("Examples:\n  hapticctl get > now.scene\n  hapticctl --json get torus");
  return verb;
}

CLI::App* addWatch(CLI::App& app, WatchOptions& options) {
  auto* verb = app.add_subcommand("watch", "Print what the servo feels, a line for each sample");
  verb->add_option("--rate", options.rate_Hz, "Samples a second")
      ->type_name("HZ")
      ->check(CLI::Range(std::numeric_limits<double>::min(), kMaxTelemetryRate_Hz))
      ->capture_default_str();
  verb->add_option("--seconds", options.duration_s, "Stop after this time (default: at Ctrl-C)")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.0, kMaxTimeout_s));
  verb->add_flag("--udp", options.datagrams,
                 "By UDP where the server offers it (without TLS) and the network lets it through");
  verb->add_flag("--every-tick", options.everyTick, "Every tick, and on standard error each gap and why it is there")
      ->excludes("--rate")
      ->excludes("--udp");
  verb->footer(
      "Examples:\n  hapticctl watch\n  hapticctl --json watch --rate 100 --seconds 5 > forces.jsonl\n"
      "  hapticctl --json watch --every-tick --seconds 5 > ticks.jsonl");
  return verb;
}

/// The format that a file's name says, if any.
std::optional<ExportFormat> formatOf(const std::filesystem::path& file) {
  static const std::map<std::string, ExportFormat> kByEnding{{".h5", ExportFormat::kHdf5},
                                                             {".hdf5", ExportFormat::kHdf5},
                                                             {".csv", ExportFormat::kCsv},
                                                             {".mcap", ExportFormat::kMcap}};
  const auto found = kByEnding.find(file.extension().string());
  return found == kByEnding.end() ? std::nullopt : std::optional(found->second);
}

CLI::App* addExport(CLI::App& app, ExportOptions& options) {
  static const std::map<std::string, ExportFormat> kByName{
      {"hdf5", ExportFormat::kHdf5}, {"csv", ExportFormat::kCsv}, {"mcap", ExportFormat::kMcap}};
  auto* verb =
      app.add_subcommand("export", "Write every tick of a recording, or of a running server, as HDF5, CSV or MCAP");
  auto* recording = verb->add_option("recording", options.recording, "A recording of the server; without it --live")
                        ->type_name("RECORDING")
                        ->check(CLI::ExistingFile);
  verb->add_option("--out", options.out, "The file; ends with .h5, .csv or .mcap, or --format says what it is")
      ->type_name("FILE")
      ->required();
  auto* format = verb->add_option("--format", options.format, "hdf5, csv or mcap")
                     ->transform(CLI::CheckedTransformer(kByName).description(""))
                     ->type_name("FORMAT");
  auto* live = verb->add_flag("--live", options.live, "Of the running server, from now on")->excludes(recording);
  verb->add_option("--seconds", options.duration_s, "Of a live session; Ctrl-C ends it before, with what there is")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.1, kMaxTimeout_s))
      ->needs(live)
      ->capture_default_str();
  verb->callback([&options, recording, format, live] {
    if (recording->count() + live->count() == 0) throw CLI::RequiredError("a recording, or --live");
    const auto byName = formatOf(options.out);
    if (format->count() == 0 && !byName)
      throw CLI::ValidationError("--out", options.out.string() + ": ends with none of .h5, .csv, .mcap; give --format");
    if (format->count() == 0) options.format = *byName;
  });
  verb->footer(
      "A file is whole or is not there: it is written as FILE.part. Ticks that are missing are counted, and in HDF5 "
      "listed.\n\n"
      "Examples:\n"
      "  hapticctl export session.recording --out session.h5\n"
      "  hapticctl export session.recording --out session.mcap\n"
      "  hapticctl export --live --seconds 60 --out session.csv");
  return verb;
}

CLI::App* addPlot(CLI::App& app, PlotOptions& options) {
  auto* verb = app.add_subcommand("plot", "Draw a recording: force, penetration, path, spectrum, energy by cause");
  verb->add_option("recording", options.recording, "A recording of the server, or what export made of one as HDF5")
      ->type_name("RECORDING")
      ->required()
      ->check(CLI::ExistingFile);
  verb->add_option("--out", options.out, "The picture; .png, .svg or .pdf")->type_name("FILE")->required();
  verb->add_option("--title", options.title, "Above it (default: the recording's name)")->type_name("TEXT");
  verb->footer(
      "Examples:\n  hapticctl plot session.recording --out session.png\n  hapticctl plot session.h5 --out session.svg");
  return verb;
}

CLI::App* addCredentials(CLI::App& app, std::string& folder) {
  auto* verb =
      app.add_subcommand("credentials", "Make a server's certificate and its clients' tokens; no server needed");
  verb->add_option("folder", folder, "Where to; made if missing")->type_name("DIR")->required();
  verb->footer(
      "Then, on the server's machine:  haptic_server --listen 192.168.1.5:7654 --credentials DIR\n"
      "and on the others, with a copy of DIR/viewer.credentials or DIR/editor.credentials:\n"
      "  hapticctl --connect 192.168.1.5:7654 --credentials editor.credentials status");
  return verb;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Scripted client of haptic_server", "hapticctl");
  app.set_version_flag("--version", "hapticctl " HAPTICS_VERSION);
  app.require_subcommand(1);
  app.fallthrough();
  app.footer(
      "Exits with 0 when done, 1 when refused or not equal, 2 for wrong usage, 3 without a connection, 130 at Ctrl-C.\n"
      "hapticctl VERB --help shows examples.");
  CommonOptions common;
  ApplyOptions applyOptions;
  WatchOptions watchOptions;
  ExportOptions exportOptions;
  PlotOptions plotOptions;
  std::string name, folder;
  addCommonOptions(app, common);
  const auto* applyVerb = addApply(app, applyOptions);
  const auto* getVerb = addGet(app, name);
  const auto* watchVerb = addWatch(app, watchOptions);
  const auto* exportVerb = addExport(app, exportOptions);
  const auto* plotVerb = addPlot(app, plotOptions);
  const auto* credentialsVerb = addCredentials(app, folder);
  const auto* statusVerb = app.add_subcommand("status", "Print the figures of servo and server")
                               ->footer("Example:\n  hapticctl --json status | jq .missed_ticks");
  const auto* dumpVerb = app.add_subcommand("dump", "Have the server record its last 10 seconds in a file beside it")
                             ->footer("Example:\n  hapticctl dump");
  app.add_subcommand("verify", "Fetch the whole scene anew and compare its hash with the server's")
      ->footer("Example:\n  hapticctl verify && echo same");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  }
  if (applyVerb->parsed()) return apply(common, applyOptions);
  if (getVerb->parsed()) return get(common, name);
  if (watchVerb->parsed()) return watch(common, watchOptions);
  if (statusVerb->parsed()) return status(common);
  if (exportVerb->parsed()) return exportSession(common, exportOptions);
  if (plotVerb->parsed()) return plot(common, plotOptions);
  if (credentialsVerb->parsed()) return credentials(common, folder);
  if (dumpVerb->parsed()) return dump(common);
  return verify(common);
}
