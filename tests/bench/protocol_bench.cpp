#include <benchmark/benchmark.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <future>
#include <thread>

#include "common/clock/monotonic.h"
#include "common/log/log.h"
#include "common/wire/convert.h"
#include "common/wire/framing.h"
#include "graphics_client/mirror/server_link.h"
#include "haptic_server/server_app.h"
#include "tests/bench/benches.h"

namespace haptics::bench {
namespace {

constexpr std::size_t kVertices = 10'000;
constexpr double kTelemetry_Hz = 1000;
constexpr std::chrono::seconds kPatience{30};
constexpr const char* kScene = R"(operations { add { name: "ball" mesh { sphere { radius_m: 0.05 segments: 64 } } } })";

/// What a mesh's new vertices cost on the wire today: their canonical bytes in AssetChunks, in a message used again.
void encodeVertices(benchmark::State& state) {
  const std::string bytes(kVertices * 3 * sizeof(float), 'x');
  v1::Envelope envelope;
  envelope.set_protocol_version(kProtocolVersion);
  std::string frames;
  for ([[maybe_unused]] auto _ : state) {
    frames.clear();
    for (std::size_t offset = 0; offset < bytes.size(); offset += kMaxChunkBytes) {
      v1::AssetChunk& chunk = *envelope.mutable_asset_chunk();
      chunk.set_total_size(bytes.size());
      chunk.set_offset(offset);
      chunk.set_data(bytes.data() + offset, std::min(kMaxChunkBytes, bytes.size() - offset));
      (void)appendFrame(frames, envelope);
    }
    benchmark::DoNotOptimize(frames.data());
  }
  state.counters["bytes"] = static_cast<double>(frames.size());
}

void encodeTelemetry(benchmark::State& state) {
  const TelemetrySample sample{};
  v1::Envelope envelope;
  envelope.set_protocol_version(kProtocolVersion);
  std::string frame;
  for ([[maybe_unused]] auto _ : state) {
    frame.clear();
    toWire(sample, *envelope.mutable_telemetry());
    (void)appendFrame(frame, envelope);
    benchmark::DoNotOptimize(frame.data());
  }
  state.counters["bytes"] = static_cast<double>(frame.size());
}

/// One server, and links to it by memory (the paper's Figure 1a) or by TCP on loopback (1b).
class Connected {
 public:
  explicit Connected(bool byMemory) : byMemory_(byMemory) {
    logFrom(LogLevel::kWarning);
    const auto file = std::filesystem::temp_directory_path() / ("haptic_bench_" + std::to_string(getpid()) + ".scene");
    std::ofstream(file) << kScene;
    ServerOptions options;
    options.scene = file.string();
    options.listen = "127.0.0.1:0";
    app_ = ServerApp::start(options).value();
    std::filesystem::remove(file);
  }

  [[nodiscard]] std::unique_ptr<ServerLink> link(double telemetry_Hz, bool meshes) const {
    ServerLink::Connect connect;
    if (byMemory_) {
      connect = [app = app_.get()](EventLoop& loop, const ServerLink::Connected& done) {
        loop.post([app, &loop, done] { done(app->connect(loop)); });
        return std::shared_ptr<void>();
      };
    }
    return std::make_unique<ServerLink>(ServerLink::Options{.server = parseEndpoint(app_->address()).value(),
                                                            .clientName = "bench",
                                                            .telemetryRate_Hz = telemetry_Hz,
                                                            .fetchAssets = meshes,
                                                            .connect = std::move(connect)});
  }

 private:
  bool byMemory_;
  std::unique_ptr<ServerApp> app_;
};

/// Clients that come one after another, each of which fetches the whole scene: what is exchanged beside what is measured.
class Exchange {
 public:
  Exchange(const Connected& connected, bool busy) : began_ns_(monotonicNow_ns()) {
    if (!busy) return;
    thread_ = std::thread([this, &connected] {
      while (!stop_) {
        const auto link = connected.link(0, true);
        const auto whole = link->waitUntil([](const MirrorView& view) { return view.hashesEqual; }, kPatience);
        for (const auto& [hash, mesh] : whole->meshes) {
          bytes_ += mesh->vertices.size() * sizeof(Vec3f) + mesh->triangles.size() * sizeof(TriangleIndices);
        }
      }
    });
  }
  ~Exchange() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  [[nodiscard]] double megabytesPerSecond() const {
    return 1e3 * static_cast<double>(bytes_) / static_cast<double>(monotonicNow_ns() - began_ns_);
  }

 private:
  std::uint64_t began_ns_;
  std::atomic<std::uint64_t> bytes_{0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// From the device's position read to the sample in the client's hands. Manual time.
void stateLatency(benchmark::State& state, bool byMemory, bool busy) {
  const Connected connected(byMemory);
  const auto link = connected.link(kTelemetry_Hz, false);
  const Exchange exchange(connected, busy);
  std::uint64_t seen = 0;
  for ([[maybe_unused]] auto _ : state) {
    const auto view = link->waitUntil([&](const MirrorView& v) { return v.samplesReceived > seen; }, kPatience);
    seen = view->samplesReceived;
    state.SetIterationTime(1e-9 * static_cast<double>(view->takenAt_ns - view->sample->time_ns));
  }
  state.counters["exchanged_MB_per_s"] = exchange.megabytesPerSecond();
}

/// From submit to the acceptance, or to the word that the servo feels it.
void editLatency(benchmark::State& state, bool byMemory, bool busy, bool felt) {
  const Connected connected(byMemory);
  const auto link = connected.link(0, false);
  const Exchange exchange(connected, busy);
  int count = 0;
  for ([[maybe_unused]] auto _ : state) {
    v1::Transaction transaction;
    v1::SetMaterial& set = *transaction.add_operations()->mutable_set_material();
    set.mutable_object()->set_name("ball");
    set.mutable_material()->set_stiffness_n_per_m(500 + ++count % 100);
    std::promise<void> accepted, live;
    const std::uint64_t began_ns = monotonicNow_ns();
    std::uint64_t accepted_ns = 0;
    link->submit(std::move(transaction), {[&](const v1::EditReply&) {
                                            accepted_ns = monotonicNow_ns();
                                            accepted.set_value();
                                          },
                                          [&](const v1::EditLive&) { live.set_value(); }});
    accepted.get_future().wait();
    live.get_future().wait();
    state.SetIterationTime(1e-9 * static_cast<double>((felt ? monotonicNow_ns() : accepted_ns) - began_ns));
  }
  state.counters["exchanged_MB_per_s"] = exchange.megabytesPerSecond();
}

}  // namespace

void registerProtocol() {
  benchmark::RegisterBenchmark("protocol/encode_10k_vertices", encodeVertices);
  benchmark::RegisterBenchmark("protocol/encode_telemetry", encodeTelemetry);
  for (const bool byMemory : {true, false}) {
    for (const bool busy : {false, true}) {
      const std::string how = std::string(byMemory ? "figure_1a_memory" : "figure_1b_tcp") + (busy ? "/busy" : "/idle");
      benchmark::RegisterBenchmark(("protocol/state/" + how).c_str(), stateLatency, byMemory, busy)
          ->UseManualTime()
          ->Iterations(2000);
      for (const bool felt : {false, true}) {
        benchmark::RegisterBenchmark(("protocol/edit_" + std::string(felt ? "felt/" : "accepted/") + how).c_str(),
                                     editLatency, byMemory, busy, felt)
            ->UseManualTime()
            ->Iterations(200);
      }
    }
  }
}

}  // namespace haptics::bench
