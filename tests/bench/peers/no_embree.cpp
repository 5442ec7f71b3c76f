#include "tests/bench/peers/peers.h"

namespace haptics::bench {

struct Embree::Scenes {};

Embree::Embree(const TriMesh&) {}
std::string Embree::version() { return "not installed (libembree-dev)"; }
Contestants Embree::closest(std::span<const Vec3>) const { return {}; }
Contestants Embree::occluded(std::span<const Way>) const { return {}; }
Contestants Embree::first(std::span<const Way>) const { return {}; }

}  // namespace haptics::bench
