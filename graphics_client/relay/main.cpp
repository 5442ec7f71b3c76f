// haptic_relay: publishes a haptic_server's session through NATS, for an audience that only watches.

#include <string>
#include <utility>

#include "common/log/log.h"
#include "graphics_client/mirror/client_program.h"
#include "graphics_client/relay/relay.h"

namespace {

using haptics::Result;

const char* const kExamples = R"(
Examples:
  haptic_relay --nats nats://127.0.0.1:4222 --session lecture
      publishes the server on this machine
  haptic_relay --connect 192.168.1.20:7654 --credentials viewer.credentials --nats tls://nats.example.org:4222 --session lecture --nats-credentials relay.nats
      publishes a server elsewhere, by a NATS server elsewhere

A file of NATS credentials has the lines "user: NAME" and "password: TEXT", and may hold the certificate to trust.
)";

/// What is not sent so long after a signal is not waited for; it is read and sent by the next relay.
constexpr unsigned kEndWithin_s = 1;

/// Checks the options that are read when all are known.
Result<void> complete(haptics::RelayOptions& options, const std::string& session, const std::string& natsCredentials) {
  auto subjects = haptics::SessionSubjects::of(session);
  if (!subjects) return tl::unexpected(std::move(subjects).error());
  options.subjects = *std::move(subjects);
  options.nats.clientName = "haptic_relay";
  if (natsCredentials.empty()) return {};
  auto read = haptics::readNatsCredentials(natsCredentials);
  if (!read) return tl::unexpected(std::move(read).error().within("--nats-credentials: "));
  options.nats.credentials = *std::move(read);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  haptics::RelayOptions options;
  std::string session, natsCredentials;
  haptics::BridgeProgram app("haptic_relay",
                             "Publishes a haptic_server's session through NATS, for viewers and pages that only watch.",
                             kExamples);
  haptics::addServerOptions(app, options.server, options.credentials, "viewer.credentials");
  app.option("--nats", options.nats.url, "The NATS server, with JetStream; several of a cluster with commas")
      .typeName("URL")
      .required();
  app.option("--session", session, "Name under which it is published: letters, digits, - and _")
      .typeName("NAME")
      .required();
  app.option("--nats-credentials", natsCredentials, "Of a NATS server that wants some").typeName("FILE");
  app.option("--replicas", options.replicas, "Servers of a cluster that hold what is stored").range(1, 5).showDefault();
  return app.run(
      argc, argv, [&] { return complete(options, session, natsCredentials); },
      [&](const auto& stop) { return haptics::runRelay(options, stop, haptics::logInfo); }, kEndWithin_s);
}
