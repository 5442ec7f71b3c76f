#include "haptic_server/watchdog/watch_order.h"

#include <sys/socket.h>

#include <cerrno>
#include <cstring>

namespace haptics {

bool sendOrder(int socket, const WatchOrder& order, int descriptor) noexcept {
  iovec bytes{const_cast<WatchOrder*>(&order), sizeof order};
  alignas(cmsghdr) char room[CMSG_SPACE(sizeof descriptor)]{};
  msghdr message{};
  message.msg_iov = &bytes;
  message.msg_iovlen = 1;
  if (descriptor >= 0) {
    message.msg_control = room;
    message.msg_controllen = sizeof room;
    cmsghdr* head = CMSG_FIRSTHDR(&message);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(sizeof descriptor);
    std::memcpy(CMSG_DATA(head), &descriptor, sizeof descriptor);
  }
  ssize_t sent = -1;
  do {
    sent = ::sendmsg(socket, &message, MSG_DONTWAIT | MSG_NOSIGNAL);
  } while (sent < 0 && errno == EINTR);
  return sent == sizeof order;
}

std::optional<ReceivedOrder> receiveOrder(int socket, bool& ended) noexcept {
  ReceivedOrder received;
  iovec bytes{&received.order, sizeof received.order};
  int descriptor = -1;
  alignas(cmsghdr) char room[CMSG_SPACE(sizeof descriptor)]{};
  msghdr message{};
  message.msg_iov = &bytes;
  message.msg_iovlen = 1;
  message.msg_control = room;
  message.msg_controllen = sizeof room;
  const ssize_t count = ::recvmsg(socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return std::nullopt;
  if (const cmsghdr* head = count > 0 ? CMSG_FIRSTHDR(&message) : nullptr; head != nullptr) {
    std::memcpy(&descriptor, CMSG_DATA(head), sizeof descriptor);
  }
  received.descriptor = FileHandle(descriptor);
  if (count == sizeof received.order) return received;
  ended = true;
  return std::nullopt;
}

}  // namespace haptics
