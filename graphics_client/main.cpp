// graphics_client: shows what a haptic_server feels.

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <optional>
#include <string>

#include "common/command_line/command_line.h"
#include "common/log/log.h"
#include "common/mesh/file_bytes.h"
#include "common/text/printable.h"
#include "common/wire/endpoint.h"
#include "graphics_client/application/application.h"
#include "graphics_client/audience/audience_link.h"
#include "graphics_client/embedded_server.h"
#include "graphics_client/mirror/server_link.h"
#include "graphics_client/open_gl.h"
#include "graphics_client/viewer/viewer.h"

namespace {

using haptics::Error;
using haptics::Result;

enum ExitCode { kDone = 0, kFailed = 1, kBadUsage = 2, kNeverConnected = 3 };

/// Frames a second: smooth on a screen; offscreen enough for a picture and figures, leaving the processor to the servo.
constexpr double kWindowFrames_Hz = 60, kOffscreenFrames_Hz = 40;

const char* const kExamples = R"(
Examples:
  graphics_client
      shows the server on this machine
  graphics_client --connect 192.168.1.20:7654 --credentials viewer.credentials --size 1600x1000
      shows a server elsewhere
  graphics_client --nats nats://127.0.0.1:4222 --session lecture
      watches what haptic_relay publishes under this name
  graphics_client --embedded-server --scene deploy/scenes/demo.scene --assets /usr/share/inventor/data
      server and viewer in one process
  graphics_client --recording session.haptics
      shows a recording on a time line
  graphics_client --recording session.haptics --video session.webm --size 1280x800
      makes a video of it, with its curves
  xvfb-run -a -s "-screen 0 1280x1024x24" graphics_client --offscreen --seconds 20 --screenshot view.png
      draws for 20 s without a screen and writes a picture

In the window: press on an object to touch it, drag with the right button to orbit; F1 shows all keys. SIGINT and SIGTERM end it in order: picture and summary are written.
Exit status: 0 done, 1 failed, 2 wrong usage, 3 --seconds are over and there never was a connection.)";

struct Arguments {
  std::string connect = "127.0.0.1:7654";
  std::string size = "1280x1024";
  std::string credentials, screenshot, sheet, summary, recording, video;
  double videoRate_Hz = 25;
  std::string nats, session, natsCredentials;
  bool isSizeGiven = false;
  bool offscreen = false, udp = false, displacement = false;
  bool embeddedServer = false, isServerGiven = false;
  haptics::ServerOptions serverOptions;  // of the embedded one
  std::optional<double> seconds, frameLimit_Hz;
  int hand = 1;  // that the mouse leads
};

std::atomic<bool> stopRequested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set by a signal handler");

Result<haptics::ViewerOptions> optionsFrom(const Arguments& arguments) {
  haptics::ViewerOptions options;
  constexpr int kSmallest_px = 200, kLargest_px = 8192;
  char rest = 0;
  if (std::sscanf(arguments.size.c_str(), "%dx%d%c", &options.width_px, &options.height_px, &rest) != 2 ||
      std::min(options.width_px, options.height_px) < kSmallest_px ||
      std::max(options.width_px, options.height_px) > kLargest_px) {
    return haptics::refused("--size", "\"" + arguments.size + "\" is not WIDTHxHEIGHT with sides from " +
                                          std::to_string(kSmallest_px) + " to " + std::to_string(kLargest_px) +
                                          ", as 1280x1024");
  }
  options.isSizeGiven = arguments.isSizeGiven;
  options.offscreen = arguments.offscreen;
  options.duration_s = arguments.seconds;
  options.screenshot = arguments.screenshot;
  options.sheet = arguments.sheet;
  options.displacement = arguments.displacement;
  options.hand = static_cast<std::size_t>(arguments.hand - 1);
  options.frameLimit_Hz =
      arguments.frameLimit_Hz.value_or(arguments.offscreen ? kOffscreenFrames_Hz : kWindowFrames_Hz);
  return options;
}

/// Says on standard output which scene this client holds, by its own hash, whenever that has changed: for scripts.
class HeldScene {
 public:
  void announce(const haptics::MirrorView& view) {
    if (view.epoch == 0 || (view.scene->root() == root_ && view.hashesEqual == equal_)) return;
    root_ = view.scene->root();
    equal_ = view.hashesEqual;
    std::printf("scene revision %llu root %s %s\n", static_cast<unsigned long long>(view.scene->revision()),
                root_.hex().c_str(), equal_ ? "equal" : "not equal");
    std::fflush(stdout);
  }

 private:
  haptics::ContentHash root_;
  bool equal_ = false;
};

int fail(const Error& error, ExitCode code) {
  std::fprintf(stderr, "graphics_client: %s\n", haptics::printable(error.text()).c_str());
  return code;
}

