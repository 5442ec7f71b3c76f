#include "haptic_server/recording/scene_journal.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <system_error>
#include <utility>

namespace haptics {
namespace {

// Each part is preceded by its length.
using Length = std::uint64_t;

[[nodiscard]] tl::unexpected<Error> journalFailed() {
  return refused("scene journal", std::generic_category().message(errno));
}

void appendPart(const v1::RecordingPart& part, std::string& bytes) {
  const Length length = part.ByteSizeLong();
  bytes.append(reinterpret_cast<const char*>(&length), sizeof length);
  part.AppendToString(&bytes);
}

/// Takes the next part off the bytes; nothing: what is left is no whole one.
[[nodiscard]] std::optional<std::string_view> takePart(std::string_view& bytes) {
  Length length = 0;
  if (bytes.size() < sizeof length) return std::nullopt;
  std::memcpy(&length, bytes.data(), sizeof length);
  if (bytes.size() - sizeof length < length) return std::nullopt;
  const std::string_view part = bytes.substr(sizeof length, length);
  bytes.remove_prefix(sizeof length + length);
  return part;
}

}  // namespace

Result<SceneJournal> SceneJournal::make(const RecordingFacts& facts) {
  SceneJournal journal(FileHandle(::memfd_create("scene journal", MFD_CLOEXEC)));
  if (journal.descriptor() < 0) return journalFailed();
  v1::RecordingPart part;
  *part.mutable_head() = toMessage(facts);
  std::string bytes;
  appendPart(part, bytes);
  if (auto appended = journal.append(bytes); !appended) return tl::unexpected(std::move(appended.error()));
  return journal;
}

Result<void> SceneJournal::add(const SceneSource& scene) {
  std::string bytes;
  parts_.add(scene, [&](const v1::RecordingPart& part) { appendPart(part, bytes); });
  return append(bytes);
}

Result<void> SceneJournal::append(std::string_view bytes) {
  std::uint64_t end = size_;
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(descriptor(), bytes.data(), bytes.size(), static_cast<off_t>(end));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      auto error = journalFailed();
      (void)::ftruncate(descriptor(), static_cast<off_t>(size_));
      return error;
    }
    bytes.remove_prefix(static_cast<std::size_t>(written));
    end += static_cast<std::uint64_t>(written);
  }
  size_ = end;
  return {};
}

Result<SceneJournalReader> SceneJournalReader::open(int descriptor) {
  auto memory = SharedMemory::map(FileHandle(::dup(descriptor)), 1);
  if (!memory) return tl::unexpected(std::move(memory.error()));
  std::string_view bytes(reinterpret_cast<const char*>(memory->bytes().data()), memory->bytes().size());
  const auto first = takePart(bytes);
  v1::RecordingPart part;
  if (!first || !part.ParseFromArray(first->data(), static_cast<int>(first->size())) || !part.has_head()) {
    return refused("scene journal", "does not begin with a head");
  }
  auto facts = factsFrom(part.head());
  if (!facts) return tl::unexpected(std::move(facts.error()));
  return SceneJournalReader(*std::move(memory), bytes, *std::move(facts));
}

void SceneJournalReader::forEach(const std::function<void(std::string_view)>& visit) const {
  std::string_view bytes = scenes_;
  while (const auto part = takePart(bytes)) visit(*part);
}

}  // namespace haptics
