#include "tests/eval/textures/reference_field.h"

#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/surface/lattice.h"
#include "tests/eval/textures/plane_transform.h"

namespace haptics::eval {
namespace {

using std::numbers::pi;

double quintic(double t) { return ((6 * t - 15) * t + 10) * t * t * t; }
/// 1 at distance 0 of a corner, 0 at distance 1.
double falling(double distance) { return 1 - quintic(std::abs(distance)); }

Reference reference(const FourierFamily& family) {
  return [family](Vec3 point) {
    double sum = 0;
    for (const FourierTerm& term : family.terms) {
      const double turns = glm::dot(term.direction, point) / term.wavelength_m;
      sum += term.amplitude * std::real(std::polar(1.0, 2 * pi * turns) * std::polar(1.0, term.phase_rad));
    }
    return sum;
  };
}

/// Calls visit(corner, away) for the corners of a cell; `away` leads from the corner to the place.
template <class Visit>
void visitCorners(const CellLattice::Place& place, Visit visit) {
  for (unsigned corner = 0; corner < 8; ++corner) {
    const std::array<std::uint64_t, 3> steps{corner & 1, corner >> 1 & 1, corner >> 2};
    visit(CellLattice::bits(place.key, steps[0], steps[1], steps[2]),
          place.within - Vec3(steps[0], steps[1], steps[2]));
  }
}

/// Perlin (2002): corner c adds w(x - cx) w(y - cy) w(z - cz) (g . (p - c)), g to the middle of an edge of a cube.
double perlin(const CellLattice::Place& place) {
  double sum = 0;
  visitCorners(place, [&](std::uint64_t bits, Vec3 away) {
    const std::uint64_t edge = (bits >> 32) * 12 >> 32;
    const double first = edge % 2 == 0 ? 1 : -1;
    const double second = edge % 4 < 2 ? 1 : -1;
    const std::array along{first * away.x + second * away.y, first * away.x + second * away.z,
                           first * away.y + second * away.z};
    sum += falling(away.x) * falling(away.y) * falling(away.z) * along[edge / 4];
  });
  return sum;
}

Reference reference(const NoiseFamily& family) {
  // The highest value that any gradients can give, and where in a cell: the octaves' lattices meet there.
  constexpr double kHighest = 1.0363538112118;
  const Vec3 highestAt(0.5, 0.481492214, 0.355256701);
  std::vector<CellLattice> lattices;
  std::vector<double> amplitudes;
  haptics::Random seeds(family.seed);
  double sum = 0;
  for (unsigned i = 0; i < family.octaves; ++i) {
    const double finer = std::pow(2.0, i);
    lattices.emplace_back(family.wavelength_m / finer, seeds.bits(), highestAt * (1 - finer));
    amplitudes.push_back(std::pow(family.persistence, i));
    sum += amplitudes.back();
  }
  return [=](Vec3 point) {
    double value = 0;
    for (std::size_t i = 0; i < lattices.size(); ++i) value += amplitudes[i] * perlin(lattices[i].place(point));
    return value / (kHighest * sum);
  };
}

/// Normally distributed grains g: their sum weighted by w, over the root of the sum of w^2, then flattened.
Reference reference(const GrainFamily& family) {
  const CellLattice lattice(family.grain_m, family.seed);
  return [lattice](Vec3 point) {
    double sum = 0;
    double squares = 0;
    visitCorners(lattice.place(point), [&](std::uint64_t bits, Vec3 away) {
      const double weight = falling(away.x) * falling(away.y) * falling(away.z);
      int set = 0;
      for (int bit = 0; bit < 48; ++bit) set += static_cast<int>(bits >> bit & 1);
      const double smear = (static_cast<double>(bits >> 48) + 0.5) / 65536 - 0.5;
      sum += weight * (set - 24 + smear) / std::sqrt(48.0 / 4 + 1.0 / 12);
      squares += weight * weight;
    });
    const double grain = sum / std::sqrt(squares);
    // Above 2 a parabola that ends level at 3, reached at 4; the scale gives the variance back that this takes.
    const double size = std::min(std::abs(grain), 4.0);
    const double flat = size <= 2 ? size : 3 - (4 - size) * (4 - size) / 4;
    return 1.0081844136 * std::copysign(flat, grain);
  };
}

Reference reference(const CellularFamily& family) {
  const CellLattice lattice(family.cell_m, family.seed);
  const double softness = family.smoothness;
  return [=](Vec3 point) {
    const CellLattice::Place place = lattice.place(point);
    const double rounding = softness / 2;
    const double farthest = std::hypot(1.0, rounding);
    double weights = std::exp(-farthest / softness);
    double sum = weights * farthest;
    for (int cell = 0; cell < 125; ++cell) {
      const std::array<int, 3> steps{cell % 5 - 2, cell / 5 % 5 - 2, cell / 25 - 2};
      const std::uint64_t bits =
          CellLattice::bits(place.key, static_cast<std::uint64_t>(steps[0]), static_cast<std::uint64_t>(steps[1]),
                            static_cast<std::uint64_t>(steps[2]));
      Vec3 away = place.within;
      for (int axis = 0; axis < 3; ++axis) {
        const auto random = static_cast<double>(bits >> 21 * axis & 0x1fffff) / 0x200000;
        away[axis] -= steps[static_cast<std::size_t>(axis)] + random;
      }
      const double squared = squaredLength(away);
      if (squared >= 1) continue;
      const double reach = 1 - quintic(std::max(0.0, 2 * squared - 1));
      const double distance = std::hypot(glm::length(away), rounding);
      const double weight = reach * std::exp(-distance / softness);
      weights += weight;
      sum += weight * distance;
    }
    return (sum / weights - rounding) / (farthest - rounding);
  };
}

/// Cardinal B-spline of this degree with its support from 0 to degree + 1, by the recursion of Cox and de Boor.
double bSpline(int degree, double x) {
  if (degree == 0) return x >= 0 && x < 1 ? 1 : 0;
  return (x * bSpline(degree - 1, x) + (degree + 1 - x) * bSpline(degree - 1, x - 1)) / degree;
}

/// The periodic bicubic spline through the samples: its coefficients' spectrum is that of the samples over that of the
/// spline at whole numbers, (4 + 2 cos) / 6.
std::vector<double> coefficientsOf(const SampledField& field) {
  const std::size_t width = field.width();
  const std::size_t height = field.height();
  Grid spectrum = transformed(Grid(field.samples().begin(), field.samples().end()), width, height, false);
  const auto ofSpline = [](std::size_t i, std::size_t count) {
    return (2 + std::cos(2 * pi * static_cast<double>(i) / static_cast<double>(count))) / 3;
  };
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) spectrum[y * width + x] /= ofSpline(x, width) * ofSpline(y, height);
  }
  std::vector<double> coefficients;
  for (const std::complex<double> c : transformed(spectrum, width, height, true)) {
    coefficients.push_back(c.real() / static_cast<double>(width * height));
  }
  return coefficients;
}

