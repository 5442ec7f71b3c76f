#include "graphics_client/mirror/client_program.h"

#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <utility>

#include "common/log/log.h"
#include "common/text/printable.h"

namespace haptics {
namespace {

enum ExitCode { kDone = 0, kFailed = 1, kBadUsage = 2 };

std::atomic<bool> stopRequested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set by a signal handler");
unsigned secondsToEnd = 0;

/// An option that is read into `value`.
template <class Value, class Read>
Option addRead(Command& app, const std::string& name, Value& value, Read read, const std::string& about) {
  const TextTaker take = [&value, read](const std::string& text) -> Result<void> {
    auto known = read(text);
    if (!known) return tl::unexpected(std::move(known).error());
    value = *std::move(known);
    return {};
  };
  return app.option(name, take, about);
}

}  // namespace

void addServerOptions(Command& app, Endpoint& server, std::optional<ClientCredentials>& credentials,
                      const std::string& which) {
  server = {"127.0.0.1", 7654};
  addRead(app, "--connect", server, parseEndpoint, "The server").typeName("HOST:PORT").showDefault(server.text());
  addRead(app, "--credentials", credentials, readClientCredentials, "Of a server that has some: its " + which)
      .typeName("FILE");
}

BridgeProgram::BridgeProgram(const std::string& name, const std::string& about, const std::string& examples)
    : CommandLine(about, name), name_(name) {
  logTo(stderr);
  version(name + " " HAPTICS_VERSION);
  footer(examples +
         "SIGINT and SIGTERM end it. Exit status: 0 done, 1 somebody has to change something first, 2 wrong usage.");
}

int BridgeProgram::run(int argc, char** argv, const std::function<Result<void>()>& prepare,
                       const std::function<Result<void>(const std::atomic<bool>& stop)>& serve, unsigned endWithin_s) {
  const auto fail = [&](const Error& error, ExitCode code) {
    std::fprintf(stderr, "%s: %s\n", name_.c_str(), printable(error.text()).c_str());
    return code;
  };
  if (const auto code = parse(argc, argv)) return *code == 0 ? kDone : kBadUsage;
  secondsToEnd = endWithin_s;
  struct sigaction action = {};
  action.sa_handler = [](int) { _exit(kDone); };
  sigaction(SIGALRM, &action, nullptr);
  action.sa_handler = [](int) {
    if (!stopRequested.exchange(true)) alarm(secondsToEnd);
  };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  if (const auto prepared = prepare(); !prepared) return fail(prepared.error(), kBadUsage);
  try {
    const auto done = serve(stopRequested);
    return done ? kDone : fail(done.error(), kFailed);
  } catch (const std::exception& error) {
    return fail({"", error.what()}, kFailed);
  }
}

}  // namespace haptics
