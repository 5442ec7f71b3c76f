// The bytes of a scalar or point field, as a client uploads them: refused, or a field that is its bytes and stays in its
// bounds, or between its samples and 0.

#include <algorithm>
#include <string_view>

#include "common/surface/field_asset.h"
#include "common/surface/point_field_asset.h"
#include "tests/fuzz/pieces.h"

namespace {

void lookAtPoints(std::string_view bytes) {
  using haptics::fuzz::require;
  const auto field = haptics::decodePointField(bytes);
  if (!field) return;
  require(haptics::encodePointField(*field) == bytes, "bytes that are taken are canonical");
  const auto [least, most] = std::ranges::minmax(field->samples(), {}, &haptics::PointSample::value);
  for (const auto& sample : field->samples().first(std::min<std::size_t>(16, field->samples().size()))) {
    const auto near = field->at(haptics::Vec3(sample.point) + 0.3 * field->reach_m());
    require(near.value >= std::min(least.value, 0.0F) - 1e-9, "no value is below the samples and 0");
    require(near.value <= std::max(most.value, 0.0F) + 1e-9, "no value is above the samples and 0");
    require(haptics::isFinite(near.gradient), "gradients are numbers");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using haptics::fuzz::require;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  lookAtPoints(bytes);
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
