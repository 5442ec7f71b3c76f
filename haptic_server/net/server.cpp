#include "haptic_server/net/server.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <map>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "common/clock/monotonic.h"
#include "common/wire/convert.h"
#include "common/wire/endpoint.h"
#include "common/wire/event_loop.h"
#include "common/wire/loop_link.h"
#include "common/wire/tcp.h"
#include "common/wire/tls.h"
#include "common/wire/udp.h"
#include "haptic_server/net/admission.h"
#include "haptic_server/net/connection_log.h"
#include "haptic_server/net/datagram_paths.h"
#include "haptic_server/net/handshake_limit.h"
#include "haptic_server/net/servo_feed.h"
#include "haptic_server/net/shape_hash.h"

namespace haptics {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// How often the servo's queue is emptied: the delay it adds to a sample's age. Shorter costs wake-ups beside the
/// servo, so it is shorter only while a client wants more than a sample every other time.
constexpr microseconds kDrainEvery{2000};
constexpr microseconds kDrainForFastClients{500};
constexpr double kFastClient_Hz = 250;
/// How long stop() lets clients read why.
constexpr milliseconds kStopGrace{200};

/// What a client hears that does not speak TLS to a server that does.
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

class Server::Impl : public std::enable_shared_from_this<Server::Impl> {
 public:
  Impl(Options options, SceneRoom& room)
      : options_(std::move(options)),
        room_(room),
        history_(room.history()),
        servo_(options_.popTelemetry, options_.takeMotion, options_.takeEnergy),
        shapes_(room),
        log_(options_.log) {}

  Result<void> open() {
    if (options_.listen.empty()) return {};
    const auto endpoint = parseEndpoint(options_.listen);
    if (!endpoint) return tl::unexpected(Error(endpoint.error()).within("--listen "));
    const bool open = options_.allowInsecureLan || options_.credentials;
    if (auto allowed = checkListenAddress(*endpoint, open); !allowed) return allowed;
    if (options_.credentials) {
      auto tls =
          TlsContext::server(options_.credentials->certificatePem, options_.credentials->privateKeyPem, plainRefusal());
      if (!tls) return tl::unexpected(std::move(tls.error()).within("--credentials: "));
      tls_ = *std::move(tls);
    }
    auto listener = TcpListener::open(loop_, *endpoint, [this](std::unique_ptr<Transport> t) { accept(std::move(t)); });
    if (!listener) return tl::unexpected(std::move(listener.error()).within("--listen "));
    listener_ = *std::move(listener);
    port_ = listener_->local().port;
    if (!tls_) openDatagrams(listener_->local().host);
    return {};
  }

  void start() {
    room_.setListener([weak = weak_from_this()](const std::shared_ptr<const SceneHistory>& history) {
      if (const auto self = weak.lock()) self->post([history](Impl& impl) { impl.sceneChanged(history); });
    });
    drainEvery(kDrainEvery);
    if (options_.credentials) tokensTimer_ = loop_.every(kTokensEvery, [this] { refreshTokens(false); });
    thread_ = std::thread([this] { run(); });
  }

  void refreshTokens() {
    post([](Impl& impl) { impl.refreshTokens(true); });
  }

  void stop() {
    if (!thread_.joinable()) return;
    room_.setListener({});
    loop_.post([this] { beginStop(); });
    thread_.join();
    drainTelemetry();
    timer_ = {};
    tokensTimer_ = {};
    connections_.clear();
    datagrams_.reset();
    listener_.reset();
  }

  std::unique_ptr<Transport> connect(EventLoop& clientLoop) {
    auto [client, server] = linkLoops(clientLoop, loop_);
    post([end = std::make_shared<std::unique_ptr<Transport>>(std::move(server))](Impl& impl) {
      impl.accept(std::move(*end));
    });
    return std::move(client);
  }

  [[nodiscard]] std::uint16_t port() const noexcept { return port_; }
  [[nodiscard]] Counters counters() const noexcept { return {clients_.load(), refusedConnections_.load()}; }

 private:
  struct Connection final : SessionHost {
    Connection(Impl& server_, std::uint64_t number_, std::unique_ptr<Transport> transport_)
        : server(server_),
          number(number_),
          transport(std::move(transport_)),
          session(*transport, *this, server_.options_.identity) {}

