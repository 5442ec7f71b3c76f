#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "common/assets/asset_content.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// What comes of an edit. Each may be empty. After `replied` with an acceptance, either `live` follows when the servo
/// feels it, or `stateLost` when the server has restarted without its state and the edit is gone with it.
struct EditCallbacks {
  std::function<void(const v1::EditReply&)> replied;  ///< Once, however often the edit had to be resent.
  std::function<void(const v1::EditLive&)> live;
  std::function<void()> stateLost = nullptr;
  /// Any number of times before `replied`, of an edit that takes the server long; the share is within 0 and 1.
  std::function<void(const v1::EditProgress&)> progress = nullptr;
};

struct UploadCallbacks {
  std::function<void(std::uint64_t sent_bytes, std::uint64_t total_bytes)> progress;  ///< Starts anew on reconnect.
  std::function<void(const v1::AssetUploadReply&)> finished;                          ///< Once.
};

/// An asset as the server in this process holds it, to be held with it; nothing where it holds none of this name.
using SharedAssets = std::function<std::optional<AssetContent>(const AssetName&)>;

/// Ticks in a row, in order; after a reconnect from then on.
using TicksCallback = std::function<void(const v1::TelemetryBatch&)>;

using StatusCallback = std::function<void(const v1::Status&)>;
using DumpCallback = std::function<void(const v1::DumpReply&)>;

}  // namespace haptics
