#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/scene/scene.h"

namespace haptics {

using SessionId = std::uint64_t;                ///< Chosen at random by a client and kept over its reconnects.
inline constexpr SessionId kServerSession = 0;  ///< The server's own edits: the start scene.

/// An edit that became a revision, and who asked for it: what a resent edit is recognised by is in the same record as
/// what it did.
struct AcceptedEdit {
  SessionId session = kServerSession;
  std::uint64_t clientSeq = 0;
  Commit commit;  ///< `put` holds each object once, in the order in which the operations first name them.
  std::vector<std::string> reports;  ///< Of imports and generators, and warnings.
  ObjectId nextId = 1;               ///< First id that no object has had after it.
};

/// Edits, oldest first. A copy shares all pages but the newest with its original, so that to copy a thousand edits, as
/// each revision does, costs less than the edit itself.
class RecentEdits {
 public:
  using Edit = std::shared_ptr<const AcceptedEdit>;

  [[nodiscard]] std::size_t size() const { return pages_.size() * kPage + newest_.size() - left_; }
  [[nodiscard]] bool empty() const { return size() == 0; }
  [[nodiscard]] const Edit& operator[](std::size_t i) const;
  [[nodiscard]] const Edit& front() const { return (*this)[0]; }
  [[nodiscard]] const Edit& back() const { return (*this)[size() - 1]; }

  void push_back(Edit edit);
  void pop_front();  ///< Frees them page by page.

 private:
  static constexpr std::size_t kPage = 32;
  using Page = std::vector<Edit>;

  std::vector<std::shared_ptr<const Page>> pages_;  ///< Full ones.
  Page newest_;
  std::size_t left_ = 0;  ///< Of the first page: popped.
};

}  // namespace haptics
