#pragma once

#include <nats/nats.h>

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace haptics::eval {

template <auto destroy>
struct NatsDeleter {
  template <class Handle>
  void operator()(Handle* handle) const noexcept {
    destroy(handle);
  }
};

template <class Handle, auto destroy>
using NatsHandle = std::unique_ptr<Handle, NatsDeleter<destroy>>;

using NatsOptions = NatsHandle<natsOptions, natsOptions_Destroy>;
using NatsConnection = NatsHandle<natsConnection, natsConnection_Destroy>;
using NatsSubscription = NatsHandle<natsSubscription, natsSubscription_Destroy>;
using NatsMessage = NatsHandle<natsMsg, natsMsg_Destroy>;
using JetStream = NatsHandle<jsCtx, jsCtx_Destroy>;

/// Throws std::runtime_error with what was wanted and what NATS says.
inline void orThrow(natsStatus status, std::string_view what) {
  if (status == NATS_OK) return;
  const char* detail = nats_GetLastError(nullptr);
  throw std::runtime_error("NATS: " + std::string(what) + ": " + natsStatus_GetText(status) +
                           (detail != nullptr && *detail != '\0' ? std::string(", ") + detail : ""));
}

[[nodiscard]] inline std::string_view dataOf(const natsMsg& message) noexcept {
  return {natsMsg_GetData(&message), static_cast<std::size_t>(natsMsg_GetDataLength(&message))};
}

}  // namespace haptics::eval
