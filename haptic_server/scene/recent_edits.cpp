#include "haptic_server/scene/recent_edits.h"

#include <utility>

namespace haptics {

const RecentEdits::Edit& RecentEdits::operator[](std::size_t i) const {
  i += left_;
  const std::size_t page = i / kPage;
  return page < pages_.size() ? (*pages_[page])[i % kPage] : newest_[i - pages_.size() * kPage];
}

void RecentEdits::push_back(Edit edit) {
  newest_.push_back(std::move(edit));
  if (newest_.size() == kPage) pages_.push_back(std::make_shared<const Page>(std::exchange(newest_, {})));
}

void RecentEdits::pop_front() {
  if (pages_.empty()) {
    newest_.erase(newest_.begin());
  } else if (++left_ == kPage) {
    pages_.erase(pages_.begin());
    left_ = 0;
  }
}

}  // namespace haptics
