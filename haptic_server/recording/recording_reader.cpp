#include "haptic_server/recording/recording_reader.h"

#include <limits>
#include <utility>

#include "haptic_server/recording/state_image.h"

namespace haptics {

Result<RecordingReader> RecordingReader::open(std::string_view bytes) {
  if (!bytes.starts_with(kRecordingHead)) {
    return refused("", "does not begin with \"" + std::string(kRecordingHead.substr(0, kRecordingHead.size() - 1)) +
                           "\": it is no recording of this version (haptic_server --record makes one)");
  }
  RecordingReader reader(bytes);
  auto first = reader.next();
  if (!first) return tl::unexpected(std::move(first.error()));
  if (*first == nullptr || !(*first)->has_head())
    return refused("", "ends before it says what it is: the server was stopped while it began to record");
  auto facts = factsFrom((*first)->head());
  if (!facts) return tl::unexpected(std::move(facts.error()));
  reader.facts_ = *std::move(facts);
  reader.sameLayout_ = (*first)->head().state_layout() == stateLayout();
  return reader;
}

Result<const v1::RecordingPart*> RecordingReader::next() {
  const std::size_t at = records_.offset();
  const auto payload = records_.next();
  if (!payload) {
    if (records_.end() == LogEnd::kDamaged)
      return refused("byte " + std::to_string(at), "is damaged: what follows is not what was written");
    return nullptr;
  }
  const bool parsed = payload->size() <= std::numeric_limits<int>::max() &&
                      part_.ParseFromArray(payload->data(), static_cast<int>(payload->size()));
  if (!parsed || part_.part_case() == v1::RecordingPart::PART_NOT_SET)
    return refused("byte " + std::to_string(at), "holds no part that this version knows");
  return &part_;
}

}  // namespace haptics
