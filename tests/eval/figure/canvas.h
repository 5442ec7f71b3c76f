#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tests/eval/figure/figure.h"

class vtkContext2D;

namespace haptics::eval {

enum class Align { kLeft, kCentre, kRight };

/// A picture's pixels, the lowest row first.
struct Raster {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

/// Strokes of a pen on a VTK context, one unit to the pixel, the origin below on the left.
class Canvas {
 public:
  struct Point {
    double x, y;
  };

  explicit Canvas(vtkContext2D& context) : context_(context) {}

  /// @param y  Of the letters' foot.
  void text(double x, double y, const std::string& words, int size, Colour colour, Align align = Align::kLeft,
            bool bold = false);
  [[nodiscard]] double textWidth(const std::string& words, int size, bool bold);
  void upright(double x, double y, const std::string& words, int size, Colour colour);
  void line(Point from, Point to, Colour colour, double width, bool dashed = false);
  void polyline(std::span<const Point> points, Colour colour, double width);
  void box(Point below, double width, double height, Colour fill);
  void disc(Point centre, double radius, Colour fill);
  void diamond(Point centre, double radius, Colour fill);
  void raster(const Raster& picture, Point below, double width, double height);

 private:
  void pen(Colour colour, double width);
  void fill(Colour colour);

  vtkContext2D& context_;
};

}  // namespace haptics::eval
