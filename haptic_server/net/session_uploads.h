#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <unordered_map>

#include "common/error/error.h"
#include "haptic_server/net/session_host.h"
#include "haptic_server/net/upload_assembly.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// One client's uploads: under way, being built, and held until an edit names them. Their memory is taken from and
/// given back to the host's budget.
class SessionUploads {
 public:
  /// Uploads that no edit has named; beyond, the oldest is freed. As many as one edit may need to open a scene.
  static constexpr std::size_t kMaxHeld = 1000;

  /// An upload without a chunk for this long is given up, nanoseconds.
  static constexpr std::uint64_t kStalled_ns = 10'000'000'000;
  /// Memory is taken as the chunks come, at least so much and then twice what is there: whoever only announces bytes
  /// keeps nobody from the budget.
  static constexpr std::size_t kMinReserve_bytes = 1U << 20;

  /// Both hosts outlive this. Chunks have at most chunk_bytes.
  SessionUploads(const SceneHost& scene, UploadHost& host, std::size_t chunk_bytes)
      : scene_(scene), host_(host), assembly_(chunk_bytes) {}
  ~SessionUploads() { clear(); }
  SessionUploads(const SessionUploads&) = delete;
  SessionUploads& operator=(const SessionUploads&) = delete;

  /// Takes a chunk; hands a complete upload to the host. Not every chunk is answered.
  [[nodiscard]] std::optional<v1::AssetUploadReply> take(const v1::AssetChunk& chunk, std::uint64_t now_ns);
  /// Answers in place of take() a client that may not upload: once an upload.
  [[nodiscard]] std::optional<v1::AssetUploadReply> turnAway(const v1::AssetChunk& chunk, const Error& why);
  /// The host has built the upload, or not.
  [[nodiscard]] std::optional<v1::AssetUploadReply> decided(const ContentHash& hash,
                                                            Result<std::shared_ptr<const Asset>> outcome);
  /// Ends an upload that has stalled. To be called again and again; not every call has a reply.
  [[nodiscard]] std::optional<v1::AssetUploadReply> poll(std::uint64_t now_ns);
  /// The client gives an upload up. One that is being built is dropped when it is decided.
  void cancel(const ContentHash& hash);
  void named(const ContentHash& asset);  ///< The scene holds this asset from now on.
  void clear();  ///< Drops everything. What is being built keeps its reservation until it is decided.

 private:
  struct Building {
    std::size_t reserved = 0;  // bytes
    bool wanted = true;
  };
  struct Held {
    std::shared_ptr<const Asset> asset;
    std::size_t reserved;
  };
  const SceneHost& scene_;
  UploadHost& host_;
  UploadAssembly assembly_;
  std::size_t assemblyReserved_ = 0;  // bytes
  std::uint64_t lastChunk_ns_ = 0;
  std::unordered_map<ContentHash, Building> building_;
  std::deque<Held> held_;

  v1::AssetUploadReply refuse(const ContentHash& hash, const Error& error);
  v1::AssetUploadReply retryLater(const ContentHash& hash, const Error& why);
  void hold(std::shared_ptr<const Asset> asset, std::size_t reserved);
  [[nodiscard]] bool reserveFor(const v1::AssetChunk& chunk);
  void releaseAssembly();
};

}  // namespace haptics
