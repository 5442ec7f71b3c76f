#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/mesh/generators.h"
#include "common/mesh/import.h"
#include "common/wire/convert.h"
#include "haptic_server/engine/geometry/collision_mesh.h"
#include "haptic_server/scene/edit_price.h"
#include "haptic_server/scene/scene_service.h"
#include "tests/eval/fuzz/fuzz.h"
#include "tests/eval/fuzz/random_edits.h"
#include "tests/eval/report.h"
#include "tests/eval/table1/interruption.h"

namespace haptics::eval {
namespace {

constexpr int kEditsOfWorld = 10;
constexpr std::uint64_t kWorldsToALine = 10;
constexpr SessionId kEditor = 1;
/// Of the accepted edits that take so long nine of ten have prices of at most so many times that.
constexpr double kLong_s = 0.1, kMostTimes = 10, kShare = 0.9;
/// A share of fewer says little.
constexpr std::uint64_t kMany = 20;
/// A refusal takes no longer, nor does the end of what nobody wants any more.
constexpr double kRefusal_s = 0.1, kEnd_s = 0.1;
/// Nothing that is accepted takes more.
constexpr double kMostTime_s = 10, kMostMemory_bytes = 2e9;
/// Each third of the edits that are said to take so long is begun once more than it is carried out, and cancelled.
constexpr double kWorthCancelling_s = 0.5;

/// Edits of any size, each order of magnitude of it alike.
class EditsOfAnySize {
 public:
  explicit EditsOfAnySize(std::uint64_t seed) : random_(seed), usual_(seed) {}

  [[nodiscard]] v1::Transaction next(const SceneVersion& scene, AssetStore& store) {
    if (random_.chance(0.15) && !scene.objects().empty()) return many(scene, store);
    v1::Transaction transaction;
    do {
      transaction = usual_.next(scene);
    } while (usual_.streams());
    for (v1::Operation& operation : *transaction.mutable_operations()) enlarge(operation, store, 3e5);
    return transaction;
  }

 private:
  [[nodiscard]] double spread(double low, double high) {
    return std::exp(random_.between(std::log(low), std::log(high)));
  }
  [[nodiscard]] std::uint32_t count(double low, double high) { return static_cast<std::uint32_t>(spread(low, high)); }

  /// Up to a thousand operations of one kind.
  [[nodiscard]] v1::Transaction many(const SceneVersion& scene, AssetStore& store) {
    v1::Transaction transaction;
    const auto& objects = scene.objects();
    const int kind = random_.below(4);
    const std::uint32_t operations = count(2, 1000);
    const double triangles = spread(12, 1e5);
    for (std::uint32_t i = 0; i < operations; ++i) {
      v1::Operation& operation = *transaction.add_operations();
      const ObjectId object = objects[static_cast<std::size_t>(random_.below(static_cast<int>(objects.size())))]->id;
      if (kind == 0) {
        operation.mutable_set_pose()->mutable_object()->set_id(object);
        operation.mutable_set_pose()->mutable_pose()->mutable_position()->set_z(random_.between(-0.1, 0.1));
      } else if (kind == 1) {
        operation.mutable_remesh()->mutable_object()->set_id(object);
        v1::Sphere& sphere = *operation.mutable_remesh()->mutable_mesh()->mutable_sphere();
        sphere.set_radius_m(random_.between(0.005, 0.05));
        sphere.set_segments(static_cast<std::uint32_t>(std::sqrt(triangles / 12)));
      } else {
        v1::Transaction one;
        do {
          one = usual_.next(scene);
        } while (usual_.streams());
        operation = one.operations(0);
        if (kind == 3) enlarge(operation, store, triangles);
      }
    }
    return transaction;
  }

