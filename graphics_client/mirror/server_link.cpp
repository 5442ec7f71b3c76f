#include "graphics_client/mirror/server_link.h"

#include <condition_variable>
#include <mutex>
#include <optional>
#include <random>
#include <thread>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/wire/event_loop.h"
#include "common/wire/tcp.h"
#include "common/wire/tls.h"
#include "common/wire/udp.h"
#include "graphics_client/mirror/client_session.h"

namespace haptics {
namespace {

std::uint64_t randomSession() {
  std::random_device device;
  const std::uint64_t session = static_cast<std::uint64_t>(device()) << 32 | device();
  return session == 0 ? 1 : session;
}

ServerLink::Connect overTcp(const Endpoint& server) {
  return [server](EventLoop& loop, ServerLink::Connected done) {
    return std::make_shared<TcpConnector>(loop, server, std::move(done));
  };
}

}  // namespace

/// What lives on the link's thread. The view is handed over under a mutex that is held only to copy a pointer or to
/// test a waiter's condition.
struct ServerLink::Worker {
  explicit Worker(Options options)
      : server(options.server),
        overOtherWay(options.connect),
        begin(options.connect ? std::move(options.connect) : overTcp(options.server)),
        session({randomSession(),
                 std::move(options.clientName),
                 options.credentials ? std::move(options.credentials->token) : "",
                 options.telemetryRate_Hz,
                 options.fetchAssets,
                 options.datagrams,
                 options.followsHand,
                 options.hand,
                 options.onTicks,
                 std::move(options.sharedAssets),
                 {},
                 std::move(options.follower),
                 std::move(options.held)}) {
    if (options.credentials) tls = TlsContext::client(options.credentials->serverCertificatePem).value();
    MirrorView first;
    if (isClosed()) first.link = LinkState::kClosed;
    first.linkText = isClosed() ? "not connected" : "connecting to " + server.text();
    newest = std::make_shared<const MirrorView>(std::move(first));
    thread = std::thread([this] { run(); });
  }

  ~Worker() {
    loop.post([this] { leave(); });
    thread.join();
  }

  void run() {
    pollTimer = loop.every(std::chrono::nanoseconds(ClientSession::kPoll_ns), [this] { poll(); });
    if (!isClosed()) connect();
    loop.run();
    pollTimer = {};
    retryTimer = {};
    connector.reset();
    datagrams.reset();
    transport.reset();
  }

  /// There is no server to connect to.
  [[nodiscard]] bool isClosed() const { return server.host.empty() && !overOtherWay; }

  void connect() {
    connector = begin(loop, [this](Result<std::unique_ptr<Transport>> result) {
      if (!result) return lost(result.error().text());
      transport = tls ? tls->secure(std::move(*result)) : std::move(*result);
      transport->start({.received = [this](std::span<const char> bytes) { received(bytes); },
                        .drained = [this] { session.drained(); },
                        .closed = [this](const std::string& why) { lost(why); }});
      session.connected(*transport, monotonicNow_ns());
      settle();
    });
  }

  void received(std::span<const char> bytes) {
    session.received(bytes, monotonicNow_ns());
    settle();
  }

  void poll() {
    if (isClosed()) return;
    const std::uint64_t now_ns = monotonicNow_ns();
    session.poll(now_ns);
    settle();
  }

  void sendDatagrams(std::uint64_t now_ns) {
    while (const auto datagram = session.nextDatagram(now_ns)) send(*datagram);
  }

  void send(const DatagramPath::Datagram& datagram) {
    if (!datagrams) {
      auto socket =
          DatagramSocket::towards(loop, datagram.to, [this](std::span<const char> bytes, const Endpoint& from) {
            session.datagramReceived(bytes, from, monotonicNow_ns());
            publish();
          });
      if (!socket) return;
      datagrams = *std::move(socket);
    }
    datagrams->send(datagram.bytes, datagram.to);
  }

  /// After every event: leaves a connection that the session has done with, and shows what is new.
  void settle() {
    sendDatagrams(monotonicNow_ns());
    if (session.connectionOver()) return lost(std::string(session.overReason()));
    publish();
  }

  void lost(const std::string& why) {
    if (leaving) return loop.stop();
    transport.reset();
    datagrams.reset();
    if (why.starts_with(kTlsFailure)) session.turnedAway(why);
    session.connectionLost(why);
    publish();
    retryTimer = loop.after(std::chrono::nanoseconds(session.reconnectDelay_ns()), [this] { connect(); });
  }

  void leave() {
    leaving = true;
    connector.reset();
    if (!transport) return loop.stop();
    transport->close("the client leaves");
  }

