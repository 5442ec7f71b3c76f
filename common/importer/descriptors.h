#pragma once

#include <sys/types.h>

#include <cstddef>

namespace haptics {

/// sendmsg() and recvmsg() of some bytes and, where there is one (not -1), of a descriptor. Neither raises SIGPIPE.
[[nodiscard]] ssize_t sendWith(int socket, const void* bytes, std::size_t size, int descriptor);
[[nodiscard]] ssize_t receiveWith(int socket, void* bytes, std::size_t size, int& descriptor);

}  // namespace haptics