  void enlarge(v1::Operation& operation, AssetStore& store, double most) {
    if (operation.has_add()) enlarge(*operation.mutable_add()->mutable_mesh(), store, most);
    if (operation.has_remesh()) enlarge(*operation.mutable_remesh()->mutable_mesh(), store, most);
    v1::Material* material = operation.has_add()            ? operation.mutable_add()->mutable_material()
                             : operation.has_set_material() ? operation.mutable_set_material()->mutable_material()
                                                            : nullptr;
    if (material != nullptr) enlarge(*material);
    v1::Deformation* deformation = operation.has_add() ? operation.mutable_add()->mutable_deformation()
                                   : operation.has_set_deformation()
                                       ? operation.mutable_set_deformation()->mutable_deformation()
                                       : nullptr;
    if (deformation != nullptr && random_.chance(0.3)) enlarge(*deformation->mutable_lattice());
  }

  void enlarge(v1::MeshSource& mesh, AssetStore& store, double most) {
    const double triangles = spread(12, random_.chance(0.03) ? 8 * most : most);
    const auto side = static_cast<std::uint32_t>(std::clamp(std::sqrt(triangles / 12), 1.0, 1024.0));
    if (mesh.has_box()) mesh.mutable_box()->set_segments(side);
    if (mesh.has_sphere()) mesh.mutable_sphere()->set_segments(side);
    if (mesh.has_cylinder()) mesh.mutable_cylinder()->set_segments(count(3, 1024));
    if (mesh.has_torus()) {
      mesh.mutable_torus()->set_major_segments(std::max(3U, side));
      mesh.mutable_torus()->set_minor_segments(count(3, 1024));
    }
    if (random_.chance(0.15)) {
      if (auto asset = soup(store)) {
        mesh.set_asset(asset->name.hash.asBytes());
        held_.push_back(std::move(asset));
      }
    }
    if (random_.chance(0.2)) mesh.mutable_simplify()->set_error(spread(0.01, 10));
  }

  void enlarge(v1::Material& material) {
    if (material.has_texture()) enlarge(*material.mutable_texture()->mutable_field());
    if (material.has_stiffness_over()) enlarge(*material.mutable_stiffness_over()->mutable_field());
  }

  void enlarge(v1::ScalarField& field) {
    if (field.has_grown()) field.mutable_grown()->mutable_reaction_diffusion()->set_wavelength_m(spread(3e-4, 0.05));
    if (field.has_noise()) field.mutable_noise()->set_octaves(count(1, 12));
    if (!field.has_mapped()) return;
    v1::MappedField& mapped = *field.mutable_mapped();
    const std::uint32_t cells = count(2, 33), resolution = std::max(8 * cells, count(32, 1025));
    if (mapped.has_reaction_diffusion()) {
      mapped.mutable_reaction_diffusion()->set_cells(cells);
      mapped.mutable_reaction_diffusion()->set_resolution(resolution);
    } else {
      mapped.mutable_spot_noise()->set_cells(cells);
      mapped.mutable_spot_noise()->set_resolution(resolution);
      mapped.mutable_spot_noise()->set_elongation(spread(1, 8));
    }
  }

  /// Bends, and folds where it bends much.
  void enlarge(v1::Lattice& lattice) {
    lattice.Clear();
    constexpr double kHalf_m = 0.12;
    const std::array points{count(2, 9), count(2, 9), count(2, 9)};
    lattice.set_points_x(points[0]);
    lattice.set_points_y(points[1]);
    lattice.set_points_z(points[2]);
    v1::Vector3 &low = *lattice.mutable_low_m(), &size = *lattice.mutable_size_m();
    low.set_x(-kHalf_m), low.set_y(-kHalf_m), low.set_z(-kHalf_m);
    size.set_x(2 * kHalf_m), size.set_y(2 * kHalf_m), size.set_z(2 * kHalf_m);
    const double bend_m = spread(1e-4, 0.3);
    for (std::uint32_t i = 0; i < points[0] * points[1] * points[2]; ++i) {
      const std::array at{i % points[0], i / points[0] % points[1], i / points[0] / points[1]};
      for (std::size_t k = 0; k < 3; ++k)
        lattice.add_control_m(
            static_cast<float>(kHalf_m * (2.0 * at[k] / (points[k] - 1) - 1) + random_.between(-bend_m, bend_m)));
    }
  }