  void publish() {
    if (published == session.changes()) return;
    published = session.changes();
    auto view = std::make_shared<const MirrorView>(session.view(monotonicNow_ns()));
    const std::lock_guard lock(mutex);
    newest = std::move(view);
    changed.notify_all();
  }

  /// Calls a method of the session, on the link's thread.
  template <class... Parameters, class... Arguments>
  void ask(void (ClientSession::*method)(Parameters...), Arguments... arguments) {
    loop.post([this, method, ... own = std::move(arguments)]() mutable { (session.*method)(std::move(own)...); });
  }

  Endpoint server;
  bool overOtherWay;  // than TCP
  Connect begin;
  std::optional<TlsContext> tls;
  EventLoop loop;
  ClientSession session;
  std::shared_ptr<void> connector;
  std::unique_ptr<Transport> transport;
  std::unique_ptr<DatagramSocket> datagrams;
  Timer pollTimer, retryTimer;
  bool leaving = false;
  std::uint64_t published = 0;  // session.changes() of `newest`

  mutable std::mutex mutex;  // guards newest
  mutable std::condition_variable changed;
  std::shared_ptr<const MirrorView> newest;
  std::thread thread;
};

ServerLink::ServerLink(Options options) : options_(std::move(options)), worker_(std::make_unique<Worker>(options_)) {}
ServerLink::~ServerLink() = default;

void ServerLink::connectTo(const Endpoint& server, std::optional<ClientCredentials> credentials) {
  options_.server = server;
  options_.credentials = std::move(credentials);
  options_.connect = nullptr;
  options_.sharedAssets = nullptr;
  auto next = std::make_unique<Worker>(options_);
  {
    const std::lock_guard lock(mutex_);
    worker_.swap(next);
  }
  // The farewell of one that is still leaving is waited for there too.
  leaving_ = std::jthread([before = std::move(next), earlier = std::move(leaving_)]() mutable { before.reset(); });
}

std::shared_ptr<const MirrorView> ServerLink::latest() const {
  const std::shared_lock lock(mutex_);
  const std::lock_guard ofView(worker_->mutex);
  return worker_->newest;
}

std::shared_ptr<const MirrorView> ServerLink::waitUntil(const std::function<bool(const MirrorView&)>& condition,
                                                        std::chrono::nanoseconds timeout) const {
  std::unique_lock lock(worker_->mutex);
  const bool held = worker_->changed.wait_for(lock, timeout, [&] { return condition(*worker_->newest); });
  return held ? worker_->newest : nullptr;
}

void ServerLink::submit(v1::Transaction transaction, EditCallbacks callbacks) {
  const std::shared_lock lock(mutex_);
  worker_->ask(&ClientSession::submit, std::move(transaction), std::move(callbacks));
}

void ServerLink::upload(AssetKind kind, std::string bytes, UploadCallbacks callbacks) {
  const std::shared_lock lock(mutex_);
  worker_->ask(&ClientSession::upload, kind, std::move(bytes), std::move(callbacks));
}

void ServerLink::cancelUpload(const ContentHash& asset) {
  const std::shared_lock lock(mutex_);
  worker_->ask(&ClientSession::cancelUpload, asset);
}

void ServerLink::requestStatus(StatusCallback callback, bool deformed) {
  const std::shared_lock lock(mutex_);
  worker_->ask(&ClientSession::requestStatus, std::move(callback), deformed);
}

void ServerLink::requestDump(DumpCallback callback) {
  const std::shared_lock lock(mutex_);
  worker_->ask(&ClientSession::requestDump, std::move(callback));
}

void ServerLink::setTelemetryRate(double rate_Hz) {
  const std::shared_lock lock(mutex_);
  worker_->ask(&ClientSession::setTelemetryRate, rate_Hz);
}

void ServerLink::leadHand(bool lead) {
  const std::shared_lock lock(mutex_);
  worker_->ask(&ClientSession::leadHand, lead, monotonicNow_ns());
}

void ServerLink::commandHand(const HandCommand& command) {
  const std::shared_lock lock(mutex_);
  worker_->ask(&ClientSession::commandHand, command, monotonicNow_ns());
}

void ServerLink::addWrench(std::size_t hand, const Wrench& wrench) {
  const std::shared_lock lock(mutex_);
  worker_->ask(&ClientSession::addWrench, hand, wrench);
}

void ServerLink::setWorkspace(const v1::SetWorkspace& message) {
  const std::shared_lock lock(mutex_);
  worker_->ask(&ClientSession::setWorkspace, message);
}

}  // namespace haptics
