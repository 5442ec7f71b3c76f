#include "tests/sim/sim_client.h"

#include <utility>

#include "tests/sim/frame_tap.h"

namespace haptics::sim {
namespace {

constexpr std::uint64_t kPoll_ns = ClientSession::kPoll_ns;
constexpr double kTelemetryRate_Hz = 10;
/// Two heartbeats, and what a bad network may add to them while the connection lives.
constexpr std::uint64_t kFoundWithin_ns = 2 * ClientSession::kHeartbeat_ns + ClientSession::kSilence_ns;

}  // namespace

SimClient::SimClient(Stage& stage, const Weather& weather, Dial dial, const std::string& token, bool badMemory)
    : stage_(stage),
      weather_(weather),
      dial_(std::move(dial)),
      badMemory_(badMemory),
      id_(stage.random.bits() / 1000 * 1000 + ++stage.sessions),
      clockStart_ns_(stage.random.milliseconds(1e3, 1e9)),
      session_(std::make_unique<ClientSession>(ClientSession::Options{.session = id_,
                                                                      .clientName = "client",
                                                                      .token = token,
                                                                      .telemetryRate_Hz = kTelemetryRate_Hz,
                                                                      .frames = stage.limits.session.frames})) {
  stage.oracle.clientStarted(id_, token);
  connect();
  poll();
}

SimClient::~SimClient() = default;

void SimClient::submit(v1::Transaction transaction, Intent intent) {
  const std::uint64_t seq = lastSeq_ + 1;
  bool taken = true;  // into the outbox; else the answer comes from within
  ++unanswered_;
  session_->submit(std::move(transaction), {.replied =
                                                [this, &taken](const v1::EditReply& reply) {
                                                  if (reply.client_seq() == 0) {
                                                    taken = false;
                                                  } else {
                                                    stage_.oracle.replied(id_, reply);
                                                  }
                                                  if (!reply.has_accepted()) --unanswered_;
                                                },
                                            .live =
                                                [this](const v1::EditLive& live) {
                                                  --unanswered_;
                                                  stage_.oracle.live(id_, live);
                                                },
                                            .stateLost =
                                                [this, seq] {
                                                  --unanswered_;
                                                  stage_.oracle.stateLost(id_, seq);
                                                }});
  if (!taken) return;
  lastSeq_ = seq;
  stage_.oracle.submitted(id_, seq, std::move(intent));
  settle();
}

void SimClient::upload(AssetKind kind, std::string bytes, std::function<void(bool)> finished) {
  ++unanswered_;
  session_->upload(
      kind, std::move(bytes),
      {.progress = {}, .finished = [this, finished = std::move(finished)](const v1::AssetUploadReply& reply) {
         --unanswered_;
         if (!reply.accepted()) stage_.oracle.fail("an upload was refused: " + reply.field() + ": " + reply.reason());
         finished(reply.accepted());
       }});
}

void SimClient::requestStatus() {
  ++unanswered_;
  session_->requestStatus([this](const v1::Status&) { --unanswered_; });
}

void SimClient::connect() {
  const std::uint64_t roundTrip_ns =
      2 * stage_.random.milliseconds(weather_.latency_ms, weather_.latency_ms + weather_.jitter_ms);
  stage_.time.after(roundTrip_ns, alive_, [this] {
    line_ = dial_(weather_);
    if (!line_) return lost("nobody listens");
    ++connection_;
    transport_ = line_->takeClient();
    tap_ = nullptr;
    if (badMemory_ || isOnTheWire(stage_.mutant)) {
      auto tap = std::make_unique<FrameTap>(std::move(transport_), stage_.mutant, session_->mirror(), stage_.random);
      tap_ = tap.get();
      transport_ = std::move(tap);
    }
    transport_->start({.received =
                           [this](std::span<const char> bytes) {
                             session_->received(bytes, now_ns());
                             settle();
                           },
                       .drained = [this] { session_->drained(); },
                       .closed = [this](const std::string& why) { lost(why); }});
    session_->connected(*transport_, now_ns());
    settle();
  });
}

void SimClient::poll() {
  if (!stopped_) {
    session_->poll(now_ns());
    watchMemory();
    settle();
  }
  stage_.time.after(kPoll_ns, alive_, [this] { poll(); });
}

void SimClient::settle() {
  stage_.oracle.viewed(id_, session_->mirror());
  if (!session_->connectionOver()) return;
  const std::string why = session_->overReason();
  stage_.oracle.connectionOver(id_, why);
  lost(why);
}

void SimClient::lost(const std::string& why) {
  stage_.log.add([&] { return "client " + std::to_string(id_ % 1000) + ": lost its connection: " + why; });
  transport_.reset();
  tap_ = nullptr;
  line_.reset();
  session_->connectionLost(why);
  stage_.time.after(session_->reconnectDelay_ns(), alive_, [this] { connect(); });
}

void SimClient::stopFor(std::uint64_t duration_ns) {
  stage_.log.add([&] { return "client " + std::to_string(id_ % 1000) + ": stops for a while"; });
  stopped_ = true;
  damagedAt_ns_ = 0;
  withLine([](Line& line) { line.clientReads(false); });
  stage_.time.after(duration_ns, alive_, [this, stop = ++stops_] {
    if (stop != stops_) return;
    stopped_ = false;
    withLine([](Line& line) { line.clientReads(true); });
  });
}

void SimClient::reconnect() {
  if (transport_) lost("left in a hurry");
}

void SimClient::withLine(const std::function<void(Line&)>& what) {
  if (line_) what(*line_);
}

void SimClient::corruptMemory() {
  const auto& objects = mirror().scene().objects();
  const auto& meshes = mirror().contents().meshes;
  const auto& residues = mirror().contents().movedVertices;
  if (stage_.random.chance(0.4)) {
    if (tap_ != nullptr) tap_->flipNext([this] { stage_.oracle.corrupted(id_); });
    return;
  }
  if (objects.empty() || meshes.empty()) return;
  if (!residues.empty() && stage_.random.chance(0.2)) {
    auto& moved = const_cast<MovedVertices&>(*residues.begin()->second);
    moved.place[stage_.random.below(moved.place.size())].z += 0.25F;
  } else if (stage_.random.chance(0.3)) {
    const auto at = std::next(meshes.begin(), static_cast<std::ptrdiff_t>(stage_.random.below(meshes.size())));
    auto& mesh = const_cast<TriMesh&>(*at->second);
    mesh.vertices[stage_.random.below(mesh.vertices.size())].y += 0.25F;
  } else {
    auto& record = const_cast<ObjectRecord&>(*objects[stage_.random.below(objects.size())]);
    if (auto& friction = record.material.surface.friction; friction && stage_.random.chance(0.5)) {
      friction->mu_dynamic += 0.25;
    } else if (stage_.random.chance(0.5)) {
      record.pose.position.x += 0.25;
    } else {
      record.material.stiffness_N_per_m *= 2;
    }
  }
  stage_.oracle.corrupted(id_);
  damagedAt_ns_ = stopped_ ? 0 : stage_.time.now_ns();  // a stopped process looks at nothing
  damagedConnection_ = connection_;
}

/// On a connection that lives, damage is found by the heartbeats.
void SimClient::watchMemory() {
  if (damagedAt_ns_ == 0) return;
  if (connection_ != damagedConnection_ || !live()) {
    damagedAt_ns_ = 0;
    return;
  }
  if (stage_.time.now_ns() - damagedAt_ns_ < kFoundWithin_ns) return;
  damagedAt_ns_ = 0;
  const auto own = recomputedRoot(view());
  if (own && *own != mirror().scene().root()) stage_.oracle.corruptionOverlooked(id_);
}

}  // namespace haptics::sim
