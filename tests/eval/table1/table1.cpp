#include "tests/eval/table1/table1.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "haptic_server/engine/contact/fast_path/contact_cache.h"
#include "tests/eval/figure/virtual_display.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/table1/flat_out_server.h"
#include "tests/eval/table1/interruption.h"
#include "tests/eval/table1/rates.h"
#include "tests/eval/table1/viewer_process.h"
#include "tests/eval/timing.h"

namespace haptics::eval {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kTakingTurns = 4;    // the paper's objects; larger ones take minutes to send and draw
constexpr double kViewerPatience_s = 300;  // 10 million triangles

double secondsSince(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// Turns of short blocks, so that what else the machine does falls on all alike.
std::size_t turnsIn(double seconds) {
  constexpr double kLongestBlock_s = 2;
  constexpr double kFewest = 10;
  return static_cast<std::size_t>(std::max(kFewest, std::ceil(seconds / kLongestBlock_s)));
}

/// The contact alone over the same recording, on this thread's own clock.
double bareRate_kHz(const CollisionMesh& surface, const std::vector<Vec3>& places, double seconds) {
  Body body;
  body.surface = &surface;
  body.update();
  ContactState state;
  ContactCache cache;
  resetContact(state, places.front());
  const double begin_s = threadTime_s();
  double ticks = 0;
  while (threadTime_s() - begin_s < seconds) {
    for (const Vec3 hip : places) (void)followContact({&body, 1}, state, hip, cache);
    ticks += static_cast<double>(places.size());
  }
  return ticks / (threadTime_s() - begin_s) * 1e-3;
}

/// The objects, the server that shows them in turn, and the viewer.
class Table1 {
 public:
  explicit Table1(const Table1Options& options)
      : options_(options),
        objects_(tableObjects(options.finest)),
        rates_(objects_.size()),
        turns_(turnsIn(options.seconds)),
        server_(objects_.front().mesh),
        viewer_(server_.port(), options.out / "table1_viewer.json") {
    if (!viewer_.holds(server_.revision(), kViewerPatience_s)) throw std::runtime_error("the viewer did not connect");
  }

  void measureComplete() {
    const std::size_t last = objects_.size();
    for (int run = 0; run < options_.runs && !interruption_.came(); ++run) {
      for (std::size_t turn = 0; turn < turns_ && !interruption_.came(); ++turn) {
        takeTurn(turn % 2 == 0);
        write();
        tell(run, turn);
      }
      for (std::size_t i = kTakingTurns; i < last && !interruption_.came(); ++i) {
        std::fprintf(stderr, "%s ...\n", objects_[i].name.data());
        if (!measureBlock(i, options_.seconds)) break;
        rates_[i].ratio.add(rates_[i].processor_kHz.last() / rates_.front().processor_kHz.last());
        write();
      }
    }
    server_.stop();
  }

  void measureBare() {
    constexpr double kPart = 0.1;  // of the time for the complete step
    std::vector<std::shared_ptr<const CollisionMesh>> surfaces;
    for (std::size_t i = 0; i < objects_.size() && !interruption_.came(); ++i)
      surfaces.push_back(buildCollisionMesh(objects_[i].mesh.vertices, objects_[i].mesh.triangles));
    for (std::size_t turn = 0; turn < turns_ && !interruption_.came(); ++turn) {
      for (std::size_t i = 0; i < objects_.size(); ++i) {
        const double seconds = kPart * options_.seconds / static_cast<double>(turns_);
        rates_[i].bare_kHz.add(bareRate_kHz(*surfaces[i], server_.hand().places(), seconds));
        rates_[i].bareRatio.add(rates_[i].bare_kHz.last() / rates_.front().bare_kHz.last());
      }
    }
  }

  /// Ends the viewer, prints. Returns whether all was measured.
  bool finish() {
    const bool complete = !interruption_.came();
    const std::vector<Record> records = write({viewer_.finish(), complete});
    printTable(records);
    if (!complete) std::printf("interrupted: this is what was measured by then\n");
    return complete && std::ranges::all_of(rates_, &Rates::measured);
  }

 private:
  /// The paper's objects, every other time from the last to the first: what drifts cancels.
  void takeTurn(bool forward) {
    const double seconds = options_.seconds / static_cast<double>(turns_);
    for (std::size_t k = 0; k < kTakingTurns; ++k) {
      if (!measureBlock(forward ? k : kTakingTurns - 1 - k, seconds)) return;
    }
    for (std::size_t i = 0; i < kTakingTurns; ++i)
      rates_[i].ratio.add(rates_[i].processor_kHz.last() / rates_.front().processor_kHz.last());
  }

  /// One block of the complete step. False when it was interrupted: it does not count.
  bool measureBlock(std::size_t object, double seconds) {
    constexpr double kSettle_s = 0.02;
    const bool held = viewer_.holds(server_.show(objects_[object].mesh), kViewerPatience_s);
    interruption_.sleep(kSettle_s);
    const ServoStatistics& statistics = server_.statistics();
    const Clock::time_point begin = Clock::now();
    const double processorBefore_s = server_.processorTime_s();
    const auto ticksBefore = static_cast<double>(statistics.ticks);
    const auto contactBefore = static_cast<double>(server_.handStatistics().contactTicks);
    constexpr double kOwnPart =
        0.25;  // of the time: on a busy machine the servo's thread may have none of a short block
    do {
      interruption_.sleep(seconds);
    } while (!interruption_.came() && server_.processorTime_s() - processorBefore_s < kOwnPart * seconds);
    const double ticks = static_cast<double>(statistics.ticks) - ticksBefore;
    if (interruption_.came()) return false;
    Rates& rates = rates_[object];
    rates.viewerHeld = rates.viewerHeld && held;
    rates.complete_kHz.add(ticks / secondsSince(begin) * 1e-3);
    rates.processor_kHz.add(ticks / (server_.processorTime_s() - processorBefore_s) * 1e-3);
    rates.ticks += ticks;
    rates.contactTicks += static_cast<double>(server_.handStatistics().contactTicks) - contactBefore;
    return true;
  }

  /// What there is so far, so that it is kept whatever ends the program.
  std::vector<Record> write(const Table1Run& run = {.complete = false}) {
    std::vector<Record> records;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      if (rates_[i].begun()) records.push_back(describe(objects_[i], rates_[i], run));
    }
    writeRecords(options_.out, "table1", records);
    return records;
  }

  void tell(int run, std::size_t turn) {
    std::fprintf(stderr, "run %d of %d, turn %zu of %zu: rate at 64,800 polygons %.3f of that at 12\n", run + 1,
                 options_.runs, turn + 1, turns_, rates_[kTakingTurns - 1].ratio.quantile(0.5));
  }

  Table1Options options_;
  Interruption interruption_;
  std::vector<TableObject> objects_;
  std::vector<Rates> rates_;
  std::size_t turns_;
  FlatOutServer server_;
  ViewerProcess viewer_;
};

}  // namespace

bool runTable1(const Table1Options& options) {
  const auto display = orThrow(VirtualDisplay::ensure());
  Table1 table(options);
  table.measureComplete();
  table.measureBare();
  return table.finish();
}

}  // namespace haptics::eval
