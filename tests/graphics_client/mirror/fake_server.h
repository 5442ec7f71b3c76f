#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "common/scene/scene.h"
#include "common/wire/framing.h"
#include "common/wire/transport.h"
#include "graphics_client/mirror/client_session.h"
#include "tests/common/wire/memory_link.h"

namespace haptics {

/// A server that says only what a test has it say, and remembers what it heard.
class FakeServer {
 public:
  /// A new client; the one before is dropped, what was heard is forgotten.
  void accept(std::unique_ptr<Transport> transport);
  void drop() { transport_.reset(); }

  void send(v1::Envelope envelope);
  void sendBytes(std::string bytes) { transport_->send(std::move(bytes)); }
  void welcome(bool resumed);
  void snapshot();
  void heartbeat();
  void telemetry(std::uint64_t tick, std::uint64_t time_ns = 1);
  void chunk(const ContentHash& hash, std::uint64_t offset, std::size_t size);
  /// All of an asset from this offset on, in chunks.
  void asset(const ContentHash& hash, std::uint64_t offset = 0);
  void accepted(std::uint64_t clientSeq, std::uint64_t revision);
  void live(std::uint64_t clientSeq, std::uint64_t revision, std::uint64_t tick);

  /// Changes the scene by one commit and returns it, unsent.
  v1::Commit change(const ObjectRecord& put);
  void sendCommit(const v1::Commit& commit);
  /// A mesh that can be asked for; its hash.
  ContentHash addMesh(const TriMesh& mesh);
  /// Puts an object with a mesh of its own into the scene; without telling anybody.
  v1::Commit addObject(const std::string& name);
  /// A new start without memory: another epoch, an empty scene.
  void restart();

  /// The messages of one kind that were heard on this connection, oldest first.
  [[nodiscard]] std::vector<v1::Envelope> heard(v1::Envelope::BodyCase kind) const;
  [[nodiscard]] const std::vector<v1::Envelope>& heard() const noexcept { return heard_; }
  [[nodiscard]] bool connected() const noexcept { return transport_ != nullptr; }

  std::uint64_t epoch = 1'001;
  std::uint16_t datagramPort = 0;
  std::string datagramCookie;
  /// What becomes of each frame on its way, if anything is to.
  std::function<std::vector<std::string>(std::string)> distort;
  SceneVersion scene;
  std::map<ContentHash, std::string> assets;

 private:
  std::unique_ptr<Transport> transport_;
  FrameDecoder decoder_;
  std::vector<v1::Envelope> heard_;
  std::uint64_t nextMessageId_ = 1;
  ObjectId nextObject_ = 1;
};

/// A session, a fake server, a line between them, and virtual time.
class SessionRig {
 public:
  explicit SessionRig(
      ClientSession::Options options = {
          .session = 77, .clientName = "test", .token = "", .telemetryRate_Hz = 60, .fetchAssets = true});

  /// A new connection: the client's Hello has arrived.
  void connect();
  /// As connect(), then a welcome with a snapshot and the meshes that are asked for.
  void join();
  void settle();
  /// The line breaks; the client knows.
  void cut();
  /// Time passes, with polls as often as the session wants them.
  void advance(std::uint64_t duration_ns);
  [[nodiscard]] MirrorView view() const { return client.view(now_ns); }

  std::uint64_t now_ns = 1'000'000'000'000;
  FakeServer server;
  ClientSession client;
  std::optional<MemoryLink> link;
  std::unique_ptr<Transport> clientEnd;
  int connectionsEnded = 0;

 private:
  void dropIfOver();
};

/// A closed mesh whose size, and so whose hash, depends on the number.
[[nodiscard]] TriMesh tetrahedron(float size_m);
/// A grid of n x n squares: large enough to go in several chunks.
[[nodiscard]] TriMesh grid(std::uint32_t n);
[[nodiscard]] v1::Transaction removal(std::uint64_t objectId);

}  // namespace haptics
