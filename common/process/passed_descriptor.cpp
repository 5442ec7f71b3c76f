#include "common/process/passed_descriptor.h"

#include <sys/socket.h>

#include <cstring>

namespace haptics {
namespace {

union Control {
  char bytes[CMSG_SPACE(sizeof(int))];
  cmsghdr align;
};

}  // namespace

ssize_t sendWith(int socket, const void* bytes, std::size_t size, int descriptor, int flags) noexcept {
  iovec part{const_cast<void*>(bytes), size};
  Control control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  if (descriptor >= 0) {
    message.msg_control = control.bytes;
    message.msg_controllen = sizeof control.bytes;
    cmsghdr* header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof descriptor);
    std::memcpy(CMSG_DATA(header), &descriptor, sizeof descriptor);
  }
  return sendmsg(socket, &message, flags | MSG_NOSIGNAL);
}

ssize_t receiveWith(int socket, void* bytes, std::size_t size, FileHandle& descriptor, int flags) noexcept {
  iovec part{bytes, size};
  Control control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.bytes;
  message.msg_controllen = sizeof control.bytes;
  const ssize_t received = recvmsg(socket, &message, flags | MSG_CMSG_CLOEXEC);
  int passed = -1;
  const cmsghdr* header = received > 0 ? CMSG_FIRSTHDR(&message) : nullptr;
  if (header != nullptr && header->cmsg_type == SCM_RIGHTS && header->cmsg_len == CMSG_LEN(sizeof passed)) {
    std::memcpy(&passed, CMSG_DATA(header), sizeof passed);
  }
  descriptor = FileHandle(passed);
  return received;
}

}  // namespace haptics
