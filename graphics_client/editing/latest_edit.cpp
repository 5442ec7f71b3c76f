#include "graphics_client/editing/latest_edit.h"

#include <optional>
#include <utility>

namespace haptics {

struct LatestEdit::Drag {
  EditHistory& history;
  std::string text;
  EditDone done;
  std::uint64_t group;
  std::optional<Edit> waiting = std::nullopt;
  bool inFlight = false;
};

LatestEdit::LatestEdit(EditHistory& history, std::string text, EditDone done)
    : drag_(std::make_shared<Drag>(Drag{history, std::move(text), std::move(done), history.newGroup()})) {}

void LatestEdit::set(Edit value) {
  value.text = drag_->text;
  value.group = drag_->group;
  drag_->waiting = std::move(value);
  send(drag_);
}

void LatestEdit::send(const std::shared_ptr<Drag>& drag) {
  if (drag->inFlight || !drag->waiting) return;
  drag->inFlight = true;
  Edit edit = *std::move(drag->waiting);
  drag->waiting.reset();
  drag->history.submit(std::move(edit), [drag](const Result<v1::Accepted>& outcome) {
    drag->inFlight = false;
    if (drag->done) drag->done(outcome);
    send(drag);
  });
}

}  // namespace haptics