    ~Connection() override { left.request_stop(); }
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    /// For other threads: hands a task to this session, on the network thread, if it still exists by then.
    [[nodiscard]] auto here() const {
      return [weak = server.weak_from_this(), n = number](std::function<void(ServerSession&)> task) {
        const auto self = weak.lock();
        if (!self) return;
        self->post([n, task = std::move(task)](Impl& impl) {
          if (const auto at = impl.connections_.find(n); at != impl.connections_.end()) task(at->second->session);
        });
      };
    }

    [[nodiscard]] std::uint64_t now_ns() const override { return monotonicNow_ns(); }
    [[nodiscard]] std::shared_ptr<const SceneHistory> history() const override { return server.history_; }
    [[nodiscard]] std::shared_ptr<const Asset> findAsset(const ContentHash& hash) const override {
      return server.room_.findAsset(hash);
    }
    [[nodiscard]] const MotionState& motion() const override { return server.servo_.motion(); }
    [[nodiscard]] EnergySource gaveMost() const override { return server.servo_.gaveMost(); }
    [[nodiscard]] bool submitEdit(SessionId id, std::uint64_t clientSeq, Transaction transaction,
                                  bool wantsProgress) override {
      SceneRoom::EditProgress progress;
      if (wantsProgress) {
        progress = [here = here(), clientSeq](WorkStage stage, double share) {
          here([clientSeq, stage, share](ServerSession& s) { s.editProgress(clientSeq, stage, share); });
        };
      }
      return server.room_.submitEdit(
          editSession(id), clientSeq, std::move(transaction),
          [here = here(), clientSeq](const EditOutcome& outcome) {
            here([clientSeq, outcome](ServerSession& s) { s.editDecided(clientSeq, outcome); });
          },
          left.get_token(), std::move(progress));
    }
    [[nodiscard]] bool submitAsset(const AssetName& name, std::string bytes) override {
      const std::size_t size = bytes.size();
      return server.room_.submitAsset(
          editSession(session.id()), name, std::move(bytes),
          [weak = server.weak_from_this(), n = number, hash = name.hash, size](const auto& asset) {
            const auto self = weak.lock();
            if (self) self->post([=](Impl& impl) { impl.assetDecided(n, hash, size, asset); });
          },
          left.get_token());
    }
    [[nodiscard]] bool reserveUpload(std::size_t bytes) override {
      std::size_t ofToken = 0;
      for (const auto& [n, other] : server.connections_) ofToken += other->token == token ? other->uploadBytes : 0;
      if (bytes > Admission::kUploads_bytes - server.uploadBytes_) return false;
      if (ofToken + bytes > server.admission_.uploadsOfToken_bytes()) return false;
      server.uploadBytes_ += bytes;
      uploadBytes += bytes;
      return true;
    }
    void releaseUpload(std::size_t bytes) override {
      server.uploadBytes_ -= bytes;
      uploadBytes -= bytes;
    }
    [[nodiscard]] Result<Role> admit(SessionId id, const std::string& itsToken) override {
      token = hashOfToken(itsToken);
      return server.admit(id, itsToken);
    }
    [[nodiscard]] std::optional<DatagramOffer> offerDatagrams() override {
      const auto from = parseEndpoint(transport->peer());
      if (!server.datagrams_ || !from) return std::nullopt;
      return DatagramOffer{server.datagrams_->local().port, server.paths_.add(number, from->host)};
    }
    [[nodiscard]] bool sendDatagram(const v1::Telemetry& telemetry) override {
      return server.paths_.send(number, telemetry, now_ns());
    }
    [[nodiscard]] bool requestDump() override {
      if (!server.options_.dump) return false;
      server.options_.dump(
          [here = here()](const Result<std::string>& file) { here([file](ServerSession& s) { s.dumped(file); }); });
      return true;
    }
    void sessionClaimed(SessionId id) override { server.claimed(*this, id); }
    void fillStatus(v1::Status& status) override { server.fillStatus(status); }
    [[nodiscard]] std::optional<ContentHash> deformedHash() override {
      return server.shapes_.hashOf(*server.history_, server.servo_.motion().dents(), now_ns());
    }
    void refused(const std::string& why) override {
      ++server.refusedConnections_;
      server.log("refused " + described() + ": " + why);
      wasRefused = true;
    }
    void ended(const std::string& why) override {
      if (!wasRefused && session.id() != 0) server.log(described() + " left: " + why);
      if (!wasRefused && session.id() == 0) refused(why);
      server.post([n = number](Impl& impl) { impl.remove(n); });
    }
    [[nodiscard]] Admission::Client client() const { return {session.id(), session.role(), token}; }
    [[nodiscard]] SessionId editSession(SessionId id) const {
      return server.admission_.editSession({id, session.role(), token});
    }
    [[nodiscard]] std::string described() const {
      return session.name().empty() ? transport->peer() : session.name() + " (" + transport->peer() + ")";
    }

