#include <algorithm>
#include <atomic>
#include <deque>
#include <functional>
#include <list>
#include <map>
#include <stdexcept>
#include <thread>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/wire/tcp.h"
#include "common/wire/udp.h"
#include "tests/stress/impairment.h"
#include "tests/stress/network.h"

namespace haptics::stress {
namespace {

constexpr const char* kServerHost = "127.0.0.1";
constexpr const char* kRelayHost = "127.0.0.2";  // of its own, so that UDP finds the same port there

class Relay final : public Network {
 public:
  explicit Relay(const RunPlan& plan) : plan_(plan), impairment_(plan) {}
  ~Relay() override {
    loop_.stop();
    if (thread_.joinable()) thread_.join();
  }

  [[nodiscard]] std::string kind() const override { return "relay of TCP and UDP on loopback"; }
  [[nodiscard]] std::string serverHost() const override { return kServerHost; }
  [[nodiscard]] std::string clientAddress(std::uint16_t port) override {
    if (port_ != port) open(port);
    return std::string(kRelayHost) + ":" + std::to_string(port);
  }
  void enterServerSide() const override {}
  void enterClientSide() const override {}
  void start() override {
    thread_ = std::thread([this] { loop_.run(); });
  }
  [[nodiscard]] NetworkCounts counts() override { return {packets_, lost_}; }

 private:
  struct Connection {
    std::unique_ptr<Transport> client, server;
    std::unique_ptr<TcpConnector> connector;
    std::string early;  // from the client, before the server's side is there
    std::deque<std::string> onTheWay[2];
    std::uint64_t lastDue_ns[2] = {0, 0};
    bool over = false;
  };
  using Shared = std::shared_ptr<Connection>;

  void open(std::uint16_t port) {
    port_ = port;
    auto listener = TcpListener::open(loop_, {kRelayHost, port},
                                      [this](std::unique_ptr<Transport> client) { accept(std::move(client)); });
    if (!listener) throw std::runtime_error(listener.error().text());
    listener_ = *std::move(listener);
    auto socket =
        DatagramSocket::open(loop_, {kRelayHost, port},
                             [this](std::span<const char> bytes, const Endpoint& from) { fromClient(bytes, from); });
    if (!socket) throw std::runtime_error(socket.error().text());
    datagrams_ = *std::move(socket);
  }

  void later(std::uint64_t due_ns, std::function<void()> task) {
    const std::uint64_t number = nextTask_++;
    const std::uint64_t now_ns = monotonicNow_ns();
    tasks_[number] = loop_.after(std::chrono::nanoseconds(due_ns > now_ns ? due_ns - now_ns : 0),
                                 [this, number, task = std::move(task)] {
                                   const Timer self = std::move(tasks_[number]);
                                   tasks_.erase(number);
                                   task();
                                 });
  }

  void accept(std::unique_ptr<Transport> client) {
    const auto pair = std::make_shared<Connection>();
    connections_.push_back(pair);
    pair->client = std::move(client);
    pair->client->start({.received = [this, pair](std::span<const char> bytes) { carry(pair, bytes, 0); },
                         .drained = {},
                         .closed = [this, pair](const std::string&) { end(pair); }});
    pair->connector = std::make_unique<TcpConnector>(
        loop_, Endpoint{kServerHost, port_}, [this, pair](Result<std::unique_ptr<Transport>> server) {
          if (!server || pair->over) return end(pair);
          pair->server = *std::move(server);
          pair->server->start({.received = [this, pair](std::span<const char> bytes) { carry(pair, bytes, 1); },
                               .drained = {},
                               .closed = [this, pair](const std::string&) { end(pair); }});
          pair->server->send(std::exchange(pair->early, {}));
        });
  }

  /// A stream loses nothing: what a cut or a loss takes comes again, one round trip later.
  void carry(const Shared& pair, std::span<const char> bytes, int direction) {
    ++packets_;
    const std::uint64_t now_ns = monotonicNow_ns();
    const auto roundTrip_ns = static_cast<std::uint64_t>(plan_.rtt_ms * 1e6);
    std::uint64_t due_ns = now_ns + impairment_.delay_ns();
    while (plan_.cutAt(due_ns)) due_ns += roundTrip_ns + 1'000'000;
    if (impairment_.lost()) {
      ++lost_;
      due_ns += roundTrip_ns;
    }
    due_ns = pair->lastDue_ns[direction] = std::max(due_ns, pair->lastDue_ns[direction]);
    pair->onTheWay[direction].emplace_back(bytes.begin(), bytes.end());
    later(due_ns, [pair, direction] { deliver(*pair, direction); });
  }

  /// The oldest piece, whichever piece's time it is: the order stays.
  static void deliver(Connection& pair, int direction) {
    if (pair.over) return;
    std::string piece = std::move(pair.onTheWay[direction].front());
    pair.onTheWay[direction].pop_front();
    if (direction == 1) return pair.client->send(std::move(piece));
    if (pair.server) return pair.server->send(std::move(piece));
    pair.early += piece;
  }

  void end(const Shared& pair) {
    if (pair->over) return;
    pair->over = true;
    later(monotonicNow_ns(), [this, pair] {
      pair->client.reset();
      pair->server.reset();
      pair->connector.reset();
      connections_.remove(pair);
    });
  }

  void fromClient(std::span<const char> bytes, const Endpoint& from) {
    auto& towards = servers_[from.text()];
    if (!towards) {
      auto socket =
          DatagramSocket::open(loop_, {kServerHost, 0}, [this, from](std::span<const char> answer, const Endpoint&) {
            impair(answer, [this, from](const std::string& piece) { datagrams_->send(piece, from); });
          });
      if (!socket) return;
      towards = *std::move(socket);
    }
    impair(bytes, [socket = towards.get(), this](const std::string& piece) {
      socket->send(piece, {kServerHost, port_});
    });
  }

  void impair(std::span<const char> bytes, std::function<void(const std::string&)> arrived) {
    ++packets_;
    const auto due_ns = impairment_.arrival_ns(monotonicNow_ns());
    if (!due_ns) {
      ++lost_;
      return;
    }
    later(*due_ns, [arrived = std::move(arrived), piece = std::string(bytes.begin(), bytes.end())] { arrived(piece); });
  }

  const RunPlan& plan_;
  Impairment impairment_;
  EventLoop loop_;
  std::uint16_t port_ = 0;
  std::unique_ptr<TcpListener> listener_;
  std::unique_ptr<DatagramSocket> datagrams_;
  std::map<std::string, std::unique_ptr<DatagramSocket>> servers_;  // by client; a socket for each, as a NAT has
  std::list<Shared> connections_;
  std::map<std::uint64_t, Timer> tasks_;
  std::uint64_t nextTask_ = 0;
  std::atomic<std::uint64_t> packets_{0}, lost_{0};
  std::thread thread_;
};

}  // namespace

std::unique_ptr<Network> makeRelay(const RunPlan& plan) { return std::make_unique<Relay>(plan); }

}  // namespace haptics::stress
