#include "tests/eval/table1/table1.h"

#include <chrono>
#include <cstdio>
#include <ctime>
#include <span>
#include <thread>

#include "tests/eval/figure/virtual_display.h"
#include "tests/eval/report.h"
#include "tests/eval/statistics.h"
#include "tests/eval/table1/flat_out_server.h"
#include "tests/eval/table1/paper_objects.h"
#include "tests/eval/table1/viewer_process.h"

namespace haptics::eval {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kLeastRatio = 0.9;          // of 64,800 polygons to 12
constexpr double kLeastContactShare = 0.98;  // the recording's own is 0.99
constexpr std::size_t kTurns = 10;
constexpr std::size_t kTakingTurns = 4;    // the paper's objects; larger ones take minutes to send and draw
constexpr double kViewerPatience_s = 300;  // 10 million triangles

/// Of one object, turn by turn.
struct Rates {
  Statistics complete_kHz;   ///< On the wall's clock.
  Statistics processor_kHz;  ///< On the servo thread's own.
  Statistics bare_kHz;
  Statistics ratio;  ///< Of the latter, to the first object's in the same turn.
  double contactTicks = 0;
  double ticks = 0;
  bool viewerHeld = true;
};

double secondsSince(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// One turn of the complete step.
void measureComplete(FlatOutServer& server, ViewerProcess& viewer, const TriMesh& mesh, double seconds, Rates& rates) {
  constexpr std::chrono::milliseconds kSettle{100};
  rates.viewerHeld = viewer.holds(server.show(mesh), kViewerPatience_s) && rates.viewerHeld;
  std::this_thread::sleep_for(kSettle);
  const ServoStatistics& statistics = server.statistics();
  const Clock::time_point begin = Clock::now();
  const double processorBefore_s = server.processorTime_s();
  const auto ticksBefore = static_cast<double>(statistics.ticks);
  const auto contactBefore = static_cast<double>(statistics.contactTicks);
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  const double ticks = static_cast<double>(statistics.ticks) - ticksBefore;
  rates.complete_kHz.add(ticks / secondsSince(begin) * 1e-3);
  rates.processor_kHz.add(ticks / (server.processorTime_s() - processorBefore_s) * 1e-3);
  rates.ticks += ticks;
  rates.contactTicks += static_cast<double>(statistics.contactTicks) - contactBefore;
}

double threadTime_s() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

/// The contact alone over the same recording, on this thread's own clock.
double bareRate_kHz(const Surface& surface, const std::vector<Vec3>& places, double seconds) {
  Body body;
  body.surface = &surface;
  body.update();
  ContactState state;
  place(state, places.front());
  const double begin_s = threadTime_s();
  double ticks = 0;
  while (threadTime_s() - begin_s < seconds) {
    for (const Vec3 hip : places) (void)followContact({&body, 1}, state, hip);
    ticks += static_cast<double>(places.size());
  }
  return ticks / (threadTime_s() - begin_s) * 1e-3;
}

/// Contact held, and the viewer proved each time that it held the same scene.
bool wasMeasured(const Rates& rates) {
  return rates.viewerHeld && rates.contactTicks >= kLeastContactShare * rates.ticks;
}

Record describe(const TableObject& object, Rates& rates, double viewer_Hz) {
  const MeshCounts counts = countsOf(object.mesh);
  Record record{{"method", "ours"},      {"scene", object.name},        {"vertices", counts.vertices},
                {"lines", counts.lines}, {"polygons", counts.polygons}, {"boundary_lines", counts.boundaryLines}};
  if (object.paperLow_kHz > 0) {
    record["paper_rate_low_kHz"] = object.paperLow_kHz;
    record["paper_rate_high_kHz"] = object.paperHigh_kHz;
  }
  record["complete_step_rate_kHz"] = rates.complete_kHz.quantile(0.5);
  record["complete_step_rate_per_processor_s_kHz"] = rates.processor_kHz.quantile(0.5);
  record["complete_step_to_12_polygons_ratio"] = rates.ratio.quantile(0.5);
  record["bare_step_rate_kHz"] = rates.bare_kHz.quantile(0.5);
  record["contact_ticks_ratio"] = rates.contactTicks / rates.ticks;
  record["ticks"] = rates.ticks;
  record["viewer_held_the_scene"] = rates.viewerHeld;
  record["viewer_frames_per_s"] = viewer_Hz;
  const bool judged = counts.polygons == 64'800;
  record["pass"] = wasMeasured(rates) && (!judged || rates.ratio.quantile(0.5) >= kLeastRatio);
  return record;
}

void print(const std::vector<Record>& records) {
  std::printf("%-20s %9s %9s %9s  %10s  %15s  %17s  %5s  %9s\n", "", "vertices", "lines", "polygons", "paper, kHz",
              "whole step, kHz", "same on own clock", "ratio", "bare, kHz");
  for (const Record& r : records) {
    char paper[32] = "";
    if (r.contains("paper_rate_low_kHz")) {
      std::snprintf(paper, sizeof paper, "%g to %g", r["paper_rate_low_kHz"].get<double>(),
                    r["paper_rate_high_kHz"].get<double>());
    }
    std::printf("%-20s %9d %9d %9d  %10s  %15.0f  %17.0f  %5.3f  %9.0f%s\n", r["scene"].get<std::string>().c_str(),
                r["vertices"].get<int>(), r["lines"].get<int>(), r["polygons"].get<int>(), paper,
                r["complete_step_rate_kHz"].get<double>(), r["complete_step_rate_per_processor_s_kHz"].get<double>(),
                r["complete_step_to_12_polygons_ratio"].get<double>(), r["bare_step_rate_kHz"].get<double>(),
                r["pass"].get<bool>() ? "" : "  FAIL");
  }
}

}  // namespace

bool runTable1(const Table1Options& options) {
  std::error_code ignored;  // what matters is whether the result can be written
  std::filesystem::create_directories(options.out, ignored);
  const auto display = VirtualDisplay::ensure();
  if (!display) throw std::runtime_error(display.error().text());
  const std::vector<TableObject> objects = tableObjects(options.finest);
  std::vector<Rates> rates(objects.size());

  FlatOutServer server(objects.front().mesh);
  ViewerProcess viewer(server.port(), options.out / "table1_viewer.json");
  if (!viewer.holds(server.revision(), kViewerPatience_s)) throw std::runtime_error("the viewer did not connect");
  const auto take = [&](std::size_t i, double seconds) {
    measureComplete(server, viewer, objects[i].mesh, seconds, rates[i]);
    rates[i].ratio.add(rates[i].processor_kHz.last() / rates.front().processor_kHz.last());
  };
  for (int run = 0; run < options.runs; ++run) {
    for (std::size_t turn = 0; turn < kTurns; ++turn) {
      for (std::size_t i = 0; i < kTakingTurns; ++i) take(i, options.seconds / kTurns);
    }
    for (std::size_t i = kTakingTurns; i < objects.size(); ++i) take(i, options.seconds);
  }
  server.stop();
  std::vector<std::shared_ptr<const Surface>> surfaces;
  for (const TableObject& object : objects)
    surfaces.push_back(buildSurface(object.mesh.vertices, object.mesh.triangles));
  for (std::size_t turn = 0; turn < kTurns; ++turn) {
    for (std::size_t i = 0; i < objects.size(); ++i) {
      rates[i].bare_kHz.add(bareRate_kHz(*surfaces[i], server.hand().places(), options.seconds / kTurns / 10));
    }
  }
  const double viewer_Hz = viewer.finish();
  std::vector<Record> records;
  bool good = true;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    records.push_back(describe(objects[i], rates[i], viewer_Hz));
    good = good && wasMeasured(rates[i]);
  }
  print(records);
  writeRecords(options.out, "table1", records);
  return good;
}

}  // namespace haptics::eval
