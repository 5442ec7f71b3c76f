#include "haptic_server/watchdog/watch_order.h"

#include <sys/socket.h>

#include <cerrno>

#include "common/process/passed_descriptor.h"

namespace haptics {

bool sendOrder(int socket, const WatchOrder& order, int descriptor) noexcept {
  ssize_t sent = -1;
  do {
    sent = sendWith(socket, &order, sizeof order, descriptor, MSG_DONTWAIT);
  } while (sent < 0 && errno == EINTR);
  return sent == sizeof order;
}

std::optional<ReceivedOrder> receiveOrder(int socket, bool& ended) noexcept {
  ReceivedOrder received;
  const ssize_t count = receiveWith(socket, &received.order, sizeof received.order, received.descriptor, MSG_DONTWAIT);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return std::nullopt;
  if (count == sizeof received.order) return received;
  ended = true;
  return std::nullopt;
}

}  // namespace haptics
