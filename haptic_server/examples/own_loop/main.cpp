// own_loop RATE_HZ MESH.stl TICKS FORCES: the forces (3 doubles each) at ticks (their number, 3 doubles of the HIP).
#include <haptics/world.h>

#include <cstdlib>
#include <fstream>
#include <vector>

int main(int, char** argv) {
  struct {
    float normal[3], corner[3][3];
  } facet;
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::ifstream stl(argv[2], std::ios::binary);
  for (stl.seekg(84); stl.read(reinterpret_cast<char*>(&facet), 48); stl.seekg(2, std::ios::cur)) {
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (const auto& c : facet.corner) vertices.push_back({c[0], c[1], c[2]});
    triangles.push_back({first, first + 1, first + 2});
  }
  haptics::World::Device device = haptics::World::Device::named("omni");
  device.rate_Hz = std::atof(argv[1]);
  haptics::World world(device);
  world.add("torus", {vertices, triangles}, {.staticFriction = 0.4, .dynamicFriction = 0.3, .roundedBelow_rad = 0.6});
  std::ifstream ticks(argv[3], std::ios::binary);
  std::ofstream forces(argv[4], std::ios::binary);
  struct {
    std::uint64_t number;
    haptics::World::Vector hip_m;
  } tick;
  for (std::uint64_t next = 0; ticks.read(reinterpret_cast<char*>(&tick), sizeof tick); next = tick.number + 1) {
    const auto sample = world.step(tick.hip_m, next == 0 ? 0 : tick.number - next);
    forces.write(reinterpret_cast<const char*>(sample.force_N.data()), sizeof sample.force_N);
  }
}
