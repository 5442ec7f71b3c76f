// Text of a scene file, as hapticctl and the server read it.

#include <string>

#include "common/wire/convert.h"
#include "tests/fuzz/pieces.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto message = haptics::parseSceneText(text, "fuzz");
  if (!message) {
    haptics::fuzz::require(!message.error().text().empty(), "a refusal has a reason");
  } else {
    (void)haptics::fromWire(*message);
  }
  return 0;
}