    Impl& server;
    std::uint64_t number;
    std::unique_ptr<Transport> transport;
    ContentHash token{};          // its hash; of no token where none is asked for
    std::size_t uploadBytes = 0;  // reserved
    bool wasRefused = false;
    std::stop_source left;  // stops the edits that only this client waits for
    ServerSession session;  // last: it gives back what it reserved
  };

  /// A task that fails costs what it was for, not the process.
  void run() {
    for (;;) {
      try {
        return loop_.run();
      } catch (const std::exception& failure) {
        log(std::string("the network thread goes on after an error: ") + failure.what());
      }
    }
  }

  /// Runs the task on the network thread, later, if the server still exists. Any thread.
  void post(std::function<void(Impl&)> task) {
    loop_.post([weak = weak_from_this(), task = std::move(task)] {
      if (const auto self = weak.lock()) task(*self);
    });
  }

  void accept(std::unique_ptr<Transport> transport) {
    if (stopTimer_) return;
    if (tls_ && !mayShakeHands(transport->peer())) return;
    makeRoom();
    if (tls_) transport = tls_->secure(std::move(transport));
    const std::uint64_t number = nextNumber_++;
    auto& connection =
        *connections_.emplace(number, std::make_unique<Connection>(*this, number, std::move(transport))).first->second;
    connection.session.start();
    if (const auto& sample = servo_.last()) connection.session.adopted(sample->sceneRevision, sample->adoptionTick);
  }

  [[nodiscard]] bool mayShakeHands(const std::string& peer) {
    const auto from = parseEndpoint(peer);
    if (!from || handshakes_.allow(from->host, monotonicNow_ns())) return true;  // from this process: no endpoint
    ++refusedConnections_;
    log("dropped " + peer + ": its host connects more often than " +
        std::to_string(static_cast<int>(HandshakeLimit::kPerSecond)) + " times a second");
    return false;
  }

  /// At the port of the same number where it is free. A server that gets no socket offers no datagrams.
  void openDatagrams(const std::string& host) {
    const auto received = [this](std::span<const char> bytes, const Endpoint& from) {
      paths_.received(bytes, from, monotonicNow_ns());
    };
    auto socket = DatagramSocket::open(loop_, {host, port_}, received);
    if (!socket) socket = DatagramSocket::open(loop_, {host, 0}, received);
    if (socket) datagrams_ = *std::move(socket);
  }

  /// Drops the oldest connection that has not been welcomed where there are too many of them.
  void makeRoom() {
    if (connections_.size() - clients_ < kMaxHalfOpen) return;
    const auto oldest = std::find_if(connections_.begin(), connections_.end(),
                                     [](const auto& entry) { return !entry.second->session.welcomed(); });
    ++refusedConnections_;
    log("dropped " + oldest->second->transport->peer() + ": too many connections that say nothing");
    paths_.remove(oldest->first);
    connections_.erase(oldest);
  }

  [[nodiscard]] Result<Role> admit(SessionId id, const std::string& token) const {
    std::vector<Admission::Client> others;
    for (const auto& [number, other] : connections_) {
      if (other->session.welcomed()) others.push_back(other->client());
    }
    return admission_.admit(id, token, others);
  }

  void refreshTokens(bool anyway) {
    const auto changed = admission_.refresh(anyway);
    if (!changed) return log("the tokens stay as they were: " + changed.error().text());
    if (!*changed) return;
    log("the list of tokens was read again");
    each([this](Connection& connection) {
      if (!connection.session.welcomed()) return;
      const auto allowed = admission_.check(connection.client());
      if (!allowed) connection.session.refuse(allowed.error().field, allowed.error().reason);
    });
  }

  void assetDecided(std::uint64_t number, const ContentHash& hash, std::size_t bytes,
                    const Result<std::shared_ptr<const Asset>>& asset) {
    const auto at = connections_.find(number);
    if (at == connections_.end()) {
      uploadBytes_ -= bytes;
    } else {
      at->second->session.assetDecided(hash, asset);
    }
  }

  void claimed(const Connection& by, SessionId id) {
    log(by.described() + " joined");
    for (auto& [number, other] : connections_) {
      if (other.get() != &by && other->session.welcomed() && other->session.id() == id) {
        other->session.close("its session goes on in a newer connection");
      }
    }
    countClients();
  }

