#include "tests/graphics_client/mirror/fake_server.h"

#include <gtest/gtest.h>

#include "common/mesh/mesh_asset.h"
#include "common/wire/convert.h"

namespace haptics {

void FakeServer::accept(std::unique_ptr<Transport> transport) {
  transport_ = std::move(transport);
  decoder_ = {};
  heard_.clear();
  nextMessageId_ = 1;
  transport_->start({.received =
                         [this](std::span<const char> bytes) {
                           decoder_.feed(bytes);
                           for (auto next = decoder_.next(); next && *next; next = decoder_.next()) {
                             EXPECT_EQ((*next)->protocol_version(), kProtocolVersion);
                             EXPECT_EQ((*next)->message_id(), heard_.size() + 1);
                             heard_.push_back(**next);
                           }
                         },
                     .drained = {},
                     .closed = [this](const std::string&) { transport_.reset(); }});
}

void FakeServer::send(v1::Envelope envelope) {
  envelope.set_protocol_version(kProtocolVersion);
  envelope.set_message_id(nextMessageId_++);
  std::string frame;
  (void)appendFrame(frame, envelope);
  if (!distort) return transport_->send(std::move(frame));
  for (std::string& part : distort(std::move(frame))) transport_->send(std::move(part));
}

void FakeServer::welcome(bool resumed) {
  v1::Envelope envelope;
  v1::Welcome& welcome = *envelope.mutable_welcome();
  welcome.set_epoch(epoch);
  welcome.set_revision(scene.revision());
  welcome.set_root(scene.root().asBytes());
  welcome.set_resumed(resumed);
  welcome.set_server_name("fake");
  welcome.set_device("simulated");
  welcome.set_servo_rate_hz(1000);
  welcome.set_max_force_n(5);
  welcome.set_may_edit(true);
  welcome.set_datagram_port(datagramPort);
  welcome.set_datagram_cookie(datagramCookie);
  send(envelope);
}

void FakeServer::snapshot() {
  v1::Envelope begin;
  begin.mutable_snapshot_begin()->set_revision(scene.revision());
  begin.mutable_snapshot_begin()->set_object_count(scene.objects().size());
  send(begin);
  for (const auto& object : scene.objects()) {
    v1::Envelope objects;
    toWire(*object, *objects.mutable_snapshot_objects()->add_object());
    send(objects);
  }
  v1::Envelope end;
  end.mutable_snapshot_end()->set_revision(scene.revision());
  end.mutable_snapshot_end()->set_root(scene.root().asBytes());
  send(end);
}

void FakeServer::heartbeat() {
  v1::Envelope envelope;
  envelope.mutable_heartbeat()->set_epoch(epoch);
  envelope.mutable_heartbeat()->set_revision(scene.revision());
  envelope.mutable_heartbeat()->set_root(scene.root().asBytes());
  send(envelope);
}

void FakeServer::telemetry(std::uint64_t tick, std::uint64_t time_ns) {
  v1::Envelope envelope;
  envelope.mutable_telemetry()->set_tick(tick);
  envelope.mutable_telemetry()->set_time_ns(time_ns);
  send(envelope);
}

void FakeServer::chunk(const ContentHash& hash, std::uint64_t offset, std::size_t size) {
  v1::Envelope envelope;
  v1::AssetChunk& chunk = *envelope.mutable_asset_chunk();
  chunk.set_hash(hash.asBytes());
  chunk.set_kind(v1::ASSET_KIND_MESH);
  chunk.set_total_size(assets.at(hash).size());
  chunk.set_offset(offset);
  chunk.set_data(assets.at(hash).substr(offset, size));
  send(envelope);
}

void FakeServer::asset(const ContentHash& hash, std::uint64_t offset) {
  constexpr std::size_t kChunk = 4'000;
  for (; offset < assets.at(hash).size(); offset += kChunk) chunk(hash, offset, kChunk);
}

void FakeServer::accepted(std::uint64_t clientSeq, std::uint64_t revision) {
  v1::Envelope envelope;
  envelope.mutable_edit_reply()->set_client_seq(clientSeq);
  envelope.mutable_edit_reply()->mutable_accepted()->set_revision(revision);
  send(envelope);
}

void FakeServer::live(std::uint64_t clientSeq, std::uint64_t revision, std::uint64_t tick) {
  v1::Envelope envelope;
  envelope.mutable_edit_live()->set_client_seq(clientSeq);
  envelope.mutable_edit_live()->set_revision(revision);
  envelope.mutable_edit_live()->set_tick(tick);
  send(envelope);
}

v1::Commit FakeServer::change(const ObjectRecord& put) {
  Commit commit;
  commit.revision = scene.revision() + 1;
  commit.prevRoot = scene.root();
  commit.put = {put};
  commit.put[0].revision = commit.revision;
  auto next = scene.apply(commit);
  EXPECT_TRUE(next) << next.error().text();
  scene = *next;
  commit.root = scene.root();
  v1::Commit message;
  toWire(commit, message);
  return message;
}

void FakeServer::sendCommit(const v1::Commit& commit) {
  v1::Envelope envelope;
  *envelope.mutable_commit() = commit;
  send(envelope);
}

ContentHash FakeServer::addMesh(const TriMesh& mesh) {
  const ContentHash hash = hashOf(mesh);
  assets[hash] = encodeMesh(mesh);
  return hash;
}

v1::Commit FakeServer::addObject(const std::string& name) {
  ObjectRecord record;
  record.id = nextObject_++;
  record.name = name;
  record.mesh = addMesh(tetrahedron(static_cast<float>(record.id)));
  return change(record);
}

void FakeServer::restart() {
  ++epoch;
  scene = SceneVersion();
  nextObject_ = 1;
}

std::vector<v1::Envelope> FakeServer::heard(v1::Envelope::BodyCase kind) const {
  std::vector<v1::Envelope> some;
  for (const v1::Envelope& envelope : heard_) {
    if (envelope.body_case() == kind) some.push_back(envelope);
  }
  return some;
}

SessionRig::SessionRig(ClientSession::Options options) : client(std::move(options)) {}

void SessionRig::connect() {
  link.emplace();
  clientEnd = link->takeClient();
  clientEnd->start({.received =
                        [this](std::span<const char> bytes) {
                          client.received(bytes, now_ns);
                          dropIfOver();
                        },
                    .drained = [this] { client.drained(); },
                    .closed =
                        [this](const std::string& why) {
                          ++connectionsEnded;
                          clientEnd.reset();
                          client.connectionLost(why);
                        }});
  server.accept(link->takeServer());
  client.connected(*clientEnd, now_ns);
  settle();
}

void SessionRig::join() {
  connect();
  server.welcome(false);
  server.snapshot();
  settle();
  for (const v1::Envelope& request : server.heard(v1::Envelope::kAssetRequest)) {
    server.asset(*ContentHash::fromBytes(request.asset_request().hash()), request.asset_request().offset());
  }
  settle();
}

void SessionRig::settle() { link->settle(); }

void SessionRig::cut() {
  link->cut("cut");
  settle();
}

void SessionRig::advance(std::uint64_t duration_ns) {
  for (const std::uint64_t end = now_ns + duration_ns; now_ns < end;) {
    now_ns = std::min(end, now_ns + ClientSession::kPoll_ns);
    client.poll(now_ns);
    dropIfOver();
    settle();
  }
}

void SessionRig::dropIfOver() {
  if (!client.connectionOver()) return;
  ++connectionsEnded;
  const std::string why = client.overReason();
  clientEnd.reset();
  client.connectionLost(why);
}

TriMesh tetrahedron(float size_m) {
  TriMesh mesh;
  mesh.vertices = {{0, 0, 0}, {size_m, 0, 0}, {0, size_m, 0}, {0, 0, size_m}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

TriMesh grid(std::uint32_t n) {
  TriMesh mesh;
  for (std::uint32_t y = 0; y <= n; ++y) {
    for (std::uint32_t x = 0; x <= n; ++x)
      mesh.vertices.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.F);
  }
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t corner = y * (n + 1) + x;
      mesh.triangles.push_back({corner, corner + 1, corner + n + 2});
      mesh.triangles.push_back({corner, corner + n + 2, corner + n + 1});
    }
  }
  return mesh;
}

v1::Transaction removal(std::uint64_t objectId) {
  v1::Transaction transaction;
  transaction.add_operations()->mutable_remove()->mutable_object()->set_id(objectId);
  return transaction;
}

}  // namespace haptics
