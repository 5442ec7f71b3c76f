#include "haptic_server/net/connections.h"

#include <algorithm>
#include <exception>
#include <utility>
#include <vector>

#include "common/clock/monotonic.h"
#include "common/wire/endpoint.h"

namespace haptics {

void Connections::post(std::function<void(Connections&)> task) {
  loop_.post([weak = weak_from_this(), task = std::move(task)] {
    if (const auto self = weak.lock()) task(*self);
  });
}

std::function<void(Connections::SessionTask)> Connections::postTo(std::uint64_t number) {
  return [weak = weak_from_this(), number](SessionTask task) {
    const auto self = weak.lock();
    if (!self) return;
    self->post([number, task = std::move(task)](Connections& all) {
      if (const auto at = all.connections_.find(number); at != all.connections_.end()) task(at->second->session());
    });
  };
}

void Connections::openDatagrams(const Endpoint& local) {
  const auto received = [this](std::span<const char> bytes, const Endpoint& from) {
    shared_.paths.received(bytes, from, monotonicNow_ns());
  };
  auto socket = DatagramSocket::open(loop_, local, received);
  if (!socket) socket = DatagramSocket::open(loop_, {local.host, 0}, received);
  if (socket) shared_.datagrams = *std::move(socket);
}

void Connections::accept(std::unique_ptr<Transport> transport) {
  if (closing_) return;
  if (tls_ && !admitsHandshake(transport->peer())) return;
  dropOldestHalfOpen();
  if (tls_) transport = tls_->secure(std::move(transport));
  const std::uint64_t number = nextNumber_++;
  auto made = std::make_unique<Connection>(*this, shared_, identity_, number, std::move(transport));
  ServerSession& session = connections_.emplace(number, std::move(made)).first->second->session();
  session.start();
  if (const auto& sample = shared_.servo.last()) session.adopted(sample->sceneRevision, sample->adoptionTick);
}

bool Connections::admitsHandshake(const std::string& peer) {
  const auto from = parseEndpoint(peer);
  if (!from || handshakes_.allow(from->host, monotonicNow_ns())) return true;  // from this process: no endpoint
  ++shared_.refusedConnections;
  log("dropped " + peer + ": its host connects more often than " +
      std::to_string(static_cast<int>(HandshakeLimit::kPerSecond)) + " times a second");
  return false;
}

void Connections::dropOldestHalfOpen() {
  if (connections_.size() - shared_.clients < kMaxHalfOpen) return;
  const auto oldest =
      std::ranges::find_if(connections_, [](const auto& entry) { return !entry.second->session().welcomed(); });
  ++shared_.refusedConnections;
  log("dropped " + oldest->second->peer() + ": too many connections that say nothing");
  remove(oldest->first);  // it may have led the hand, and be on its way out
}

/// One session that fails costs its own connection.
template <class Task>
void Connections::each(Task task) {
  for (auto& [number, connection] : connections_) {
    try {
      task(*connection);
    } catch (const std::exception& failure) {
      connection->session().refuse("", std::string("the server could not serve the client: ") + failure.what());
    }
  }
}

void Connections::sceneChanged(std::shared_ptr<const SceneHistory> history) {
  shared_.history = std::move(history);
  each([](Connection& connection) { connection.session().sceneChanged(); });
}

void Connections::refreshTokens(bool anyway) {
  const auto changed = shared_.admission.refresh(anyway);
  if (!changed) return log("the tokens stay as they were: " + changed.error().text());
  if (!*changed) return;
  log("the list of tokens was read again");
  each([this](Connection& connection) {
    if (!connection.session().welcomed()) return;
    const auto allowed = shared_.admission.check(connection.client());
    if (!allowed) connection.session().refuse(allowed.error().field, allowed.error().reason);
  });
}

bool Connections::drainTelemetry() {
  return shared_.servo.drain([this](std::uint64_t revision, std::uint64_t tick) {
    each([&](Connection& connection) { connection.session().adopted(revision, tick); });
  });
}

double Connections::serve_Hz() {
  const bool any = drainTelemetry();
  double highest_Hz = 0;
  bool everyTick = false;
  each([&](Connection& connection) {
    ServerSession& session = connection.session();
    if (any) session.offerTelemetry(*shared_.servo.last(), shared_.servo.lastOfSecondHand());
    session.poll();
    highest_Hz = std::max(highest_Hz, session.telemetryRate_Hz());
    everyTick = everyTick || session.wantsEveryTick();
  });
  shared_.servo.ticks().keep(everyTick);
  return highest_Hz;
}

void Connections::closeAll(const std::string& why) {
  closing_ = true;
  for (auto& [number, connection] : connections_) connection->session().close(why);
  if (connections_.empty()) loop_.stop();
}

void Connections::clear() {
  connections_.clear();
  shared_.datagrams.reset();
}

Result<Role> Connections::admit(SessionId id, const std::string& token) const {
  std::vector<Admission::Client> others;
  for (const auto& [number, other] : connections_) {
    if (other->session().welcomed()) others.push_back(other->client());
  }
  return shared_.admission.admit(id, token, others);
}

void Connections::claimed(const Connection& by, SessionId id) {
  log(by.described() + " joined");
  for (auto& [number, other] : connections_) {
    if (other.get() != &by && other->session().welcomed() && other->session().id() == id) {
      other->session().close("its session goes on in a newer connection");
    }
  }
  countClients();
}

void Connections::assetDecided(const Upload& upload, const Result<std::shared_ptr<const Asset>>& asset) {
  const auto at = connections_.find(upload.connection);
  if (at == connections_.end()) {
    shared_.uploads.release(upload.token, upload.reserved_bytes);
  } else {
    at->second->session().assetDecided(upload.hash, asset);
  }
}

Result<void> Connections::leadHand(std::uint64_t number, std::size_t hand, bool lead) {
  const bool isLeader = shared_.handLeader[hand] == number;
  if (lead == isLeader) return {};
  if (!lead) {
    setHandLeader(hand, std::nullopt);
    return {};
  }
  if (const auto other = handLeader(hand); other && other->session != connections_.at(number)->session().id())
    return refused("lead_hand", "the hand is led by " + other->name);
  HandHost* host = shared_.hand(hand);
  if (host == nullptr)
    return refused("lead_hand.hand", "is the second, and this server has one (haptic_server --device A --device B)");
  if (!host->commandHand({})) {
    return refused("lead_hand", "the device is " + (hand == 0 ? identity_.device : identity_.secondDevice) +
                                    "; only a simulated one has a hand to lead");
  }
  setHandLeader(hand, number);
  return {};
}

std::optional<SessionHost::Leader> Connections::handLeader(std::size_t hand) const {
  if (!shared_.handLeader[hand]) return std::nullopt;
  const auto leader = connections_.find(*shared_.handLeader[hand]);
  if (leader == connections_.end()) return std::nullopt;
  const ServerSession& session = leader->second->session();
  return SessionHost::Leader{session.name(), session.id()};
}

/// The hand is let go of at once where nobody leads it any more.
void Connections::setHandLeader(std::size_t hand, std::optional<std::uint64_t> number) {
  shared_.handLeader[hand] = number;
  if (!number) static_cast<void>(shared_.hand(hand)->commandHand({}));
  each([hand](Connection& connection) { connection.session().handLeaderChanged(hand); });
}

void Connections::remove(std::uint64_t number) {
  for (std::size_t hand = 0; hand < kMaxLedHands; ++hand) {
    if (shared_.handLeader[hand] == number) setHandLeader(hand, std::nullopt);
    if (auto& giver = shared_.wrenchGiver[hand]; giver && giver->connection == number) {
      giver.reset();
      static_cast<void>(shared_.hand(hand)->addWrench({}));
    }
  }
  connections_.erase(number);
  shared_.paths.remove(number);
  countClients();
  if (closing_ && connections_.empty()) loop_.stop();
}

void Connections::countClients() {
  std::uint32_t clients = 0;
  for (const auto& [number, connection] : connections_) clients += connection->session().welcomed() ? 1 : 0;
  shared_.clients = clients;
}

}  // namespace haptics