  void remove(std::uint64_t number) {
    connections_.erase(number);
    paths_.remove(number);
    countClients();
    if (stopTimer_ && connections_.empty()) loop_.stop();
  }

  void countClients() {
    std::uint32_t clients = 0;
    for (const auto& [number, connection] : connections_) clients += connection->session.welcomed() ? 1 : 0;
    clients_ = clients;
  }

  void sceneChanged(const std::shared_ptr<const SceneHistory>& history) {
    history_ = history;
    each([](Connection& connection) { connection.session.sceneChanged(); });
  }

  /// One session that fails costs its own connection.
  template <class Task>
  void each(Task task) {
    for (auto& [number, connection] : connections_) {
      try {
        task(*connection);
      } catch (const std::exception& failure) {
        connection->session.refuse("", std::string("the server could not serve the client: ") + failure.what());
      }
    }
  }

  void drainEvery(microseconds period) {
    drainPeriod_ = period;
    timer_ = loop_.every(period, [this] { onTimer(); });
  }

  void onTimer() {
    const bool any = drainTelemetry();
    bool anyFast = false;
    each([&](Connection& connection) {
      ServerSession& session = connection.session;
      if (any) session.offerTelemetry(*servo_.last());
      session.poll();
      anyFast = anyFast || session.telemetryRate_Hz() > kFastClient_Hz;
    });
    const microseconds period = anyFast ? kDrainForFastClients : kDrainEvery;
    if (period != drainPeriod_) drainEvery(period);
  }

  bool drainTelemetry() {
    return servo_.drain([this](const TelemetrySample& sample) {
      each([&](Connection& connection) { connection.session.adopted(sample.sceneRevision, sample.adoptionTick); });
    });
  }

  void fillStatus(v1::Status& status) {
    if (options_.fillStatus) options_.fillStatus(status);
    for (const ObjectEnergy& object : servo_.energy().objects()) {
      for (std::size_t i = 0; i < kEnergyFeatures; ++i) {
        if (object.given_J[i] == 0) continue;
        toWire({object.object, static_cast<EnergyFeature>(i), object.given_J[i]}, *status.add_energy());
      }
    }
    status.set_clients(clients_);
    status.set_refused_connections(refusedConnections_);
    status.set_forged_datagrams(paths_.forged());
  }

  void log(const std::string& line) { log_.add(line, monotonicNow_ns()); }

  void beginStop() {
    listener_.reset();
    stopTimer_ = loop_.after(kStopGrace, [this] { loop_.stop(); });
    for (auto& [number, connection] : connections_) connection->session.close("the server stops");
    if (connections_.empty()) loop_.stop();
  }

  const Options options_;
  SceneRoom& room_;
  EventLoop loop_;  // before what lives on it
  std::unique_ptr<TcpListener> listener_;
  std::uint16_t port_ = 0;
  std::optional<TlsContext> tls_;
  Timer timer_, tokensTimer_;
  microseconds drainPeriod_{0};
  std::optional<Timer> stopTimer_;
  std::thread thread_;

  // The network thread's.
  std::unique_ptr<DatagramSocket> datagrams_;
  DatagramPaths paths_{[this](std::span<const char> bytes, const Endpoint& to) {
    if (datagrams_) datagrams_->send(bytes, to);
  }};
  std::shared_ptr<const SceneHistory> history_;
  std::map<std::uint64_t, std::unique_ptr<Connection>> connections_;
  std::uint64_t nextNumber_ = 1;
  ServoFeed servo_;
  ShapeHash shapes_;
  std::size_t uploadBytes_ = 0;
  Admission admission_{options_.credentials};
  HandshakeLimit handshakes_;
  ConnectionLog log_;

  std::atomic<std::uint32_t> clients_{0};
  std::atomic<std::uint64_t> refusedConnections_{0};
};

Result<std::unique_ptr<Server>> Server::listen(Options options, SceneRoom& room) {
  auto impl = std::make_shared<Impl>(std::move(options), room);
  if (auto opened = impl->open(); !opened) return tl::unexpected(std::move(opened).error());
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

Server::Server(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() { stop(); }
void Server::start() { impl_->start(); }
void Server::stop() { impl_->stop(); }
void Server::refreshTokens() { impl_->refreshTokens(); }
std::unique_ptr<Transport> Server::connect(EventLoop& clientLoop) { return impl_->connect(clientLoop); }
std::uint16_t Server::port() const noexcept { return impl_->port(); }
Server::Counters Server::counters() const noexcept { return impl_->counters(); }

}  // namespace haptics
