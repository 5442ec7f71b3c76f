#include "tests/bench/peers/peers.h"

namespace haptics::bench {

struct Cgal::Tree {};

Cgal::Cgal(const TriMesh&) {}
std::string Cgal::version() { return "not installed (libcgal-dev)"; }
Contestants Cgal::closest(std::span<const Vec3>) const { return {}; }

}  // namespace haptics::bench
