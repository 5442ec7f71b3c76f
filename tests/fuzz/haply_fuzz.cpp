// Bytes as a message of Haply's service: read or refused with a reason, and what it calls the device can be sent back.

#include <string>
#include <string_view>

#include "haptic_server/device/plugin/vendors/haply_message.h"
#include "tests/fuzz/pieces.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptics;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  std::string reason;
  const auto said = parseHaply(text, "", reason);
  fuzz::require(said.has_value() == reason.empty(), "it is read, or refused with a reason");
  if (said) (void)haplyCommand(said->id, said->appliedForce_N, HaplySpelling::kVector, true);
  return 0;
}
