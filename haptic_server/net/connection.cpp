#include "haptic_server/net/connection.h"

#include <utility>

#include "common/wire/convert.h"
#include "common/wire/endpoint.h"
#include "haptic_server/net/connections.h"

namespace haptics {
namespace {

/// After which another client's wrench is felt.
constexpr std::uint64_t kWrenchHeld_ns = 100'000'000;

}  // namespace

Connection::Connection(Connections& all, SharedByConnections& shared, const ServerIdentity& identity,
                       std::uint64_t number, std::unique_ptr<Transport> transport)
    : all_(all),
      shared_(shared),
      number_(number),
      transport_(std::move(transport)),
      session_(*transport_, *this, identity) {}

std::string Connection::described() const {
  return session_.name().empty() ? peer() : session_.name() + " (" + peer() + ")";
}

bool Connection::submitEdit(SessionId id, std::uint64_t clientSeq, Transaction transaction, bool wantsProgress) {
  const auto post = all_.postTo(number_);
  SceneService::EditProgress progress;
  if (wantsProgress) {
    progress = [post, clientSeq](WorkStage stage, double share) {
      post([clientSeq, stage, share](ServerSession& session) { session.editProgress(clientSeq, stage, share); });
    };
  }
  const auto reply = [post, clientSeq](const EditOutcome& outcome) {
    post([clientSeq, outcome](ServerSession& session) { session.editDecided(clientSeq, outcome); });
  };
  return shared_.sceneService.submitEdit(editSession(id), clientSeq, std::move(transaction), reply, left_.get_token(),
                                         std::move(progress));
}

std::optional<SceneHost::Place> Connection::waiting(SessionId id) {
  const auto waits = shared_.sceneService.waiting(editSession(id));
  return waits ? std::optional(Place{waits->clientSeq, waits->place}) : std::nullopt;
}

std::optional<ContentHash> Connection::deformedHash() {
  return shared_.shapes.hashOf(*shared_.history, shared_.servo.motion().dents(), now_ns());
}

bool Connection::submitAsset(const AssetName& name, std::string bytes) {
  const Connections::Upload upload{number_, token_, name.hash, bytes.size()};
  const auto reply = [all = all_.weak_from_this(), upload](const Result<std::shared_ptr<const Asset>>& asset) {
    const auto alive = all.lock();
    if (alive) alive->post([upload, asset](Connections& connections) { connections.assetDecided(upload, asset); });
  };
  return shared_.sceneService.submitAsset(editSession(session_.id()), name, std::move(bytes), reply, left_.get_token());
}

std::optional<Connection::DatagramOffer> Connection::offerDatagrams() {
  const auto from = parseEndpoint(peer());
  if (!shared_.datagrams || !from) return std::nullopt;
  return DatagramOffer{shared_.datagrams->local().port, shared_.paths.add(number_, from->host)};
}

Result<void> Connection::leadHand(std::size_t hand, bool lead) { return all_.leadHand(number_, hand, lead); }

void Connection::commandHand(std::size_t hand, const HandCommand& command) {
  if (shared_.handLeader[hand] == number_) static_cast<void>(shared_.hand(hand)->commandHand(command));
}

Result<void> Connection::moveWorkspace(std::size_t hand, const WorkspaceCommand& command) {
  HandHost* const moved = hand < kMaxLedHands ? shared_.hand(hand) : nullptr;
  if (moved == nullptr) return SessionHost::moveWorkspace(hand, command);
  return moved->moveWorkspace(command);
}

Result<void> Connection::addWrench(std::size_t hand, const Wrench& wrench) {
  HandHost* const felt = hand < kMaxLedHands ? shared_.hand(hand) : nullptr;
  if (felt == nullptr) return SessionHost::addWrench(hand, wrench);
  auto& giver = shared_.wrenchGiver[hand];
  const std::uint64_t now = now_ns();
  if (giver && giver->connection != number_ && now < giver->until_ns) return {};
  giver = {number_, now + kWrenchHeld_ns};
  if (wrench == Wrench{}) giver.reset();
  return felt->addWrench(wrench);
}

std::optional<SessionHost::Leader> Connection::handLeader(std::size_t hand) const { return all_.handLeader(hand); }

Result<Role> Connection::admit(SessionId id, const std::string& token) {
  token_ = hashOfToken(token);
  return all_.admit(id, token);
}

void Connection::sessionClaimed(SessionId id) { all_.claimed(*this, id); }

bool Connection::requestDump() {
  return shared_.host.requestDump([post = all_.postTo(number_)](const Result<std::string>& file) {
    post([file](ServerSession& session) { session.dumped(file); });
  });
}

void Connection::fillStatus(v1::Status& status) {
  shared_.host.fillStatus(status);
  for (const ObjectEnergy& object : shared_.servo.energy().objects()) {
    for (std::size_t i = 0; i < kEnergyFeatures; ++i) {
      if (object.given_J[i] == 0) continue;
      toWire({object.object, static_cast<EnergyFeature>(i), object.given_J[i]}, *status.add_energy());
    }
  }
  status.set_clients(shared_.clients);
  status.set_refused_connections(shared_.refusedConnections);
  status.set_forged_datagrams(shared_.paths.forged());
  if (const auto leader = all_.handLeader(0)) status.set_hand_leader(leader->name);
  if (const auto leader = all_.handLeader(1)) status.mutable_second_hand()->set_hand_leader(leader->name);
}

void Connection::refused(const std::string& why) {
  ++shared_.refusedConnections;
  shared_.logLine("refused " + described() + ": " + why);
  wasRefused_ = true;
}

void Connection::ended(const std::string& why) {
  if (!wasRefused_ && session_.id() != 0) shared_.logLine(described() + " left: " + why);
  if (!wasRefused_ && session_.id() == 0) refused(why);
  all_.post([number = number_](Connections& connections) { connections.remove(number); });
}

}  // namespace haptics
