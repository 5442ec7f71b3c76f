#pragma once

#include <sys/types.h>

#include <cstddef>

#include "common/process/file_handle.h"

namespace haptics {

/// sendmsg() and recvmsg() of some bytes and, where there is one (not -1), of a descriptor; `flags` as theirs. Neither
/// raises SIGPIPE. Both may be called in a signal handler.
[[nodiscard]] ssize_t sendWith(int socket, const void* bytes, std::size_t size, int descriptor, int flags = 0) noexcept;
[[nodiscard]] ssize_t receiveWith(int socket, void* bytes, std::size_t size, FileHandle& descriptor,
                                  int flags = 0) noexcept;

}  // namespace haptics
