#pragma once

#include <functional>

#include "common/wire/endpoint.h"
#include "graphics_client/mirror/server_link.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics::stress {

/// TCP for a ServerLink; shows each message from the server before the link takes it, on the link's thread.
[[nodiscard]] ServerLink::Connect tappedTcp(Endpoint server, std::function<void(const v1::Envelope&)> received);

/// Knows whether commits come one after another.
class CommitOrder {
 public:
  /// False: the message is a commit that does not follow the one before it.
  [[nodiscard]] bool follows(const v1::Envelope& envelope);

 private:
  std::uint64_t last_ = 0;  // 0: any may come
};

}  // namespace haptics::stress
