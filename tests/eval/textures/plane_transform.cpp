#include "tests/eval/textures/plane_transform.h"

#include <kissfft/kissfft.hh>

namespace haptics::eval {

Grid transformed(const Grid& grid, std::size_t width, std::size_t height, bool inverse) {
  Grid rows(grid.size());
  Grid result(grid.size());
  Grid column(height);
  Grid columnResult(height);
  const kissfft<double> alongRows(width, inverse);
  const kissfft<double> alongColumns(height, inverse);
  for (std::size_t y = 0; y < height; ++y) alongRows.transform(&grid[y * width], &rows[y * width]);
  for (std::size_t x = 0; x < width; ++x) {
    for (std::size_t y = 0; y < height; ++y) column[y] = rows[y * width + x];
    alongColumns.transform(column.data(), columnResult.data());
    for (std::size_t y = 0; y < height; ++y) result[y * width + x] = columnResult[y];
  }
  return result;
}

}  // namespace haptics::eval