  /// Triangles of any length that pass through each other. Null: none are left.
  [[nodiscard]] std::shared_ptr<const MeshAsset> soup(AssetStore& store) {
    const double size_m = 0.05, length_m = spread(1e-3, 0.1);
    std::vector<Vec3> vertices;
    std::vector<TriangleIndices> triangles;
    const std::uint32_t many = count(1, 1e5);
    for (std::uint32_t t = 0; t < many; ++t) {
      const Vec3 a = size_m * random_.direction();
      vertices.insert(vertices.end(), {a, a + length_m * random_.direction(), a + length_m * random_.direction()});
      triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    auto mesh = canonicalise(vertices, std::move(triangles), {});
    return mesh && !mesh->mesh.triangles.empty() ? store.intern(std::move(mesh->mesh)) : nullptr;
  }

  Random random_;
  RandomEdits usual_;
  std::vector<std::shared_ptr<const Asset>> held_;
};

double secondsOf(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// Of this process.
double ownTime_s() {
  timespec own{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &own);
  return static_cast<double>(own.tv_sec) + 1e-9 * static_cast<double>(own.tv_nsec);
}

/// And of those that it has waited for.
double processorTime_s() {
  rusage children{};
  getrusage(RUSAGE_CHILDREN, &children);
  return ownTime_s() + secondsOf(children.ru_utime) + secondsOf(children.ru_stime);
}

/// A line of /proc/.../status, bytes; 0: there is none.
double bytesOf(const std::string& process, const std::string& what) {
  std::ifstream file("/proc/" + process + "/status");
  for (std::string word; file >> word;) {
    if (word != what) continue;
    double kilobytes = 0;
    file >> kilobytes;
    return 1024 * kilobytes;
  }
  return 0;
}

/// The most memory that this process takes more than at its beginning, or that one of its children takes.
class MemoryWatch {
 public:
  MemoryWatch() {
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << 5;  // the high-water mark anew
    before_bytes_ = bytesOf("self", "VmRSS:");
  }
  [[nodiscard]] double most_bytes() {
    done_ = true;
    thread_.join();
    return std::max(bytesOf("self", "VmHWM:") - before_bytes_, children_bytes_);
  }

 private:
  void look() {
    const std::string list = "/proc/self/task/" + std::to_string(asker_) + "/children";
    for (; !done_; std::this_thread::sleep_for(std::chrono::milliseconds(2))) {
      std::ifstream children(list);
      for (std::string child; children >> child;) children_bytes_ = std::max(children_bytes_, bytesOf(child, "VmHWM:"));
    }
  }

  const pid_t asker_ = gettid();
  double before_bytes_ = 0, children_bytes_ = 0;
  std::atomic<bool> done_ = false;
  std::thread thread_{[this] { look(); }};
};

/// How many times slower than a quiet one this processor is at present; 1: no less. By work like that of the edits.
class Slowness {
 public:
  [[nodiscard]] double now() const {
    timespec before{}, after{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &before);
    static_cast<void>(buildCollisionMesh(sphere_.vertices, sphere_.triangles, 1));
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &after);
    const double took_s =
        static_cast<double>(after.tv_sec - before.tv_sec) + 1e-9 * static_cast<double>(after.tv_nsec - before.tv_nsec);
    return std::max(1.0, took_s / kQuiet_s);
  }

 private:
  static constexpr double kQuiet_s = 0.0133;
  const TriMesh sphere_ = makeSphere(0.05, 48).value();
};

struct PricedEdit {
  std::string what;
  Price price;
  double time_s = 0, memory_bytes = 0;
  double end_s = 0;  ///< From its cancellation to its end; 0: it was not cancelled.
  bool accepted = false, tooDear = false;

