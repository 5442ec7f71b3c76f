#pragma once

#include <functional>

#include "common/error/error.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// What became of an edit. A conflict is an error of the field "preconditions", and says at which revisions the objects
/// stand.
[[nodiscard]] Result<v1::Accepted> outcomeOf(const v1::EditReply& reply);

/// Called once with the outcome of an edit: accepted, with the server's warnings in `report`, or the field that was
/// refused and why.
using EditDone = std::function<void(const Result<v1::Accepted>&)>;

}  // namespace haptics
