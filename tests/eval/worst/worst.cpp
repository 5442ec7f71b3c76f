#include "tests/eval/worst/worst.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <memory>
#include <stdexcept>

#include "tests/eval/random.h"
#include "tests/eval/report.h"
#include "tests/eval/statistics.h"
#include "tests/eval/table1/interruption.h"
#include "tests/eval/worst/play.h"
#include "tests/eval/worst/tail_picture.h"

namespace haptics::eval {
namespace {

constexpr int kTicks = 500;  ///< Of a play.

/// The worst tick of a genome.
struct Found {
  Genome genome;
  int tick = 0;
  double ns = 0;  ///< Of the shortest of some runs.
};

/// One family's hunt.
class Hunt {
 public:
  Hunt(const Family& family, std::uint64_t seed, const Play::Settings& settings)
      : family_(family),
        random_(seed * 1000 + static_cast<std::uint64_t>(&family - families().data())),
        settings_(settings) {}

  [[nodiscard]] double worst_ns() const { return worst_.ns; }

  /// One more genome.
  void goOn() {
    Found found{plays_ == 0 || random_.below(4) == 0 ? someGenome() : changed(worst_.genome)};
    measure(found);
    if (found.ns > worst_.ns) worst_ = found;
    ++plays_;
  }

  [[nodiscard]] std::shared_ptr<const ServoScene> sceneOf(const Genome& genome) {
    for (const auto& [genes, scene] : scenes_) {
      if (genes == genome.scene) return scene;
    }
    constexpr std::size_t kKept = 4;
    if (scenes_.size() == kKept) scenes_.pop_front();
    scenes_.emplace_back(genome.scene, family_.make(genome.scene));
    return scenes_.back().second;
  }

  [[nodiscard]] Record record() {
    const Play::Cost cost = costOf(worst_);
    const double allowed = kWorstTick_us * kInstructionsPer_us * 1000 / settings_.rate_Hz;
    return {{"family", family_.name},
            {"rate_Hz", settings_.rate_Hz},
            {"bounded", settings_.bounded},
            {"plays", plays_},
            {"p50_us", durations_ns_.quantile(0.5) / 1e3},
            {"p999_us", durations_ns_.quantile(0.999) / 1e3},
            {"worst_us", cost.ns / 1e3},
            {"instructions", cost.instructions},
            {"instructions_per_us", cost.ns > 0 ? cost.instructions / cost.ns * 1e3 : 0},
            {"units", units_},
            {"allowance_spent_ticks", allowanceSpent_},
            {"allowed_instructions", allowed},
            {"pass", cost.instructions <= allowed},
            {"tick", worst_.tick},
            {"scene_genes", worst_.genome.scene},
            {"motion_genes", worst_.genome.motion}};
  }
  [[nodiscard]] Statistics& durations_ns() { return durations_ns_; }

  void take(const Found& kept) {
    worst_ = kept;
    measure(worst_);
  }

 private:
  [[nodiscard]] Genome someGenome() {
    Genome genome;
    for (double& gene : genome.scene) gene = random_.between(0, 1);
    for (double& gene : genome.motion) gene = random_.between(0, 1);
    return genome;
  }

  [[nodiscard]] Genome changed(Genome genome) {
    const auto change = [&](double& gene) {
      const double to = random_.below(3) == 0 ? random_.between(0, 1) : gene + random_.between(-0.1, 0.1);
      gene = to - std::floor(to);
    };
    if (random_.below(4) == 0) change(genome.scene[static_cast<std::size_t>(random_.below(Family::kGenes))]);
    for (int i = random_.below(4); i >= 0; --i) {
      change(genome.motion[static_cast<std::size_t>(random_.below(Genome::kMotionGenes))]);
    }
    return genome;
  }

  /// Once for the tick that takes the most; again to time it without what the machine does besides.
  void measure(Found& found) {
    const auto scene = sceneOf(found.genome);
    Play first(scene, found.genome, settings_);
    double longest_ns = 0;
    std::int64_t most = -1;
    int byTime = 0, byUnits = 0;
    for (int i = 0; i < kTicks; ++i) {
      const Play::Tick tick = first.tick();
      durations_ns_.add(tick.ns);
      allowanceSpent_ += tick.allowanceSpent ? 1 : 0;
      units_ = std::max(units_, tick.units);
      if (tick.ns > longest_ns) byTime = i;
      if (tick.units > most) byUnits = i;
      longest_ns = std::max(longest_ns, tick.ns);
      most = std::max(most, tick.units);
    }
    Play again(scene, found.genome, settings_);
    found.ns = 0;
    for (int i = 0; i <= std::max(byTime, byUnits); ++i) {
      if (i == byTime || i == byUnits) {
        const double ns = again.timeOfNext_ns();
        if (ns > found.ns) found.tick = i;
        found.ns = std::max(found.ns, ns);
      }
      (void)again.tick();
    }
  }

  [[nodiscard]] Play::Cost costOf(const Found& found) {
    Play play(sceneOf(found.genome), found.genome, settings_);
    for (int i = 0; i < found.tick; ++i) (void)play.tick();
    return play.costOfNext();
  }

