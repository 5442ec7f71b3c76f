#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "graphics_client/editing/edit_history.h"
#include "graphics_client/mirror/edit_outbox.h"
#include "haptic_server/scene/asset_library.h"
#include "haptic_server/scene/sequencer.h"

namespace haptics::test {

/// The server's sequencer with its real assets, and what a client mirrors of it.
class EditServer {
 public:
  /// @param folders  Of its own files.
  explicit EditServer(std::vector<std::filesystem::path> folders = {}, std::uint64_t epoch = 7)
      : library_(std::move(folders), store_), sequencer_(epoch, library_) {}
  v1::EditReply decide(SessionId session, const v1::EditRequest& request);
  /// Holds it for the next edit that is accepted.
  Result<void> upload(const AssetContent& content);
  /// As the server itself does it: another residue in an object.
  void bake(const std::string& name, MovedVertices residue);

  [[nodiscard]] const SceneVersion& scene() const { return sequencer_.history()->version; }
  [[nodiscard]] std::shared_ptr<const MirrorView> mirrored() const;
  [[nodiscard]] bool holds(const ContentHash& asset) const { return store_.find(asset) != nullptr; }
  std::size_t uploads = 0, accepted = 0;

 private:
  AssetStore store_;
  AssetLibrary library_;
  Sequencer sequencer_;
  std::vector<std::shared_ptr<const Asset>> uploaded_;
};

/// One user's connection: answers come when they are delivered, and are lost with the connection.
class EditClient {
 public:
  EditClient(EditServer& server, SessionId session) : server_(server), session_(session) {}

  [[nodiscard]] EditPort port();
  /// Has the server decide the next edit and brings the reply. False: there is none, or no connection.
  bool deliver();
  void deliverAll() {
    while (deliver()) {
    }
  }
  /// The server decides the next edit, whose reply is lost.
  void loseConnection();
  void reconnect() { isConnected_ = true; }
  /// The view stays as it is until the next call.
  void holdMirror() { showMirror(server_.mirrored()); }
  void showMirror(std::shared_ptr<const MirrorView> view) { held_ = std::move(view); }
  void releaseMirror() { held_ = nullptr; }
  std::size_t submitted = 0, inFlight = 0, mostInFlight = 0;

 private:
  EditServer& server_;
  const SessionId session_;
  EditOutbox outbox_;
  bool isConnected_ = true;
  std::shared_ptr<const MirrorView> held_;
};

/// A user with a history. Each edit is answered at once.
class Editor {
 public:
  Editor(EditServer& server, SessionId session) : client(server, session) {}

  Result<void> submit(const v1::Transaction& transaction, std::vector<AssetContent> uploads = {});
  Result<void> undo();
  Result<void> redo();

  EditClient client;
  EditHistory history{client.port()};
};

/// Text format: operations { ... }.
[[nodiscard]] v1::Transaction parsed(const std::string& text);
/// Adds a box of 0.1 m.
[[nodiscard]] v1::Transaction addBox(const std::string& name);
[[nodiscard]] v1::Transaction setStiffness(const std::string& name, double stiffness_N_per_m);
[[nodiscard]] v1::Transaction moveTo(const std::string& name, double x_m);
[[nodiscard]] v1::Transaction removal(const std::string& name);

/// Of the objects in order of name, without ids and revisions. The root cannot serve: it contains both, and an undone
/// scene is a newer revision in which an object that was added again has another id.
[[nodiscard]] ContentHash contentHash(const SceneVersion& scene, bool withResidues = true);

}  // namespace haptics::test
