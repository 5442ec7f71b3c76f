// haptic_relay: publishes a haptic_server's session through NATS, for an audience that only watches.

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>

#include "common/command_line/command_line.h"
#include "common/log/log.h"
#include "common/text/printable.h"
#include "graphics_client/relay/relay.h"

namespace {

using haptics::Error;
using haptics::Result;

enum ExitCode { kDone = 0, kFailed = 1, kBadUsage = 2 };

const char* const kExamples = R"(
Examples:
  haptic_relay --nats nats://127.0.0.1:4222 --session lecture
      publishes the server on this machine
  haptic_relay --connect 192.168.1.20:7654 --credentials viewer.credentials --nats tls://nats.example.org:4222 --session lecture --nats-credentials relay.nats
      publishes a server elsewhere, by a NATS server elsewhere

A file of NATS credentials has the lines "user: NAME" and "password: TEXT", and may hold the certificate to trust.
SIGINT and SIGTERM end it. Exit status: 0 done, 1 somebody has to change something first, 2 wrong usage.)";

struct Arguments {
  std::string connect = "127.0.0.1:7654";
  std::string credentials, nats, natsCredentials, session;
  int replicas = 1;
};

/// What is not sent so long after a signal is not waited for; it is read and sent by the next relay.
constexpr unsigned kEndWithin_s = 1;

std::atomic<bool> stopRequested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set by a signal handler");

int fail(const Error& error, ExitCode code) {
  std::fprintf(stderr, "haptic_relay: %s\n", haptics::printable(error.text()).c_str());
  return code;
}

Result<haptics::RelayOptions> optionsFrom(const Arguments& arguments) {
  haptics::RelayOptions options;
  auto server = haptics::parseEndpoint(arguments.connect);
  if (!server) return tl::unexpected(std::move(server).error().within("--connect: "));
  options.server = *std::move(server);
  if (!arguments.credentials.empty()) {
    auto read = haptics::readClientCredentials(arguments.credentials);
    if (!read) return tl::unexpected(std::move(read).error().within("--credentials: "));
    options.credentials = *std::move(read);
  }
  auto subjects = haptics::SessionSubjects::of(arguments.session);
  if (!subjects) return tl::unexpected(std::move(subjects).error());
  options.subjects = *std::move(subjects);
  options.replicas = arguments.replicas;
  options.nats = {.url = arguments.nats, .clientName = "haptic_relay"};
  if (!arguments.natsCredentials.empty()) {
    auto read = haptics::readNatsCredentials(arguments.natsCredentials);
    if (!read) return tl::unexpected(std::move(read).error().within("--nats-credentials: "));
    options.nats.credentials = *std::move(read);
  }
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  haptics::logTo(stderr);
  Arguments arguments;
  haptics::CommandLine app("Publishes a haptic_server's session through NATS, for viewers and pages that only watch.",
                           "haptic_relay");
  app.version("haptic_relay " HAPTICS_VERSION);
  app.footer(kExamples);
  app.option("--connect", arguments.connect, "The server").typeName("HOST:PORT").showDefault();
  app.option("--credentials", arguments.credentials, "Of a server that has some: its viewer.credentials")
      .typeName("FILE");
  app.option("--nats", arguments.nats, "The NATS server, with JetStream; several of a cluster with commas")
      .typeName("URL")
      .required();
  app.option("--session", arguments.session, "Name under which it is published: letters, digits, - and _")
      .typeName("NAME")
      .required();
  app.option("--nats-credentials", arguments.natsCredentials, "Of a NATS server that wants some").typeName("FILE");
  app.option("--replicas", arguments.replicas, "Servers of a cluster that hold what is stored")
      .range(1, 5)
      .showDefault();
  if (const auto code = app.parse(argc, argv)) return *code == 0 ? kDone : kBadUsage;
  struct sigaction action = {};
  action.sa_handler = [](int) { _exit(kDone); };
  sigaction(SIGALRM, &action, nullptr);
  action.sa_handler = [](int) {
    if (!stopRequested.exchange(true)) alarm(kEndWithin_s);
  };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  const auto options = optionsFrom(arguments);
  if (!options) return fail(options.error(), kBadUsage);
  try {
    const auto done = haptics::runRelay(*options, stopRequested, haptics::logInfo);
    return done ? kDone : fail(done.error(), kFailed);
  } catch (const std::exception& error) {
    return fail({"", error.what()}, kFailed);
  }
}
