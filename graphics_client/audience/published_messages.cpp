#include "graphics_client/audience/published_messages.h"

#include <algorithm>
#include <string>

#include "common/wire/convert.h"
#include "common/wire/framing.h"
#include "graphics_client/audience/session_subjects.h"
#include "graphics_client/mirror/client_limits.h"

namespace haptics {
namespace {

template <class Message>
Result<Message> parsed(std::string_view bytes, const char* name) {
  if (bytes.size() > kMaxFrameBytes)
    return refused(name, "has " + std::to_string(bytes.size()) + " bytes, more than a frame");
  Message message;
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return refused(name, "is not such a message");
  }
  return message;
}

template <class Message>
Result<Message> parsedOfVersion(std::string_view bytes, const char* name) {
  auto message = parsed<Message>(bytes, name);
  if (message && message->protocol_version() != kProtocolVersion) {
    return refused(std::string(name) + ".protocol_version", "is " + std::to_string(message->protocol_version()) +
                                                                "; this program reads version " +
                                                                std::to_string(kProtocolVersion));
  }
  return message;
}

template <class Message>
Result<Message> parsedOfEpoch(std::string_view bytes, const char* name) {
  auto message = parsedOfVersion<Message>(bytes, name);
  if (message && message->epoch() == 0) return refused(std::string(name) + ".epoch", "is 0, which no server's is");
  return message;
}

template <class Message>
Result<Message> withBody(Result<Message> message, const char* name) {
  if (message && message->body_case() == Message::BODY_NOT_SET) return refused(name, "holds nothing that is known");
  return message;
}

}  // namespace

Result<v1::SnapshotPart> readSnapshotPart(std::string_view bytes) {
  return withBody(parsedOfEpoch<v1::SnapshotPart>(bytes, "snapshot_part"), "snapshot_part");
}

Result<v1::LatestSnapshot> readLatestSnapshot(std::string_view bytes) {
  auto latest = parsedOfVersion<v1::LatestSnapshot>(bytes, "latest_snapshot");
  if (!latest) return latest;
  const v1::Welcome& welcome = latest->welcome();
  if (latest->sequence() == 0) return refused("latest_snapshot.sequence", "is 0; those of a stream start at 1");
  if (welcome.epoch() == 0) return refused("latest_snapshot.welcome.epoch", "is 0, which no server's is");
  if (auto root = hashFromWire(welcome.root(), "latest_snapshot.welcome.root"); !root) {
    return tl::unexpected(std::move(root).error());
  }
  for (const std::string* text : {&welcome.server_name(), &welcome.device(), &welcome.second_device()}) {
    if (text->size() > kMaxServerText_bytes) {
      return refused("latest_snapshot.welcome",
                     "has a text of more than " + std::to_string(kMaxServerText_bytes) + " bytes");
    }
  }
  return latest;
}

Result<v1::PublishedCommit> readPublishedCommit(std::string_view bytes) {
  auto published = parsedOfEpoch<v1::PublishedCommit>(bytes, "published_commit");
  if (published && !published->has_commit()) return refused("published_commit.commit", "is not there");
  return published;
}

Result<v1::LiveMessage> readLiveMessage(std::string_view bytes) {
  return withBody(parsedOfEpoch<v1::LiveMessage>(bytes, "live_message"), "live_message");
}

Result<v1::AssetChunk> readAssetChunk(std::string_view bytes, const ContentHash& asset, std::uint64_t index) {
  auto chunk = parsed<v1::AssetChunk>(bytes, "asset_chunk");
  if (!chunk) return chunk;
  if (chunk->hash() != asset.asBytes()) return refused("asset_chunk.hash", "is another asset's than its subject says");
  const std::uint64_t begin = index * kPublishedChunk_bytes;
  if (chunk->offset() != begin || chunk->total_size() <= begin) {
    return refused("asset_chunk.offset", "is not where chunk " + std::to_string(index) + " of the asset begins");
  }
  if (chunk->data().size() != std::min<std::uint64_t>(kPublishedChunk_bytes, chunk->total_size() - begin)) {
    return refused("asset_chunk.data", "has another length than chunk " + std::to_string(index) + " of the asset");
  }
  return chunk;
}

}  // namespace haptics
