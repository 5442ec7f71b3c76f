#include <benchmark/benchmark.h>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <future>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>

#include "common/log/log.h"
#include "common/process/file_handle.h"
#include "common/process/spawn.h"
#include "graphics_client/embedded_server.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenes.h"
#include "tests/common/temporary_folder.h"

namespace haptics::bench {
namespace {

constexpr const char* kOne = "figure_1a_one_process";
constexpr const char* kTwo = "figure_1b_two_processes";
constexpr std::chrono::minutes kPatience{10};
/// Explored by the simulated hand once the scene is held: what is missed by then, and the memory that is left.
constexpr std::chrono::seconds kExplored{5};
constexpr double kFrames_Hz = 60;

std::filesystem::path ownProgram() { return std::filesystem::read_symlink("/proc/self/exe"); }

/// Resident memory of a process, shared pages included.
double resident_bytes(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/statm");
  double size_pages = 0, resident_pages = 0;
  file >> size_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// haptic_server without a scene, on a free port.
class ServerProcess {
 public:
  explicit ServerProcess(const std::filesystem::path& recordings) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    const FileHandle output(ends[0]), input(ends[1]);
    process_ = spawn(ownProgram().parent_path() / "haptic_server",
                     {.arguments = {"--listen", "127.0.0.1:0", "--recordings", recordings.string()},
                      .descriptors = {-1, input.descriptor(), -1}})
                   .value();
    std::string line;
    for (char next = 0; next != '\n' && read(output.descriptor(), &next, 1) == 1;) line += next;
    const std::string_view before = "listening on ";
    if (!line.starts_with(before)) throw std::runtime_error("haptic_server does not start");
    address_ = parseEndpoint(line.substr(before.size(), line.size() - before.size() - 1)).value();
  }
  ~ServerProcess() {
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  [[nodiscard]] pid_t id() const noexcept { return process_; }
  [[nodiscard]] const Endpoint& address() const noexcept { return address_; }

 private:
  pid_t process_ = 0;
  Endpoint address_;
};

/// A server, and a viewer's database of its scene, in one process or in two.
class Structure {
 public:
  explicit Structure(bool oneProcess) {
    if (oneProcess) {
      ServerOptions options;
      options.recordings = folder_.path();
      inside_.emplace(options, [] {});
    } else {
      outside_.emplace(folder_.path());
    }
    viewer_ = link(kFrames_Hz, true);
    observer_ = link(0, false);
    for (const ServerLink* each : {viewer_.get(), observer_.get()}) {
      await(*each, [](const MirrorView& view) { return view.link == LinkState::kLive; });
    }
  }

  /// Adds a sphere; prints what that costs, one figure a line.
  void measure(std::uint32_t segments) {
    const double empty_bytes = memory_bytes();
    const v1::Status before = status();
    add(segments);
    const auto commit = await(*observer_, [](const MirrorView& view) { return !view.scene->objects().empty(); });
    const auto held =
        await(*viewer_, [](const MirrorView& view) { return !view.scene->objects().empty() && view.hashesEqual; });
    std::this_thread::sleep_for(kExplored);
    const v1::Status after = status();
    const double bytes = memory_bytes();
    const auto delay_ns = static_cast<double>(held->takenAt_ns) - static_cast<double>(commit->takenAt_ns);
    std::cout << "commit_to_held_s " << std::max(0.0, 1e-9 * delay_ns) << "\nrss_MB " << 1e-6 * bytes
              << "\nrss_without_scene_MB " << 1e-6 * empty_bytes << "\nbytes_per_triangle "
              << (bytes - empty_bytes) / triangleCount(segments) << "\nticks " << after.ticks() - before.ticks()
              << "\nmissed_ticks " << after.missed_ticks() - before.missed_ticks() << std::endl;
  }

 private:
  [[nodiscard]] std::unique_ptr<ServerLink> link(double telemetry_Hz, bool assets) {
    ServerLink::Options options;
    options.clientName = "bench";
    options.telemetryRate_Hz = telemetry_Hz;
    options.fetchAssets = assets;
    if (inside_) {
      options.connect = inside_->connect();
      options.sharedAssets = inside_->sharedAssets();
    } else {
      options.server = outside_->address();
    }
    return std::make_unique<ServerLink>(std::move(options));
  }

  static std::shared_ptr<const MirrorView> await(const ServerLink& link,
                                                 const std::function<bool(const MirrorView&)>& condition) {
    auto view = link.waitUntil(condition, kPatience);
    if (!view) throw std::runtime_error("not in time: " + link.latest()->linkText);
    return view;
  }

  void add(std::uint32_t segments) {
    v1::Transaction transaction;
    v1::AddObject& object = *transaction.add_operations()->mutable_add();
    object.set_name("ball");
    object.mutable_mesh()->mutable_sphere()->set_radius_m(kRadius_m);
    object.mutable_mesh()->mutable_sphere()->set_segments(segments);
    observer_->submit(std::move(transaction), {[](const v1::EditReply& reply) {
                                                 if (reply.has_accepted()) return;
                                                 std::cerr << reply.ShortDebugString() << '\n';
                                                 std::_Exit(1);
                                               },
                                               {}});
  }

  [[nodiscard]] v1::Status status() {
    std::promise<v1::Status> answer;
    observer_->requestStatus([&](const v1::Status& status) { answer.set_value(status); });
    return answer.get_future().get();
  }

  [[nodiscard]] double memory_bytes() const {
    return resident_bytes(getpid()) + (outside_ ? resident_bytes(outside_->id()) : 0);
  }

  const test::TemporaryFolder folder_;
  std::optional<EmbeddedServer> inside_;
  std::optional<ServerProcess> outside_;
  std::unique_ptr<ServerLink> viewer_;
  std::unique_ptr<ServerLink> observer_;  ///< Of records only: sees a commit as soon as it is made.
};

/// In a process of its own, whose memory is that of the structure alone.
void compareStructure(benchmark::State& state, const char* structure, std::uint32_t segments) {
  std::ostringstream command;
  command << ownProgram() << ' ' << kStructure << ' ' << structure << ' ' << segments;
  std::map<std::string, double> figures;
  for ([[maybe_unused]] auto _ : state) {
    FILE* const output = popen(command.str().c_str(), "r");
    char name[64];
    double value = 0;
    while (output != nullptr && std::fscanf(output, "%63s %lf", name, &value) == 2) figures[name] = value;
    if (output == nullptr || pclose(output) != 0) state.SkipWithError("the structure does not run");
    state.SetIterationTime(figures["commit_to_held_s"]);
  }
  for (const auto& [name, value] : figures) state.counters[name] = value;
}

}  // namespace

int runStructure(const char* structure, const char* segments) {
  logFrom(LogLevel::kError);
  Structure(std::string_view(structure) == kOne).measure(static_cast<std::uint32_t>(std::stoul(segments)));
  return 0;
}

void registerStructures(std::span<const std::uint32_t> sizes) {
  for (const std::uint32_t segments : sizes) {
    for (const char* structure : {kOne, kTwo}) {
      const std::string name =
          std::string("structures/") + structure + "/triangles:" + std::to_string(triangleCount(segments));
      benchmark::RegisterBenchmark(name.c_str(), compareStructure, structure, segments)
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond)
          ->Iterations(1);
    }
  }
}

}  // namespace haptics::bench
