#include "graphics_client/application/measure.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numbers>

namespace haptics {
namespace {

[[gnu::format(printf, 1, 2)]] std::string words(const char* format, ...) {
  char text[128];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

double millimetres(Vec3 from, Vec3 to) { return 1e3 * glm::distance(from, to); }

}  // namespace

std::string measureText(std::span<const Vec3> places, const std::optional<Vec3>& pointer) {
  std::string text;
  if (places.size() < 2) text = places.empty() ? "measure: click a place" : "measure: click the second place";
  if (places.size() >= 2) text = words("distance %.2f mm", millimetres(places[0], places[1]));
  if (places.size() >= 3) {
    const Vec3 a = places[0] - places[1], b = places[2] - places[1];
    const double angle = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
    text +=
        words(", then %.2f mm, angle %.1f\u00b0", millimetres(places[1], places[2]), angle * 180 / std::numbers::pi);
  }
  if (pointer) text += words("; at %.1f  %.1f  %.1f mm", 1e3 * pointer->x, 1e3 * pointer->y, 1e3 * pointer->z);
  return text;
}

}  // namespace haptics
