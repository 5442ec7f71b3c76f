#include "tests/eval/worst/import_hunt.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

#include "common/mesh/import.h"
#include "tests/eval/random.h"
#include "tests/eval/report.h"
#include "tests/eval/table1/interruption.h"
#include "tests/eval/timing.h"
#include "tests/eval/worst/growth_picture.h"
#include "tests/eval/worst/import_families.h"
#include "tests/eval/worst/mesh_writer.h"

namespace haptics::eval {
namespace {

constexpr int kHunted = 8192;  ///< Triangles: of files that are hunted.
/// Of those of which growth is measured. Smaller ones take what any file may, however small it is (work.h).
constexpr std::array kSizes{8192, 16'384, 32'768, 65'536};
/// Rounds over the families, of which the shortest time of each size counts: a busy machine only adds to a time. Those after
/// the first are of the families that exceed a limit; what else the machine does has passed by then.
constexpr int kMaxRounds = 48;

using ImportGenes = std::array<double, ImportFamily::kGenes>;

struct Import {
  double triangles = 0;
  double s = 0;
  std::string report;  ///< Or why it was refused.
};

Import import(const MeshFile& file, int triangles) {
  const double begin_s = threadTime_s();
  const auto imported = importMesh(file.bytes, file.format, {});
  const double s = threadTime_s() - begin_s;
  return {imported ? static_cast<double>(imported->report.trianglesInFile) : triangles, s,
          imported ? imported->report.text() : imported.error().reason};
}

/// One of each size, beside which a family's files are measured.
const std::array<MeshFile, kSizes.size()>& sphereFiles() {
  static const auto kFiles = [] {
    std::array<MeshFile, kSizes.size()> files;
    std::ranges::transform(kSizes, files.begin(), [](int triangles) {
      return fileOf(shapes::sphere(1, static_cast<int>(std::lround(std::sqrt(triangles / 12.0)))), 0);
    });
    return files;
  }();
  return kFiles;
}

/// One family's hunt.
class ImportHunt {
 public:
  ImportHunt(const ImportFamily& family, std::uint64_t seed)
      : family_(family), random_(seed * 1000 + static_cast<std::uint64_t>(&family - importFamilies().data())) {
    growth_.name = family.name;
  }

  [[nodiscard]] double spent_s() const { return spent_s_; }
  [[nodiscard]] double worst_s() const { return worst_s_; }

  void importOneMore() {
    const double begin_s = threadTime_s();
    const ImportGenes genes = files_ == 0 || random_.below(4) == 0 ? some() : changed(worst_);
    const Import imported = import(family_.make(genes, kHunted), kHunted);
    const double s = imported.s / imported.triangles * 1e5;
    if (s > worst_s_ || files_ == 0) {
      worst_s_ = s;
      worst_ = genes;
    }
    ++files_;
    spent_s_ += threadTime_s() - begin_s;
  }
  void take(const ImportGenes& kept) { worst_ = kept; }

  /// The worst file of every size once more.
  void measureOneMore() {
    for (std::size_t i = 0; i < kSizes.size(); ++i) {
      const Import imported = import(family_.make(worst_, kSizes[i]), kSizes[i]);
      const Import ordinary = import(sphereFiles()[i], kSizes[i]);
      if (rounds_ == 0) growth_.points.push_back({imported.triangles, imported.s, ordinary.s});
      Growth::Point& least = growth_.points[i];
      least.s = std::min(least.s, imported.s);
      least.ordinary_s = std::min(least.ordinary_s, ordinary.s);
      report_ = imported.report;
    }
    ++rounds_;
  }
  [[nodiscard]] bool within() const { return growth_.most_s() <= kWorstImport_s && growth_.exponent() <= kWorstGrowth; }
  [[nodiscard]] const Growth& growth() const { return growth_; }

  [[nodiscard]] Record record() const {
    std::vector<double> triangles, times_s, ordinary_s;
    for (const auto& point : growth_.points) {
      triangles.push_back(point.triangles);
      times_s.push_back(point.s);
      ordinary_s.push_back(point.ordinary_s);
    }
    return {{"family", family_.name},
            {"files", files_},
            {"triangles", triangles},
            {"import_s", times_s},
            {"sphere_s", ordinary_s},
            {"rounds", rounds_},
            {"most_s_per_100k", growth_.most_s()},
            {"exponent", growth_.exponent()},
            {"pass", within()},
            {"report", report_},
            {"genes", worst_}};
  }

 private:
  [[nodiscard]] ImportGenes some() {
    ImportGenes genes;
    for (double& gene : genes) gene = random_.between(0, 1);
    return genes;
  }
  [[nodiscard]] ImportGenes changed(ImportGenes genes) {
    double& gene = genes[static_cast<std::size_t>(random_.below(ImportFamily::kGenes))];
    const double to = random_.below(3) == 0 ? random_.between(0, 1) : gene + random_.between(-0.1, 0.1);
    gene = to - std::floor(to);
    return genes;
  }

  const ImportFamily& family_;
  Random random_;
  ImportGenes worst_{};
  double worst_s_ = 0;  ///< For 100,000 triangles.
  int files_ = 0;
  double spent_s_ = 0;
  Growth growth_;
  int rounds_ = 0;
  std::string report_;
};

std::vector<ImportHunt> huntsOf(const WorstOptions& options) {
  std::vector<ImportHunt> hunts;
  if (!options.kept.empty()) {
    for (const Record& record : readRecords(options.kept)) {
      hunts.emplace_back(findImportFamily(record.at("family").get<std::string>()), options.seed);
      hunts.back().take(record.at("genes").get<ImportGenes>());
    }
  } else if (!options.family.empty()) {
    hunts.emplace_back(findImportFamily(options.family), options.seed);
  } else {
    for (const ImportFamily& family : importFamilies()) hunts.emplace_back(family, options.seed);
  }
  return hunts;
}

void hunt(std::vector<ImportHunt>& hunts, double seconds) {
  const Interruption interruption;
  const auto begin = std::chrono::steady_clock::now();
  double told_s = 0;
  while (!interruption.came()) {
    const double now_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (now_s >= seconds) break;
    if (now_s - told_s >= 10) {
      told_s = now_s;
      const double worst_s = std::ranges::max_element(hunts, {}, &ImportHunt::worst_s)->worst_s();
      std::fprintf(stderr, "%.0f of %.0f s: the slowest import so far takes %.2f s for 100,000 triangles\n", now_s,
                   seconds, worst_s);
    }
    std::ranges::min_element(hunts, {}, &ImportHunt::spent_s)->importOneMore();
  }
}

void print(const Record& record) {
  std::printf("%-11s %6.2f s for 100,000 triangles, grows with %.2f  %s\n", record["family"].get<std::string>().c_str(),
              record["most_s_per_100k"].get<double>(), record["exponent"].get<double>(),
              record["pass"].get<bool>() ? "within" : "BEYOND");
  std::fflush(stdout);
}

}  // namespace

bool runWorstImport(const WorstOptions& options) {
  std::vector<ImportHunt> hunts = huntsOf(options);
  if (options.kept.empty()) hunt(hunts, options.seconds);
  for (int round = 0; round < kMaxRounds; ++round) {
    for (ImportHunt& one : hunts) {
      if (round == 0 || !one.within()) one.measureOneMore();
    }
  }
  std::vector<Record> records;
  std::vector<Growth> growths;
  for (const ImportHunt& one : hunts) {
    records.push_back(one.record());
    growths.push_back(one.growth());
    print(records.back());
  }
  writeRecords(options.out, "worst_import", records);
  if (options.kept.empty()) drawGrowth(growths, kWorstImport_s, options.out);
  return std::ranges::all_of(records, [](const Record& record) { return record["pass"].get<bool>(); });
}

}  // namespace haptics::eval