  const Family& family_;
  Random random_;
  Play::Settings settings_;
  Found worst_;
  int plays_ = 0;
  Statistics durations_ns_;
  std::int64_t allowanceSpent_ = 0;
  std::int64_t units_ = 0;
  std::deque<std::pair<std::array<double, Family::kGenes>, std::shared_ptr<const ServoScene>>> scenes_;
};

std::vector<const Family*> familiesOf(const WorstOptions& options) {
  std::vector<const Family*> chosen;
  if (!options.family.empty()) return {&findFamily(options.family)};
  for (const Family& family : families()) chosen.push_back(&family);
  return chosen;
}

void print(const Record& record) {
  std::printf(
      "%-11s %8.1f us worst, %9.0f instructions of %.0f, p50 %.1f, p99.9 %.1f us, allowance spent in %lld ticks  %s\n",
      record["family"].get<std::string>().c_str(), record["worst_us"].get<double>(),
      record["instructions"].get<double>(), record["allowed_instructions"].get<double>(),
      record["p50_us"].get<double>(), record["p999_us"].get<double>(),
      static_cast<long long>(record["allowance_spent_ticks"].get<std::int64_t>()),
      record["pass"].get<bool>() ? "within" : "BEYOND");
  std::fflush(stdout);
}

Genome genomeOf(const Record& record) {
  Genome genome;
  genome.scene = record.at("scene_genes").get<decltype(genome.scene)>();
  genome.motion = record.at("motion_genes").get<decltype(genome.motion)>();
  return genome;
}

/// The worst tick of an earlier hunt, once more.
Record again(const Record& kept, const Play::Settings& settings) {
  Hunt hunt(findFamily(kept.at("family").get<std::string>()), WorstOptions{}.seed, settings);
  hunt.take({genomeOf(kept)});
  return hunt.record();
}

/// A part is a family's hunt, or a tick that an earlier one found.
class WorstSweep : public Sweep {
 public:
  explicit WorstSweep(const WorstOptions& options)
      : options_(options), settings_{options.rate_Hz, !options.withoutAllowance} {
    if (options.kept.empty()) {
      families_ = familiesOf(options);
    } else {
      kept_ = readRecords(options.kept);
      if (!options.family.empty()) {
        static_cast<void>(findFamily(options.family));  // which throws where there is none
        std::erase_if(kept_, [&](const Record& kept) { return kept.at("family") != options.family; });
      }
    }
  }

  [[nodiscard]] std::size_t size() const override { return options_.kept.empty() ? families_.size() : kept_.size(); }

  [[nodiscard]] Record run(std::size_t part) override {
    if (!options_.kept.empty()) return {{"record", again(kept_[part], settings_)}};
    Hunt hunt(*families_[part], options_.seed, settings_);
    const auto begin = std::chrono::steady_clock::now();
    std::chrono::duration<double> gone{}, said{};
    do {
      hunt.goOn();
      gone = std::chrono::steady_clock::now() - begin;
      if (gone - said < std::chrono::seconds(10)) continue;
      said = gone;
      std::fprintf(stderr, "%s: the slowest tick so far takes %.1f us\n", families_[part]->name.data(),
                   hunt.worst_ns() / 1e3);
    } while (gone.count() < options_.seconds / static_cast<double>(size()) && !interruption_.came());
    return {{"record", hunt.record()}, {"survival", survivalOf(hunt.durations_ns())}};
  }

  void print(std::size_t /*part*/, const Record& result) override { haptics::eval::print(result.at("record")); }

  [[nodiscard]] bool finish(const std::vector<Record>& results) override {
    std::vector<Record> records;
    for (const Record& result : results) records.push_back(result.at("record"));
    writeRecords(options_.out, "worst", records);
    if (options_.kept.empty()) draw(results);
    return std::ranges::all_of(records, [](const Record& record) { return record.at("pass").get<bool>(); });
  }

 private:
  void draw(const std::vector<Record>& results) const {
    std::vector<Tail> tails;
    std::vector<std::pair<const Family*, Genome>> bare;
    for (std::size_t i = 0; i < results.size(); ++i) {
      tails.push_back(
          {std::string(families_[i]->name), "ours", results[i].at("survival").get<decltype(Tail::survival)>()});
      if (families_[i]->bareShapes) bare.emplace_back(families_[i], genomeOf(results[i].at("record")));
    }
    for (Tail& tail : baselineTails(bare, kTicks)) tails.push_back(std::move(tail));
    drawTails(tails, kWorstTick_us * 1000 / options_.rate_Hz, options_.out);
  }

  WorstOptions options_;
  Play::Settings settings_;
  std::vector<const Family*> families_;
  std::vector<Record> kept_;
  Interruption interruption_;
};

}  // namespace

double worstKeptInstructions(const std::filesystem::path& kept) {
  double most = 0;
  for (const Record& record : readRecords(kept)) most = std::max(most, again(record, {})["instructions"].get<double>());
  if (most == 0) throw std::runtime_error(kept.string() + ": holds no ticks");
  return most;
}

std::unique_ptr<Sweep> makeWorstSweep(const WorstOptions& options) { return std::make_unique<WorstSweep>(options); }

}  // namespace haptics::eval
