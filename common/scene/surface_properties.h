#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/hash/content_hash.h"
#include "common/maths/fields.h"
#include "common/maths/vec.h"
#include "common/scene/asset_source.h"

// How an object's surface feels beyond its shape (section 4 of the paper), as records: plain data that both databases
// hold, compare and hash. Lengths in metres, angles in radians, points and directions in the object's frame.
namespace haptics {

// ---- Dimensionless scalar fields over a surface: f of a texture's height and of what varies ----

struct FourierTerm {
  double amplitude = 1;  ///< Not 0.
  Vec3 direction{0};     ///< Unit, object frame: across the waves.
  double wavelength_m = 0;
  double phase_rad = 0;
  bool operator==(const FourierTerm&) const = default;
};

/// f = sum of amplitude * cos(2 pi (x . direction) / wavelength + phase). One term is a grating.
struct FourierFamily {
  std::vector<FourierTerm> terms;  ///< 1 to 64.
  bool operator==(const FourierFamily&) const = default;
};

/// Gradient noise (Perlin). More octaves than one make a fractal: each has half the wavelength and `persistence` times
/// the amplitude of the one before.
struct NoiseFamily {
  double wavelength_m = 0;  ///< Of the first octave's lattice.
  std::uint32_t octaves = 1;
  double persistence = 0.5;
  std::uint32_t seed = 1;
  bool operator==(const NoiseFamily&) const = default;
};

/// Distance to the nearest of randomly placed points (Worley), in cells.
struct CellularFamily {
  double cell_m = 0;
  double smoothness = 0.1;  ///< Of the minimum over the points, in cells: where two are as near, f is C1.
  std::uint32_t seed = 1;
  bool operator==(const CellularFamily&) const = default;
};

/// Sandpaper: random with mean 0 and variance 1 everywhere.
struct GrainFamily {
  double grain_m = 0;  ///< Side of the lattice.
  std::uint32_t seed = 1;
  bool operator==(const GrainFamily&) const = default;
};

/// Two-stage mapping (Bier & Sloan 1986): a plane field wrapped round an intermediate surface, and that one on to the
/// object along the intermediate surface's normal (common/surface/mapping.h).
struct Mapping {
  enum class Shape : std::uint8_t { kPlane = 1, kCube, kCylinder, kSphere };
  Shape shape = Shape::kPlane;
  Vec3 centre{0};             ///< Of the intermediate surface, object frame.
  Quat rotation{1, 0, 0, 0};  ///< Its frame to the object's; its axis is z.
  /// Sides of the box around the intermediate surface, in its frame, each > 0: a cube may be any box; a cylinder or a
  /// sphere has the diameter size_m.x; a plane needs none. Left out of an edit: those of the mesh.
  Vec3 size_m{1};
  /// Side of one tile of the field, along its rows. Round a cylinder or sphere: the whole turn holds the whole number of
  /// tiles nearest to it.
  double tile_m = 0;
  bool operator==(const Mapping&) const = default;
};

/// An image or a computed field (reaction-diffusion, spot noise), which is an asset of its own.
struct MappedFamily {
  ContentHash field;  ///< Of a sampled field.
  Mapping mapping;
  bool operator==(const MappedFamily&) const = default;
};

/// A pattern grown on the mesh itself (Turk 1991), which is an asset of its own.
struct GrownFamily {
  ContentHash points;  ///< Of a point field.
  bool operator==(const GrownFamily&) const = default;
};

struct FieldLayer;

/// Fields together: f = sum of weight * f_layer, or product of weight * f_layer.
struct LayeredFamily {
  enum class Combination : std::uint8_t { kSum = 1, kProduct };
  Combination combination = Combination::kSum;
  std::vector<FieldLayer> layers;  ///< 2 to 4.
  bool operator==(const LayeredFamily&) const;
};

// Alternatives that many files copy are types of their own, whose copies are compiled once.
struct FieldFamily
    : std::variant<FourierFamily, NoiseFamily, CellularFamily, GrainFamily, MappedFamily, LayeredFamily, GrownFamily> {
  using variant::variant;
  using variant::operator=;
  FieldFamily() noexcept;
  FieldFamily(const FieldFamily&);
  FieldFamily(FieldFamily&&) noexcept;
  FieldFamily& operator=(const FieldFamily&);
  FieldFamily& operator=(FieldFamily&&) noexcept;
  ~FieldFamily();
  bool operator==(const FieldFamily&) const;
};

struct FieldLayer {
  double weight = 1;   ///< Not 0.
  FieldFamily family;  ///< Not layered.
  bool operator==(const FieldLayer&) const;
};

/// Where a layer's field is below ScalarField: "layers.layer[1].field.".
[[nodiscard]] std::string layerField(std::size_t layer);

// ---- Properties ----

/// A line given by its vertices in the mesh's canonical numbering, the smaller first.
using Crease = std::array<std::uint32_t, 2>;

/// Force shading: one direction of the force over the whole of a rounded surface.
struct Shading {
  double crease_rad = 0;        ///< In (0, pi]. Lines whose faces' normals differ by more stay sharp.
  std::vector<Crease> creases;  ///< Lines that stay sharp whatever their angle; ascending, each once.
  bool operator==(const Shading&) const = default;
};

/// One factor per vertex, linear in between.
struct PerVertexScale {
  ContentHash values;  ///< Of an asset: a float >= 0 for each vertex, canonical numbering.
  bool operator==(const PerVertexScale&) const = default;
};

/// What a factor over the surface follows: nothing, a field, or values per vertex.
struct FactorMap : std::variant<std::monostate, FieldFamily, PerVertexScale> {
  using variant::variant;
  using variant::operator=;
  FactorMap() noexcept;
  FactorMap(const FactorMap&);
  FactorMap(FactorMap&&) noexcept;
  FactorMap& operator=(const FactorMap&);
  FactorMap& operator=(FactorMap&&) noexcept;
  ~FactorMap();
  bool operator==(const FactorMap&) const;
};

/// Stick and slide. Over a field f: mu(x) = mu * max(0, 1 + variation * f(x)); per vertex: mu(x) = mu * scale(x).
struct Friction {
  double mu_static = 0, mu_dynamic = 0;  ///< 0 <= mu_dynamic <= mu_static <= 10.
  double variation = 0;                  ///< Of a field; 0 without one.
  FactorMap over = {};                   ///< Of both coefficients.
  double dynamicVariation = 0;           ///< Of the field below.
  /// Where there is one: of mu_dynamic instead of `over`, with mu_dynamic(x) <= mu_static(x) all the same.
  FactorMap dynamicOver = {};
  bool operator==(const Friction&) const = default;
};

/// Height of the felt surface over the geometric one: h = amplitude * (f - lowest f), and the force that comes of it.
struct Texture {
  enum class Law : std::uint8_t {
    kHo1999 = 1,  ///< Eqs. (4a), (4b).
    kBump,        ///< F = d M with M as in Eq. (2), not normalised.
  };
  Law law = Law::kHo1999;
  FieldFamily family;
  double amplitude_m = 0;  ///< > 0.
  bool literal = false;    ///< h = amplitude * f instead: below 0 it is a pit.
  double gain_K = 1.5;     ///< K of Eq. (4), in (0, 2].
  bool operator==(const Texture&) const = default;
};

/// A factor of a stiffness over the surface, nowhere less than kMinStiffnessFactor: 1 + variation * f(x) over a field
/// f, scale(x) per vertex.
struct SurfaceMap {
  double variation = 0;  ///< Of a field; 0 without one.
  FactorMap over;        ///< Not nothing.
  bool operator==(const SurfaceMap&) const = default;
};
/// Where a map would make a stiffness vanish, the stylus would pass through the surface. Lower is felt as a hole; higher
/// keeps soft places from being soft.
inline constexpr double kMinStiffnessFactor = 0.05;

/// Numbers, each named as in Material of scene.proto, which has its unit and range. 0 is as if there were none.
/// @tparam Number  double, or of an edit an optional one.
template <class Number>
struct SurfaceScalars {
  Number adhesion_N{};       ///< Pull along the normal on what is less than kAdhesionReach_m above the surface.
  Number tap_Ns_per_m{};     ///< Of a decaying sinusoid of force on touching: its amplitude per speed,
  Number tap_Hz{};           ///< frequency,
  Number tap_decay_per_s{};  ///< and rate of decay, of which less than kSlowestTap_per_s counts as that.
  bool operator==(const SurfaceScalars&) const = default;
  HAPTICS_FIELDS(self.adhesion_N, self.tap_Ns_per_m, self.tap_Hz, self.tap_decay_per_s);
};
inline constexpr double kAdhesionReach_m = 1e-3;
/// Nothing of a tap is left after 0.1 s.
inline constexpr double kSlowestTap_per_s = 60;

/// Calls visit(name, its value in each of the scalars...).
template <class Visit, class... Scalars>
void forEachScalar(const Visit& visit, Scalars&... scalars) {
  fields::forEachMember(
      [&visit](std::size_t i, auto&... values) {
        visit(fields::nameOf(SurfaceScalars<double>::kFieldNames, i), values...);
      },
      scalars...);
}

struct SurfaceProperties {
  std::optional<Shading> shading;
  std::optional<Friction> friction;
  std::optional<Texture> texture;
  std::optional<SurfaceMap> stiffnessOver;  ///< Of the material's stiffness and damping.
  std::optional<SurfaceMap> softnessOver;   ///< Of the tissue's stiffness; of a rigid object nothing follows it.
  SurfaceScalars<double> scalars;
  bool operator==(const SurfaceProperties&) const = default;
};

/// In canonical form; nothing for a surface without properties.
void addTo(Hasher& hasher, const SurfaceProperties& properties);
/// What the properties name by content, friction's first.
[[nodiscard]] std::vector<AssetName> assetsOf(const SurfaceProperties& properties);
/// The same properties with other names: `rename` is asked for each.
[[nodiscard]] SurfaceProperties renamed(SurfaceProperties properties,
                                        const std::function<ContentHash(const AssetName&)>& rename);

}  // namespace haptics
