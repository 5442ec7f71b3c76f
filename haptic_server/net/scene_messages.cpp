#include "haptic_server/net/scene_messages.h"

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "common/text/printable.h"
#include "common/wire/convert.h"
#include "common/wire/framing.h"
#include "common/wire/snapshot.h"
#include "haptic_server/scene/scene_limits.h"

namespace haptics {
namespace {

static_assert(SceneLimits{}.answer_bytes + kAroundObjects_bytes <= kMaxFrameBytes, "each accepted edit fits a frame");
/// Longest reason: more is of no help.
constexpr std::size_t kMaxReason_bytes = 1000;

/// In UTF-8, cut between two characters.
std::string beginning(std::string_view said) {
  const std::string text = asUtf8(said);
  if (text.size() <= kMaxReason_bytes) return text;
  const auto continues = [&](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U; };
  std::size_t end = kMaxReason_bytes;
  while (end > 0 && continues(end)) --end;
  return text.substr(0, end) + "...";
}

void write(const EditConflict& conflict, std::size_t room_bytes, v1::Conflict& message) {
  std::string reason = beginning(conflict.reason);
  for (const auto& object : conflict.current) {
    const std::size_t bytes = wireSizeOf(*object) + kPerObject_bytes;
    if (bytes > room_bytes) {
      reason += " (of " + std::to_string(conflict.current.size()) + " objects, " +
                std::to_string(message.current_size()) + " are shown)";
      break;
    }
    toWire(*object, *message.add_current());
    room_bytes -= bytes;
  }
  message.set_reason(reason);
}

}  // namespace

void toWire(const EditOutcome& outcome, std::size_t frame_bytes, v1::EditReply& reply) {
  const std::size_t room_bytes = frame_bytes - std::min(frame_bytes, kAroundObjects_bytes);
  if (const auto* error = std::get_if<Error>(&outcome)) {
    reply.mutable_rejected()->set_field(beginning(error->field));
    reply.mutable_rejected()->set_reason(beginning(error->reason));
    return;
  }
  if (const auto* conflict = std::get_if<EditConflict>(&outcome)) {
    return write(*conflict, room_bytes, *reply.mutable_conflict());
  }
  const AcceptedEdit& edit = *std::get<std::shared_ptr<const AcceptedEdit>>(outcome);
  v1::Accepted& accepted = *reply.mutable_accepted();
  accepted.set_revision(edit.commit.revision);
  accepted.set_root(edit.commit.root.asBytes());
  if (answerSizeOf(edit.commit, edit.reports) > room_bytes) return;
  for (const ObjectRecord& record : edit.commit.put) toWire(record, *accepted.add_object());
  for (const std::string& report : edit.reports) accepted.add_report(report);
}

bool fitFrames(const SceneHistory& history, std::uint64_t revision, std::size_t frame_bytes) {
  const RecentEdits& edits = history.edits;
  for (std::size_t i = edits.size(); i-- > 0 && edits[i]->commit.revision > revision;) {
    if (answerSizeOf(edits[i]->commit, {}) + kAroundObjects_bytes > frame_bytes) return false;
  }
  return true;
}

}  // namespace haptics
