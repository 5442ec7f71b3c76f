#pragma once

#include <memory>
#include <string>

#include "graphics_client/editing/edit_history.h"

namespace haptics {

/// One drag of a slider: it may give values faster than the server answers. One transaction is in flight at most; while
/// it is, a newer value replaces the one that waits. The last value is always sent, also when this is gone before. The
/// whole drag is one entry of the history.
class LatestEdit {
 public:
  /// The history outlives the callbacks.
  /// \param text  Of the entry.
  /// \param done  Called for each value that was sent.
  LatestEdit(EditHistory& history, std::string text, EditDone done = {});

  /// @param value  Its text and group are those of the drag.
  void set(Edit value);

 private:
  struct Drag;
  std::shared_ptr<Drag> drag_;

  static void send(const std::shared_ptr<Drag>& drag);
};

}  // namespace haptics
