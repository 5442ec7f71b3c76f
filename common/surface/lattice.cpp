#include "common/surface/lattice.h"

namespace haptics {
namespace {

/// A turn about no axis and by no angle that an object is likely to have; any other such would do.
glm::dmat3 turn() noexcept { return glm::mat3_cast(glm::normalize(Quat(1, 0.31, 0.47, 0.22))); }

}  // namespace

CellLattice::CellLattice(double side_m, std::uint64_t seed, Vec3 offset) noexcept
    : toLattice_(turn() / side_m), offset_(offset), seed_(mixed(seed)) {}

}  // namespace haptics
