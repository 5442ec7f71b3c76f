// Bytes into the frame decoder: however they are cut, they give the same messages and the same error.

#include <string>
#include <vector>

#include "common/wire/framing.h"
#include "tests/fuzz/pieces.h"

namespace haptics {
namespace {

std::vector<std::string> decoded(std::span<const char> bytes, std::size_t step) {
  std::vector<std::string> said;
  FrameDecoder decoder;
  while (!bytes.empty()) {
    const std::size_t size = std::min(step, bytes.size());
    decoder.feed(bytes.first(size));
    bytes = bytes.subspan(size);
    for (;;) {
      const auto next = decoder.next();
      if (!next) {
        said.push_back("error " + next.error().text());
        return said;
      }
      if (!*next) break;
      std::string frame;
      if (!appendFrame(frame, **next)) std::abort();
      said.push_back(std::move(frame));
    }
  }
  return said;
}

}  // namespace
}  // namespace haptics

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const char> bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  haptics::fuzz::require(haptics::decoded(bytes, size) == haptics::decoded(bytes, 1 + data[0]),
                         "the cuts between reads do not matter");
  return 0;
}
