// scene_loop RATE_HZ FILE.scene FOLDER TICKS FORCES: the forces (3 doubles each) at ticks (their number, 3 doubles of the
// HIP) in a scene whose meshes and images are below its folder or the given one.
#include <haptics/scene_world.h>

#include <cstdlib>
#include <fstream>
#include <iostream>

int main(int, char** argv) try {
  haptics::World::Device device = haptics::World::Device::named("omni");
  device.rate_Hz = std::atof(argv[1]);
  haptics::SceneWorld world = haptics::SceneWorld::load(argv[2], device, {argv[3]});
  for (const haptics::SceneWorld::Body& body : world.bodies()) std::cout << body.number << ": " << body.name << "\n";
  std::ifstream ticks(argv[4], std::ios::binary);
  std::ofstream forces(argv[5], std::ios::binary);
  struct {
    std::uint64_t number;
    haptics::World::Vector hip_m;
  } tick;
  for (std::uint64_t next = 0; ticks.read(reinterpret_cast<char*>(&tick), sizeof tick); next = tick.number + 1) {
    const auto sample = world.step(tick.hip_m, next == 0 ? 0 : tick.number - next);
    forces.write(reinterpret_cast<const char*>(sample.force_N.data()), sizeof sample.force_N);
  }
} catch (const haptics::InvalidInput& refusal) {
  std::cerr << refusal.what() << "\n";
  return 1;
}
