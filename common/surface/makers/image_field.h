#pragma once

#include <string_view>

#include "common/error/error.h"
#include "common/surface/sampled_field.h"

namespace haptics {

/// The brightness of an image, 0 to 1, as a field: its first row becomes the highest. Of a PNG file with 16 bits per
/// channel the values are taken as they are, of others as they are coded for a display, which is what height maps mean;
/// colours are weighed as brightness, transparent parts count as black. The image repeats: what differs between opposite
/// borders becomes a steep edge there, about a sample wide.
/// \param bytes of a file from anywhere. Refused: neither PNG nor JPEG, a damaged one, sides that SampledField refuses
///        (told from the header, before anything is allocated).
[[nodiscard]] Result<SampledField> fieldFromImage(std::string_view bytes);

}  // namespace haptics