  [[nodiscard]] std::string failure() const {
    if (end_s > kEnd_s) return "when it was cancelled it went on";
    if (tooDear) return time_s > kRefusal_s ? "to refuse it took long" : "";
    if (accepted && time_s > kMostTime_s) return "it took more time than any edit may";
    if (accepted && memory_bytes > kMostMemory_bytes) return "it took more memory than any edit may";
    if (time_s > price.time_s) return "it took longer than its price";
    return memory_bytes > price.memory_bytes() ? "it took more memory than its price" : "";
  }
};

std::string textOf(const v1::Transaction& transaction) {
  std::string text = std::to_string(transaction.operations_size()) + " x " +
                     transaction.operations(0).ShortDebugString().substr(0, 1500);
  std::ranges::replace(text, ',', ';');
  std::ranges::replace(text, '"', '\'');
  return text;
}

/// Begins it, and asks for its end by and by.
/// @return How long it then went on; 0: it had been decided.
double cancel(SceneService& scenes, std::uint64_t number, const Transaction& transaction, double after_s,
              const SceneService::EditReply& reply) {
  std::stop_source unwanted;
  if (!scenes.submitEdit(kEditor, number, transaction, reply, unwanted.get_token())) return 0;
  using Clock = std::chrono::steady_clock;
  Clock::time_point asked;
  double asked_s = 0;
  const std::jthread asker([&](const std::stop_token& done) {
    const double from_s = ownTime_s();
    while (!done.stop_requested() && ownTime_s() - from_s < after_s)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    asked = Clock::now();
    asked_s = ownTime_s();
    unwanted.request_stop();
  });
  scenes.executeAll();
  const double ended_s = ownTime_s();
  const Clock::time_point ended = Clock::now();
  if (!unwanted.stop_requested()) return 0;
  // In a process that waits for a processor the one is too long, in one of two threads the other.
  return std::min(std::chrono::duration<double>(ended - asked).count(), ended_s - asked_s);
}

/// A scene service in virtual time, without a servo.
std::vector<PricedEdit> editsOf(std::uint64_t seed) {
  SceneMailbox mailbox;
  SceneService scenes({.assetFolders = {}, .makePlan = {}, .log = {}, .now_ns = [] { return std::uint64_t{0}; }},
                      mailbox);
  EditsOfAnySize edits(seed);
  Random random(seed);
  const Slowness slowness;
  std::vector<PricedEdit> all;
  for (int i = 1; i <= kEditsOfWorld; ++i) {
    const v1::Transaction wire = edits.next(scenes.history()->version, scenes.assetStore());
    auto transaction = fromWire(wire);
    if (!transaction) continue;
    const auto price = scenes.priceOf(*transaction);
    if (!price) continue;
    PricedEdit edit{.what = textOf(wire), .price = *price};
    const auto answer = [&edit](const EditOutcome& outcome) {
      edit.accepted = std::holds_alternative<std::shared_ptr<const AcceptedEdit>>(outcome);
      const auto* error = std::get_if<Error>(&outcome);
      edit.tooDear = error != nullptr && error->reason.starts_with("take up to ");
    };
    const auto number = static_cast<std::uint64_t>(i);
    double slow = slowness.now();
    bool decided = false;
    const auto note = [&](const EditOutcome& outcome) {
      decided = true;
      answer(outcome);
    };
    MemoryWatch memory;
    double before_s = processorTime_s();
    if (price->time_s > kWorthCancelling_s && random.chance(1.0 / 3))
      edit.end_s = cancel(scenes, number, *transaction, random.between(0, price->time_s / 4), note) / slow;
    if (!decided) {
      before_s = processorTime_s();
      if (!scenes.submitEdit(kEditor, number, *std::move(transaction), answer)) continue;
      scenes.executeAll();
    }
    edit.time_s = processorTime_s() - before_s;
    edit.memory_bytes = memory.most_bytes();
    slow = std::max(slow, slowness.now());
    edit.time_s /= slow;
    static_cast<void>(mailbox.newest());
    all.push_back(std::move(edit));
  }
  return all;
}

/// What a busy machine adds to one run it seldom adds to the next.
void takeLess(std::vector<PricedEdit>& edits, const std::vector<PricedEdit>& again) {
  for (std::size_t i = 0; i < std::min(edits.size(), again.size()); ++i) {
    edits[i].time_s = std::min(edits[i].time_s, again[i].time_s);
    edits[i].memory_bytes = std::min(edits[i].memory_bytes, again[i].memory_bytes);
    edits[i].end_s = std::min(edits[i].end_s, again[i].end_s);
  }
}

}  // namespace

bool runFuzzPrices(const FuzzOptions& options, const std::filesystem::path& out) {
  Interruption interruption;
  makeFolder(out);
  std::ofstream table(out / "prices.csv");
  table << "seed,accepted,too_dear,price_s,took_s,price_MB,took_MB,end_s,what\n";
  std::vector<Record> findings;
  std::uint64_t done = 0, edits = 0, accepted = 0, tooDear = 0, longOnes = 0, within = 0;
  double longest_s = 0, most_MB = 0, longestEnd_s = 0;
  std::uint64_t cancelled = 0;
  for (; done < options.scenes && !interruption.came(); ++done) {
    const std::uint64_t seed = options.seed + done;
    std::vector<PricedEdit> world = editsOf(seed);
    const auto failed = [&world] {
      return std::ranges::any_of(world, [](const auto& e) { return !e.failure().empty(); });
    };
    for (int again = 0; again < 2 && failed(); ++again) takeLess(world, editsOf(seed));
    for (const PricedEdit& edit : world) {
      ++edits;
      accepted += edit.accepted ? 1 : 0;
      tooDear += edit.tooDear ? 1 : 0;
      longest_s = std::max(longest_s, edit.time_s);
      most_MB = std::max(most_MB, 1e-6 * edit.memory_bytes);
      cancelled += edit.end_s > 0 ? 1 : 0;
      longestEnd_s = std::max(longestEnd_s, edit.end_s);
      if (edit.accepted && edit.time_s > kLong_s) {
        ++longOnes;
        within += edit.price.time_s <= kMostTimes * edit.time_s ? 1 : 0;
      }
      table << seed << ',' << edit.accepted << ',' << edit.tooDear << ',' << edit.price.time_s << ',' << edit.time_s
            << ',' << 1e-6 * edit.price.memory_bytes() << ',' << 1e-6 * edit.memory_bytes << ',' << edit.end_s << ','
            << edit.what << std::endl;
      if (const std::string failure = edit.failure(); !failure.empty()) {
        findings.push_back({{"fuzz", "prices"},
                            {"seed", seed},
                            {"failure", failure},
                            {"price_s", edit.price.time_s},
                            {"took_s", edit.time_s},
                            {"price_MB", 1e-6 * edit.price.memory_bytes()},
                            {"took_MB", 1e-6 * edit.memory_bytes},
                            {"end_s", edit.end_s},
                            {"edit", edit.what},
                            {"pass", false}});
        showFinding(findings.back());
      }
    }
    showProgress(done + 1, options.scenes, kWorldsToALine, findings.size());
  }
  const double share = longOnes > 0 ? static_cast<double>(within) / static_cast<double>(longOnes) : 1;
  const bool good = findings.empty() && (longOnes < kMany || share >= kShare);
  std::vector<Record> records{{{"fuzz", "prices"},
                               {"seed", options.seed},
                               {"worlds", done},
                               {"edits", edits},
                               {"accepted", accepted},
                               {"too_dear", tooDear},
                               {"longest_s", longest_s},
                               {"most_MB", most_MB},
                               {"cancelled", cancelled},
                               {"longest_end_s", longestEnd_s},
                               {"above_0_1_s", longOnes},
                               {"share_of_them_within_10_times", share},
                               {"failed", findings.size()},
                               {"pass", good}}};
  std::printf("%s\n", measuresText(records.back()).c_str());
  records.insert(records.end(), findings.begin(), findings.end());
  writeRecords(out, "fuzz", records);
  if (interruption.came()) std::printf("interrupted: this is what was found by then\n");
  return good;
}

}  // namespace haptics::eval
