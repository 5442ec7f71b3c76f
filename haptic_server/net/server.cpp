#include "haptic_server/net/server.h"

#include <exception>
#include <utility>

#include "common/wire/endpoint.h"
#include "common/wire/framing.h"
#include "common/wire/loop_link.h"
#include "common/wire/tcp.h"
#include "common/wire/tls.h"
#include "haptic_server/net/connections.h"

namespace haptics {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// How often the servo's queue is emptied: the delay it adds to a sample's age. Shorter costs wake-ups beside the
/// servo, so it is shorter only while a client wants more than a sample every other time.
constexpr microseconds kServeEvery{2000};
constexpr microseconds kServeFastClientsEvery{500};
constexpr double kFastClient_Hz = 250;
/// How long stop() lets clients read why.
constexpr milliseconds kStopGrace{200};

/// The answer of a server with TLS to a client without.
std::string plainRefusal() {
  v1::Envelope envelope;
  envelope.set_protocol_version(kProtocolVersion);
  envelope.mutable_refusal()->set_reason("this server speaks TLS only; connect with --credentials FILE");
  envelope.mutable_refusal()->set_supported_version(kProtocolVersion);
  std::string frame;
  (void)appendFrame(frame, envelope);  // it fits
  return frame;
}

}  // namespace

Result<std::unique_ptr<Server>> Server::listen(Options options, SceneService& sceneService, ServerHost& host) {
  std::unique_ptr<Server> server(new Server(std::move(options), sceneService, host));
  if (auto opened = server->open(); !opened) return tl::unexpected(std::move(opened).error());
  return server;
}

Server::Server(Options options, SceneService& sceneService, ServerHost& host)
    : options_(std::move(options)),
      sceneService_(sceneService),
      connections_(std::make_shared<Connections>(options_.identity, options_.credentials, sceneService, host)) {}

Server::~Server() { stop(); }

Result<void> Server::open() {
  if (options_.listen.empty()) return {};
  const auto endpoint = parseEndpoint(options_.listen);
  if (!endpoint) return tl::unexpected(Error(endpoint.error()).within("--listen "));
  const bool open = options_.allowInsecureLan || options_.credentials;
  if (auto allowed = checkListenAddress(*endpoint, open); !allowed) return allowed;
  if (options_.credentials) {
    auto tls =
        TlsContext::server(options_.credentials->certificatePem, options_.credentials->privateKeyPem, plainRefusal());
    if (!tls) return tl::unexpected(std::move(tls.error()).within("--credentials: "));
    connections_->secureWith(*std::move(tls));
  }
  const auto accept = [this](std::unique_ptr<Transport> transport) { connections_->accept(std::move(transport)); };
  auto listener = TcpListener::open(connections_->loop(), *endpoint, accept);
  if (!listener) return tl::unexpected(std::move(listener.error()).within("--listen "));
  listener_ = *std::move(listener);
  const Endpoint local = listener_->local();
  port_ = local.port;
  if (!options_.credentials) connections_->openDatagrams(local);
  return {};
}

void Server::start() {
  sceneService_.setListener([weak = std::weak_ptr(connections_)](const std::shared_ptr<const SceneHistory>& history) {
    const auto alive = weak.lock();
    if (alive) alive->post([history](Connections& connections) { connections.sceneChanged(history); });
  });
  serveEvery(kServeEvery);
  if (options_.credentials) {
    tokensTimer_ = connections_->loop().every(kTokensEvery, [this] { connections_->refreshTokens(false); });
  }
  thread_ = std::thread([this] { run(); });
}

void Server::stop() {
  if (!thread_.joinable()) return;
  sceneService_.setListener({});
  connections_->loop().post([this] {
    listener_.reset();
    stopTimer_ = connections_->loop().after(kStopGrace, [this] { connections_->loop().stop(); });
    connections_->closeAll("the server stops");
  });
  thread_.join();
  connections_->drainTelemetry();
  timer_ = {};
  tokensTimer_ = {};
  connections_->clear();
  listener_.reset();
}

void Server::refreshTokens() {
  connections_->post([](Connections& connections) { connections.refreshTokens(true); });
}

std::unique_ptr<Transport> Server::connect(EventLoop& clientLoop) {
  auto [client, server] = linkLoops(clientLoop, connections_->loop());
  connections_->post([end = std::make_shared<std::unique_ptr<Transport>>(std::move(server))](Connections& connections) {
    connections.accept(std::move(*end));
  });
  return std::move(client);
}

Server::Counters Server::counters() const noexcept {
  return {connections_->shared().clients, connections_->shared().refusedConnections};
}

/// A task that fails costs what it was for, not the process.
void Server::run() {
  for (;;) {
    try {
      return connections_->loop().run();
    } catch (const std::exception& failure) {
      connections_->log(std::string("the network thread goes on after an error: ") + failure.what());
    }
  }
}

void Server::serveEvery(microseconds period) {
  servedEvery_ = period;
  timer_ = connections_->loop().every(period, [this] { serve(); });
}

void Server::serve() {
  const microseconds period = connections_->serve_Hz() > kFastClient_Hz ? kServeFastClientsEvery : kServeEvery;
  if (period != servedEvery_) serveEvery(period);
}

}  // namespace haptics
