#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/clock/monotonic.h"
#include "common/log/log.h"
#include "graphics_client/mirror/server_link.h"
#include "haptic_server/recording/recording_bytes.h"
#include "haptic_server/server_app.h"
#include "tests/e2e/led_device.h"
#include "tests/e2e/recorded_rest.h"
#include "tests/eval/or_throw.h"

namespace haptics::e2e {
namespace {

using eval::orThrow;
using std::chrono::duration;
using std::chrono::seconds;

constexpr seconds kPatience{30};
constexpr double kBeforeEdit_s = 0.12;  // longer than a HIP rests before it is judged
constexpr double kSettled_s = 1;        // after an edit was accepted, it is felt in full,
constexpr double kWatched_s = 1.05;     // and the HIP rests on
constexpr double kRate_Hz = 1000;

void sleepFor(double time_s) { std::this_thread::sleep_for(duration<double>(time_s)); }

/// What a promise of another thread comes to; throws when it does not come.
template <class Value>
Value await(std::future<Value> future, const std::string& what) {
  if (future.wait_for(kPatience) != std::future_status::ready) throw std::runtime_error("not in time: " + what);
  return future.get();
}

/// A server with a device of the test, and a client that is connected to it by TCP.
class Session {
 public:
  Session(const std::filesystem::path& recording, Vec3 start)
      : device_(orThrow(findDevicePreset("omega.3")), 1 / kRate_Hz, start) {
    ServerOptions options;
    options.listen = "127.0.0.1:0";
    options.rate_Hz = kRate_Hz;
    options.record = recording.string();
    options.recordings = recording.parent_path();
    attachNext(device_);
    server_ = orThrow(ServerApp::start(options));
    link_ = std::make_unique<ServerLink>(
        ServerLink::Options{.server = orThrow(parseEndpoint(server_->address())), .clientName = "fuzzed edits"});
  }

  void lead(Vec3 place) {
    device_.lead(place);
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!device_.rests()) {
      if (std::chrono::steady_clock::now() > end) throw std::runtime_error("the servo does not read the device");
      sleepFor(0.002);
    }
    sleepFor(kBeforeEdit_s);
  }

  void upload(const std::string& mesh) {
    const auto uploaded = std::make_shared<std::promise<v1::AssetUploadReply>>();
    link_->upload(AssetKind::kMesh, mesh,
                  {.progress = {}, .finished = [uploaded](const auto& reply) { uploaded->set_value(reply); }});
    const v1::AssetUploadReply reply = await(uploaded->get_future(), "an upload");
    if (!reply.accepted()) throw std::runtime_error(reply.field() + ": " + reply.reason());
  }

  struct Pending {
    std::uint64_t sent_ns;
    std::future<std::pair<v1::EditReply, std::uint64_t>> replied;  ///< And when, ns.
    std::future<void> live;
  };
  [[nodiscard]] Pending submit(const v1::Transaction& transaction) {
    const auto replied = std::make_shared<std::promise<std::pair<v1::EditReply, std::uint64_t>>>();
    const auto live = std::make_shared<std::promise<void>>();
    Pending pending{monotonicNow_ns(), replied->get_future(), live->get_future()};
    link_->submit(transaction, {.replied =
                                    [replied](const auto& reply) {
                                      replied->set_value({reply, monotonicNow_ns()});
                                    },
                                .live = [live](const auto& /*edit*/) { live->set_value(); }});
    return pending;
  }

  struct Accepted {
    std::uint64_t revision = 0;
    std::uint64_t replied_ns = 0;
    double live_s = 0;  ///< From sending it until the client knows that it is felt.
  };
  [[nodiscard]] static Accepted whenLive(Pending pending) {
    const auto [reply, replied_ns] = await(std::move(pending.replied), "a reply");
    if (!reply.has_accepted()) throw std::runtime_error("not accepted: " + reply.ShortDebugString());
    await(std::move(pending.live), "an edit that is live");
    return {reply.accepted().revision(), replied_ns, 1e-9 * static_cast<double>(monotonicNow_ns() - pending.sent_ns)};
  }

  void stop() {
    link_.reset();
    orThrow(server_->stop());
  }

 private:
  LedDevice device_;
  std::unique_ptr<ServerApp> server_;
  std::unique_ptr<ServerLink> link_;
};

struct Outcome {
  std::uint64_t windows = 0;
  std::uint64_t edits = 0;
  std::map<std::string, int> kinds;  ///< Windows.
  double longestUntilLive_s = 0;
  RestVerdict verdict;
};

/// Sends so many windows of edits to a server of its own, each to be felt in full before the next, and judges its recording.
class FuzzedSession {
 public:
  FuzzedSession(std::filesystem::path recording, std::uint64_t seed, std::uint64_t windows)
      : recording_(std::move(recording)), seed_(seed), windows_(windows) {}