Reference reference(const MappedFamily& family, const SampledField& field) {
  const Mapping& mapping = family.mapping;
  if (mapping.shape != Mapping::Shape::kPlane) throw std::invalid_argument("there is a reference for planes only");
  const double width = field.width();
  const double height = field.height();
  return [=, coefficients = coefficientsOf(field)](Vec3 point) {
    const Vec3 local = glm::conjugate(mapping.rotation) * (point - mapping.centre);
    const double x = local.x / mapping.tile_m * width + (width - 1) / 2;
    const double y = local.y / mapping.tile_m * width + (height - 1) / 2;
    double sum = 0;
    for (int j = -1; j <= 2; ++j) {
      for (int i = -1; i <= 2; ++i) {
        const double column = std::floor(x) + i;
        const double row = std::floor(y) + j;
        const auto wrapped = [](double at, double period) {
          return static_cast<std::size_t>(at - period * std::floor(at / period));
        };
        sum += bSpline(3, x - column + 2) * bSpline(3, y - row + 2) *
               coefficients[wrapped(row, height) * static_cast<std::size_t>(width) + wrapped(column, width)];
      }
    }
    return sum;
  };
}

Reference reference(const LayeredFamily& family, const std::shared_ptr<const SampledField>& sampled) {
  std::vector<std::pair<double, Reference>> layers;
  for (const FieldLayer& layer : family.layers) layers.emplace_back(layer.weight, referenceOf(layer.family, sampled));
  const bool isSum = family.combination == LayeredFamily::Combination::kSum;
  return [layers = std::move(layers), isSum](Vec3 point) {
    double value = isSum ? 0 : 1;
    for (const auto& [weight, layer] : layers)
      value = isSum ? value + weight * layer(point) : value * weight * layer(point);
    return value;
  };
}

}  // namespace

Reference referenceOf(const FieldFamily& family, std::shared_ptr<const SampledField> sampled) {
  return std::visit(
      [&](const auto& of) -> Reference {
        if constexpr (std::is_same_v<std::decay_t<decltype(of)>, MappedFamily>) {
          return reference(of, *sampled);
        } else if constexpr (std::is_same_v<std::decay_t<decltype(of)>, LayeredFamily>) {
          return reference(of, sampled);
        } else if constexpr (std::is_same_v<std::decay_t<decltype(of)>, GrownFamily>) {
          throw std::invalid_argument("there is no reference for what is grown on a mesh");
        } else {
          return reference(of);
        }
      },
      family);
}

}  // namespace haptics::eval
