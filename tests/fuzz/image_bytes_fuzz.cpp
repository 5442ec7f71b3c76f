// The bytes of an image file: refused, or a field of brightness.

#include <string_view>

#include "common/surface/makers/image_field.h"
#include "tests/fuzz/pieces.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using haptics::fuzz::require;
  const auto field = haptics::fieldFromImage({reinterpret_cast<const char*>(data), size});
  if (!field) return 0;
  for (const float sample : field->samples()) require(sample >= 0 && sample <= 1, "brightness is 0 to 1");
  return 0;
}
