#include "common/importer/mesh_picture.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "common/maths/vec.h"

namespace haptics {
namespace {

constexpr int kSide = 640, kViews = 2;  // pixels
constexpr int kFiner = 2;               // samples along each side of a pixel
constexpr double kFilled = 0.92;        // of a view
constexpr double kEdgesCloser = 0.01;   // of the radius: edges are seen before the faces that they bound

using Colour = std::array<double, 3>;
constexpr Colour kPaper{1, 1, 1}, kFront{0.72, 0.74, 0.78}, kBack{1, 0.5, 0.1}, kEdge{0.1, 0.2, 0.9};

/// One view: samples with their depth.
class View {
 public:
  View(Vec3 towardsEye, Vec3 centre, double radius)
      : towardsEye_(glm::normalize(towardsEye)),
        right_(glm::normalize(glm::cross(Vec3(0, 0, 1), towardsEye_))),
        up_(glm::cross(towardsEye_, right_)),
        centre_(centre),
        scale_(kFilled * kSamples / (2 * radius)),
        radius_(radius),
        depth_(kSamples * kSamples, -std::numeric_limits<double>::infinity()),
        colour_(kSamples * kSamples, kPaper) {}

  void draw(const std::array<Vec3, 3>& corners) {
    const Vec3 normal = glm::normalize(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
    const double facing = glm::dot(normal, towardsEye_);
    const double light =
        0.35 + 0.65 * std::abs(glm::dot(normal, glm::normalize(towardsEye_ + 0.5 * up_ - 0.4 * right_)));
    Colour colour = facing >= 0 ? kFront : kBack;
    for (double& part : colour) part *= light;
    std::array<Vec3, 3> at;
    for (std::size_t k = 0; k < 3; ++k) at[k] = seen(corners[k]);
    const double area = turn(at[0], at[1], at[2]);
    if (area == 0) return;
    const auto [left, right] = std::minmax({at[0].x, at[1].x, at[2].x});
    const auto [top, bottom] = std::minmax({at[0].y, at[1].y, at[2].y});
    for (int y = first(top); y <= last(bottom); ++y) {
      for (int x = first(left); x <= last(right); ++x) {
        const Vec3 p(x + 0.5, y + 0.5, 0);
        const double a = turn(at[1], at[2], p) / area, b = turn(at[2], at[0], p) / area, c = 1 - a - b;
        if (a >= 0 && b >= 0 && c >= 0) put(x, y, a * at[0].z + b * at[1].z + c * at[2].z, colour);
      }
    }
  }

  void drawEdge(Vec3 from, Vec3 to) {
    const Vec3 a = seen(from), b = seen(to);
    const int steps = 1 + static_cast<int>(std::max(std::abs(b.x - a.x), std::abs(b.y - a.y)));
    for (int i = 0; i <= steps; ++i) {
      const Vec3 at = a + (b - a) * (static_cast<double>(i) / steps);
      for (int dy = 0; dy < kFiner; ++dy) {
        for (int dx = 0; dx < kFiner; ++dx) {
          put(static_cast<int>(at.x) + dx, static_cast<int>(at.y) + dy, at.z + kEdgesCloser * radius_, kEdge);
        }
      }
    }
  }

  /// Of a pixel, 0 to 255.
  [[nodiscard]] std::array<std::uint8_t, 3> pixel(int x, int y) const {
    Colour sum{};
    for (int dy = 0; dy < kFiner; ++dy) {
      for (int dx = 0; dx < kFiner; ++dx) {
        for (std::size_t k = 0; k < 3; ++k) sum[k] += colour_[place(x * kFiner + dx, y * kFiner + dy)][k];
      }
    }
    std::array<std::uint8_t, 3> bytes{};
    for (std::size_t k = 0; k < 3; ++k)
      bytes[k] = static_cast<std::uint8_t>(std::lround(255 * sum[k] / (kFiner * kFiner)));
    return bytes;
  }

 private:
  static constexpr int kSamples = kSide * kFiner;

  Vec3 towardsEye_, right_, up_, centre_;
  double scale_, radius_;
  std::vector<double> depth_;
  std::vector<Colour> colour_;

  /// In samples to the right and downwards; z: towards the eye, in metres.
  [[nodiscard]] Vec3 seen(Vec3 point) const {
    const Vec3 from = point - centre_;
    return {kSamples / 2.0 + scale_ * glm::dot(from, right_), kSamples / 2.0 - scale_ * glm::dot(from, up_),
            glm::dot(from, towardsEye_)};
  }
  static double turn(const Vec3& a, const Vec3& b, const Vec3& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  }
  static int first(double low) { return std::max(0, static_cast<int>(low)); }
  static int last(double high) { return std::min(kSamples - 1, static_cast<int>(high)); }
  static std::size_t place(int x, int y) {
    return static_cast<std::size_t>(y) * kSamples + static_cast<std::size_t>(x);
  }

  void put(int x, int y, double depth, const Colour& colour) {
    if (x < 0 || y < 0 || x >= kSamples || y >= kSamples || depth <= depth_[place(x, y)]) return;
    depth_[place(x, y)] = depth;
    colour_[place(x, y)] = colour;
  }
};

using Edge = std::pair<std::uint32_t, std::uint32_t>;

std::vector<Edge> edgesOfOneFace(const TriMesh& mesh) {
  std::vector<Edge> all, alone;
  all.reserve(3 * mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    for (const auto& [from, to] : {Edge{a, b}, {b, c}, {c, a}}) all.push_back(std::minmax(from, to));
  }
  std::sort(all.begin(), all.end());
  for (std::size_t i = 0; i < all.size();) {
    const auto same = std::upper_bound(all.begin() + static_cast<std::ptrdiff_t>(i), all.end(), all[i]) - all.begin();
    if (static_cast<std::size_t>(same) == i + 1) alone.push_back(all[i]);
    i = static_cast<std::size_t>(same);
  }
  return alone;
}

}  // namespace

Result<void> writePicture(const TriMesh& mesh, const std::filesystem::path& file) {
  Vec3 low(std::numeric_limits<double>::infinity()), high(-low);
  for (const Vec3f& vertex : mesh.vertices) {
    low = glm::min(low, Vec3(vertex));
    high = glm::max(high, Vec3(vertex));
  }
  const Vec3 centre = low / 2.0 + high / 2.0;
  const double radius = glm::length(high - low) / 2;
  std::array<View, kViews> views{View({0.7, -1, 0.6}, centre, radius), View({-0.7, 1, -0.6}, centre, radius)};
  const std::vector<Edge> alone = edgesOfOneFace(mesh);
  for (View& view : views) {
    for (const auto& [a, b, c] : mesh.triangles) {
      view.draw({Vec3(mesh.vertices[a]), Vec3(mesh.vertices[b]), Vec3(mesh.vertices[c])});
    }
    for (const auto& [from, to] : alone) view.drawEdge(Vec3(mesh.vertices[from]), Vec3(mesh.vertices[to]));
  }

  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < kSide; ++y) {
    for (const View& view : views) {
      for (int x = 0; x < kSide; ++x) {
        for (const std::uint8_t part : view.pixel(x, y)) pixels.push_back(part);
      }
    }
  }
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.format = PNG_FORMAT_RGB;
  image.width = kViews * kSide;
  image.height = kSide;
  if (png_image_write_to_file(&image, file.c_str(), 0, pixels.data(), 0, nullptr) != 0) return {};
  return refused(file.string(), std::string("cannot be written: ") + image.message);
}

}  // namespace haptics
