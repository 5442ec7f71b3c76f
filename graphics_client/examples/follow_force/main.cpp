// follow_force HOST:PORT SECONDS [EDIT]: applies an edit (in the text of scene files) to a running server, then prints the
// force 10 times a second.
#include <haptics/client.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

int main(int argc, char** argv) try {
  if (argc < 3) {
    std::fputs("usage: follow_force HOST:PORT SECONDS [EDIT]\n", stderr);
    return 2;
  }
  haptics::Client client({.server = argv[1], .name = "follow_force"});
  if (argc > 3) {
    const auto applied = client.apply(argv[3]);
    std::printf("revision %llu, felt since tick %llu\n", static_cast<unsigned long long>(applied.revision),
                static_cast<unsigned long long>(applied.tick));
  }
  for (int left = static_cast<int>(10 * std::atof(argv[2])); left > 0; --left) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const haptics::Client::State state = client.state();
    if (!state.connected) {
      std::printf("%s\n", state.connection.c_str());
      continue;
    }
    const char* touched = "nothing";
    for (const auto& body : state.bodies) touched = body.number == state.touched ? body.name.c_str() : touched;
    std::printf("%.3f %.3f %.3f N, touches %s\n", state.force_N[0], state.force_N[1], state.force_N[2], touched);
  }
} catch (const std::exception& failure) {
  std::fprintf(stderr, "follow_force: %s\n", failure.what());
  return 1;
}