/// What comes of a run that has ended.
int report(const Arguments& arguments, const Result<haptics::RunSummary>& summary, const std::string& linkText) {
  if (!summary) return fail(summary.error(), kFailed);
  if (!arguments.summary.empty()) {
    const Result<void> written = haptics::writeFile(arguments.summary, summary->json());
    if (!written) return fail(written.error(), kFailed);
  }
  if (arguments.seconds && !summary->wasConnected() && !arguments.recording.empty()) {
    return fail({"--recording", arguments.recording + " was not shown; the log says why"}, kFailed);
  }
  if (arguments.seconds && !summary->wasConnected()) {
    const std::string server = arguments.embeddedServer  ? "the server in this process"
                               : !arguments.nats.empty() ? "session " + arguments.session
                                                         : arguments.connect;
    return fail({arguments.nats.empty() ? "--connect" : "--nats",
                 "there never was a connection to " + server + "; " + linkText},
                kNeverConnected);
  }
  return kDone;
}

/// The way to a session that is published; empty where none is asked for.
Result<haptics::ServerLink::Connect> natsFrom(const Arguments& arguments) {
  if (arguments.nats.empty()) return haptics::ServerLink::Connect{};
  auto subjects = haptics::SessionSubjects::of(arguments.session);
  if (!subjects) return tl::unexpected(std::move(subjects).error());
  haptics::NatsOptions options{.url = arguments.nats, .clientName = "graphics_client"};
  if (!arguments.natsCredentials.empty()) {
    auto read = haptics::readNatsCredentials(arguments.natsCredentials);
    if (!read) return tl::unexpected(std::move(read).error().within("--nats-credentials: "));
    options.credentials = *std::move(read);
  }
  return haptics::connectThroughNats(std::move(options), *std::move(subjects), arguments.session);
}

