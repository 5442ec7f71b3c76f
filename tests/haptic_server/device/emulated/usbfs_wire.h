#pragma once

#include <array>
#include <cstdint>

// Between a program that has a usbfs descriptor and the process in which the device behind it is emulated: packets of a
// Unix socket, each request answered by one reply.
namespace haptics::test {

inline constexpr std::size_t kMaxNodeData = 512;

/// As an ioctl(2) of usbfs, with the data that it points to.
struct NodeRequest {
  std::uint64_t node = 0;  ///< Inode of the pipe that the descriptor is of; 0: to open the node.
  std::uint64_t request = 0;
  std::uint64_t urb = 0;  ///< Where it is, in the memory of who submitted it.
  std::uint8_t type = 0, endpoint = 0;
  std::array<std::uint8_t, 8> setup{};
  std::uint32_t length = 0;  ///< Of data, or of the buffer for it.
  std::array<std::uint8_t, kMaxNodeData> data{};
};

struct NodeReply {
  std::int32_t result = 0;  ///< Or a negative errno.
  std::uint64_t urb = 0;
  std::int32_t status = 0;
  bool isLast = false;       ///< No other transfer is done yet.
  std::uint32_t length = 0;  ///< Of data.
  std::array<std::uint8_t, kMaxNodeData> data{};
};

}  // namespace haptics::test
