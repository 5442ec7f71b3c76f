#pragma once

#include <complex>
#include <cstddef>
#include <vector>

namespace haptics::eval {

using Grid = std::vector<std::complex<double>>;  ///< Row by row.

/// Discrete Fourier transform of rows and columns; the inverse is not divided by their number.
[[nodiscard]] Grid transformed(const Grid& grid, std::size_t width, std::size_t height, bool inverse);

}  // namespace haptics::eval