int run(const Arguments& arguments) {
  const Result<haptics::ViewerOptions> options = optionsFrom(arguments);
  if (!options) return fail(options.error(), kBadUsage);
  const Result<haptics::Endpoint> server = haptics::parseEndpoint(arguments.connect);
  if (!server) return fail(Error(server.error()).within("--connect: "), kBadUsage);
  const bool connects = arguments.recording.empty() || arguments.isServerGiven;
  const auto nats = natsFrom(arguments);
  if (!nats) return fail(nats.error(), kBadUsage);
  std::optional<haptics::ClientCredentials> credentials;
  if (!arguments.credentials.empty()) {
    auto read = haptics::readClientCredentials(arguments.credentials);
    if (!read) return fail(std::move(read.error()).within("--credentials: "), kBadUsage);
    credentials = *std::move(read);
  }
  // Mesa's software renderer takes every core unless told otherwise, the servo's too. A choice made outside stands.
  if (arguments.offscreen) setenv("LP_NUM_THREADS", "1", 0);
  if (const Result<void> display = haptics::checkDisplay(); !display) return fail(display.error(), kFailed);

  if (const Result<void> drawable = haptics::checkOpenGl(); !drawable) return fail(drawable.error(), kFailed);

  if (!arguments.video.empty()) {
    const Result<void> written = haptics::writeVideo(arguments.recording,
                                                     {.file = arguments.video,
                                                      .width_px = options->width_px,
                                                      .height_px = options->height_px,
                                                      .rate_Hz = arguments.videoRate_Hz},
                                                     stopRequested);
    return written ? kDone : fail(written.error(), kFailed);
  }

  std::optional<haptics::EmbeddedServer> embedded;  // outlives the link
  if (arguments.embeddedServer) embedded.emplace(arguments.serverOptions, [] { stopRequested = true; });
  auto link = std::make_unique<haptics::ServerLink>(
      haptics::ServerLink::Options{.server = connects ? *server : haptics::Endpoint{},
                                   .clientName = "graphics_client",
                                   .credentials = std::move(credentials),
                                   .telemetryRate_Hz = kWindowFrames_Hz,
                                   .fetchAssets = true,
                                   .datagrams = arguments.udp,
                                   .followsHand = !arguments.offscreen,
                                   .hand = options->hand,
                                   .connect = embedded ? embedded->connect() : *nats,
                                   .sharedAssets = embedded ? embedded->sharedAssets() : haptics::SharedAssets{}});
  haptics::onDisplayLost([&embedded] {
    if (embedded) static_cast<void>(embedded->stop());
  });
  HeldScene held;
  std::shared_ptr<const haptics::MirrorView> last = link->latest();
  const auto newest = [&] {
    last = link->latest();
    held.announce(*last);
    return last;
  };
  const Result<haptics::RunSummary> summary =
      arguments.offscreen ? haptics::runOffscreen(*options, newest, stopRequested)
                          : haptics::runApplication(*options, link, newest, stopRequested, arguments.recording);
  haptics::onDisplayLost({});
  link.reset();
  const Result<void> stopped = embedded ? embedded->stop() : Result<void>{};
  const int code = stopped ? report(arguments, summary, last->linkText) : fail(stopped.error(), kFailed);
  if (embedded && embedded->isStillBuilding()) std::_Exit(code);
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  haptics::logTo(stdout);
  Arguments arguments;
  haptics::CommandLine app("Shows the objects, the stylus, the contact and the force of a haptic_server.",
                           "graphics_client");
  app.version("graphics_client " HAPTICS_VERSION);
  app.footer(kExamples);
  const auto connect = app.option("--connect", arguments.connect, "The server").typeName("HOST:PORT").showDefault();
  const auto embedded = app.flag("--embedded-server", arguments.embeddedServer,
                                 "With the server in this process, on threads of its own: no network between them")
                            .excludes(connect);
  app.option("--scene", arguments.serverOptions.scene, "Scene file of the embedded server")
      .typeName("FILE")
      .needs(embedded);
  app.option("--assets", arguments.serverOptions.assets, "Folder of mesh files for the embedded server")
      .typeName("DIR")
      .existingFolder()
      .needs(embedded);
  app.option("--server-summary", arguments.serverOptions.summary, "Write the embedded server's figures there (JSON)")
      .typeName("FILE")
      .needs(embedded);
  app.option("--credentials", arguments.credentials,
             "Of a server that has some: its viewer.credentials or editor.credentials")
      .typeName("FILE");
  auto nats = app.option("--nats", arguments.nats, "Watch a session that haptic_relay publishes by this NATS server")
                  .typeName("URL")
                  .excludes(connect)
                  .excludes(embedded);
  const auto session = app.option("--session", arguments.session, "Name of that session").typeName("NAME").needs(nats);
  nats.needs(session);
  app.option("--nats-credentials", arguments.natsCredentials, "Of a NATS server that wants some")
      .typeName("FILE")
      .needs(nats);
  const auto recording = app.option("--recording", arguments.recording,
                                    "Show what a server recorded, on a time line; without --connect no server")
                             .typeName("FILE")
                             .excludes(embedded)
                             .excludes(nats);
  const auto video = app.option("--video", arguments.video,
                                "Write a video of the recording there, scene and curves, without a window (WebM, VP8)")
                         .typeName("FILE")
                         .ending(".webm")
                         .needs(recording)
                         .excludes(connect);
  app.option("--video-fps", arguments.videoRate_Hz, "Pictures of a second of it")
      .typeName("HZ")
      .range(1.0, 120.0)
      .showDefault()
      .needs(video);
  app.option("--hand", arguments.hand, "Which hand of a server with two the mouse leads")
      .typeName("1|2")
      .range(1, 2)
      .showDefault();
  app.flag("--udp", arguments.udp,
           "Telemetry by UDP where the server offers it (without TLS) and the network lets it through");
  app.flag("--displacement", arguments.displacement, "Colour soft objects by how far they are displaced (the d key)");
  const auto offscreen =
      app.flag("--offscreen", arguments.offscreen, "Draw without a window (an X display is still needed)")
          .excludes(recording);
  const auto seconds = app.option("--seconds", arguments.seconds, "End by itself after this long")
                           .typeName("S")
                           .moreThanZero()
                           .excludes(video);
  app.option("--screenshot", arguments.screenshot,
             "Write the picture there at the end (PNG); offscreen the last in contact")
      .typeName("FILE")
      .ending(".png")
      .excludes(video);
  app.option("--sheet", arguments.sheet, "Write six small pictures of the run there at the end, on one sheet (PNG)")
      .typeName("FILE")
      .ending(".png")
      .needs(seconds)
      .needs(offscreen);
  app.option("--summary", arguments.summary, "Write figures of the run there at the end (JSON)")
      .typeName("FILE")
      .excludes(video);
  const auto size =
      app.option("--size", arguments.size,
                 "Of the picture, or the window, in pixels; a window without it fits the screen, and is as it was left")
          .typeName("WIDTHxHEIGHT")
          .showDefault();
  app.option("--fps-limit", arguments.frameLimit_Hz, "Most frames a second (default 60, offscreen 40)")
      .typeName("HZ")
      .moreThanZero();
  if (const auto code = app.parse(argc, argv)) return *code == 0 ? kDone : kBadUsage;
  arguments.isServerGiven = connect.given();
  arguments.isSizeGiven = size.given();
  struct sigaction action = {};
  action.sa_handler = [](int) { stopRequested = true; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  try {
    return run(arguments);
  } catch (const std::exception& error) {
    return fail({"", error.what()}, kFailed);
  }
}