  [[nodiscard]] Outcome run() {
    scenes_.push_back(std::make_unique<FuzzedEdits>(seed_));
    Session session(recording_, scenes_.back()->start());
    while (true) {
      const FuzzedEdits& scene = *scenes_.back();
      begin(scene, session);
      std::size_t last = 0;
      for (std::size_t i = 0; i < scene.windows().size() && outcome_.windows < windows_; ++i) {
        if (scene.windows()[last = i].edits.empty()) continue;
        send(scene, i, session);
      }
      if (outcome_.windows == windows_) break;
      session.lead(scene.start());
      static_cast<void>(Session::whenLive(session.submit(scene.removal(last))));
      scenes_.push_back(std::make_unique<FuzzedEdits>(++seed_));
    }
    session.stop();
    outcome_.verdict = judgeRest(orThrow(RecordingBytes::open(recording_)), sent_);
    return outcome_;
  }

 private:
  static void begin(const FuzzedEdits& scene, Session& session) {
    for (const std::string& mesh : scene.assets()) session.upload(mesh);
    static_cast<void>(Session::whenLive(session.submit(scene.scene())));
  }

  void send(const FuzzedEdits& scene, std::size_t index, Session& session) {
    const FuzzedEdits::Window& window = scene.windows()[index];
    session.lead(window.hip);
    std::vector<Session::Pending> pending;
    for (const FuzzedEdits::Edit& edit : window.edits) {
      if (!pending.empty()) sleepFor(edit.after_s);
      pending.push_back(session.submit(edit.transaction));
    }
    Session::Accepted last;
    for (Session::Pending& edit : pending) {
      last = Session::whenLive(std::move(edit));
      outcome_.longestUntilLive_s = std::max(outcome_.longestUntilLive_s, last.live_s);
    }
    sent_.push_back({&scene, index, last.revision, last.replied_ns + static_cast<std::uint64_t>(kSettled_s * 1e9)});
    ++outcome_.windows;
    outcome_.edits += window.edits.size();
    ++outcome_.kinds[window.kind];
    const double since_s = 1e-9 * static_cast<double>(monotonicNow_ns() - last.replied_ns);
    if (since_s < kWatched_s) sleepFor(kWatched_s - since_s);
  }

  const std::filesystem::path recording_;
  std::uint64_t seed_;
  const std::uint64_t windows_;
  std::vector<std::unique_ptr<FuzzedEdits>> scenes_;
  std::vector<SentWindow> sent_;
  Outcome outcome_;
};

/// An edit of the fuzzer is one, or two, that come while the HIP rests. HAPTICS_EDITS: how many.
TEST(EditsOverSocket, DoNotKickAndAreFeltInFull) {
  const char* asked = std::getenv("HAPTICS_EDITS");
  const std::uint64_t edits = asked != nullptr ? std::strtoull(asked, nullptr, 10) : 40;
  // One server each, at a time. Edits of every kind come by them.
  constexpr std::array<std::uint64_t, 4> kFirstSeeds{8, 14, 24, 33};
  const std::uint64_t windows = edits / kFirstSeeds.size();
  logFrom(LogLevel::kWarning);
  const auto folder = std::filesystem::path(testing::TempDir()) / ("edits-over-socket-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  std::vector<std::future<Outcome>> outcomes;
  for (const std::uint64_t seed : kFirstSeeds) {
    outcomes.push_back(std::async(std::launch::async, [&folder, seed, windows] {
      return FuzzedSession(folder / ("seed-" + std::to_string(seed) + ".haptics"), seed, windows).run();
    }));
  }
  std::uint64_t sent = 0;
  std::uint64_t inContact = 0;
  std::map<std::string, int> kinds;
  for (auto& future : outcomes) {
    const Outcome outcome = future.get();
    const RestVerdict& verdict = outcome.verdict;
    std::printf(
        "%llu windows of %llu edits: at most %.4f N a tick in %llu ticks at rest; %llu felt in full, %llu in "
        "contact, %llu by the spring; live after at most %.3f s; %llu ticks, %llu missed, %llu with a fault\n",
        static_cast<unsigned long long>(outcome.windows), static_cast<unsigned long long>(outcome.edits),
        verdict.largestStep_N, static_cast<unsigned long long>(verdict.resting),
        static_cast<unsigned long long>(verdict.settled), static_cast<unsigned long long>(verdict.inContact),
        static_cast<unsigned long long>(verdict.exact), outcome.longestUntilLive_s,
        static_cast<unsigned long long>(verdict.ticks), static_cast<unsigned long long>(verdict.missed),
        static_cast<unsigned long long>(verdict.faults));
    for (const std::string& failure : verdict.failures) ADD_FAILURE() << failure;
    EXPECT_GE(verdict.settled, outcome.windows - outcome.windows / 10) << "too many faults";
    EXPECT_EQ(verdict.differing, 0U);
    sent += outcome.windows;
    inContact += verdict.inContact;
    for (const auto& [kind, count] : outcome.kinds) kinds[kind] += count;
  }
  for (const auto& [kind, count] : kinds) std::printf("%s: %d\n", kind.c_str(), count);
  EXPECT_EQ(sent, windows * kFirstSeeds.size());
  EXPECT_GT(inContact, sent / 3) << "edits that nobody feels test nothing";
  if (!HasFailure()) std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace haptics::e2e
