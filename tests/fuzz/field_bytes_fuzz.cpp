// The bytes of a scalar field, as a client uploads them: refused, or a field that is its bytes and stays in its bounds.

#include <string_view>

#include "common/surface/field_asset.h"
#include "tests/fuzz/pieces.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using haptics::fuzz::require;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto field = haptics::decodeField(bytes);
  if (!field) return 0;
  require(haptics::encodeField(*field) == bytes, "bytes that are taken are canonical");
  for (double x = 0; x < 4; x += 0.37) {
    const auto sample = field->at(x, 0.7 * x);
    require(sample.value >= field->bounds().lowest, "no value is below the lowest");
    require(sample.value <= field->bounds().highest, "no value is above the highest");
  }
  return 0;
}
