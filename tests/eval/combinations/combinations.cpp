#include "tests/eval/combinations/combinations.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "tests/eval/adapters/outside_method.h"
#include "tests/eval/combinations/limits.h"
#include "tests/eval/combinations/sheet.h"
#include "tests/eval/combinations/solo.h"
#include "tests/eval/report.h"

namespace haptics::eval {
namespace {

using FeaturePair = std::pair<Feature, Feature>;

std::string nameOf(const FeaturePair& pair) {
  return std::string(nameOf(pair.first)) + '-' + std::string(nameOf(pair.second));
}

std::vector<FeaturePair> allPairs() {
  std::vector<FeaturePair> pairs;
  for (std::size_t a = 0; a < kFeatures; ++a) {
    for (std::size_t b = a + 1; b < kFeatures; ++b) pairs.emplace_back(Feature(a), Feature(b));
  }
  return pairs;
}

const AblationCase* chosenAblation(const std::string& name) {
  if (name.empty()) return nullptr;
  const auto found = std::ranges::find(kAblations, name, &AblationCase::name);
  if (found == kAblations.end()) throw std::invalid_argument("there is no ablation " + name);
  return &*found;
}

std::vector<FeaturePair> chosenPairs(const std::string& name, const AblationCase* ablation) {
  std::vector<FeaturePair> pairs = allPairs();
  if (ablation != nullptr) pairs.assign(ablation->pairs.begin(), ablation->pairs.begin() + ablation->count);
  if (name.empty()) return pairs;
  std::string known;
  for (const FeaturePair& pair : pairs) {
    if (nameOf(pair) == name) return {pair};
    known += (known.empty() ? "" : ", ") + nameOf(pair);
  }
  const std::string about = ablation != nullptr ? " that " + std::string(ablation->name) + " is about" : "";
  throw std::invalid_argument("there is no pair " + name + about + "; there are " + known);
}

/// Throws NotApplicable where a guest is not handed what the pair is about.
PairResult run(const FeaturePair& pair, Ablation ablation, std::uint64_t seed, const Method* guest) {
  constexpr std::array kHandedOver{Feature::kShading, Feature::kFriction, Feature::kLattice, Feature::kSeveral};
  for (const Feature feature : {pair.first, pair.second}) {
    if (guest != nullptr && std::ranges::find(kHandedOver, feature) == kHandedOver.end())
      throw NotApplicable(std::string(nameOf(feature)) + " is not handed over");
  }
  constexpr std::uint64_t kApart = 1000, kOfFirst = 8;
  const std::uint64_t number =
      static_cast<std::uint64_t>(pair.first) * kOfFirst + static_cast<std::uint64_t>(pair.second);
  const Random random(seed * kApart + number);
  if (pair.first == Feature::kSeveral) return runGroove(pair.second, ablation, random, guest);
  return pair.second == Feature::kSeveral ? runGroove(pair.first, ablation, random, guest)
                                          : runSolo(pair.first, pair.second, ablation, random, guest);
}

bool isWithin(double value, const Limit& limit) { return value <= limit.most; }  // not for NaN

/// Null for ours, whose step is judged without a guest's limits.
const Method* guestOf(const std::string& name) {
  if (name.empty() || name == kOurs) return nullptr;
  static const std::vector<Method> all = [] {
    std::vector<Method> known(methods().begin(), methods().end());
    known.insert(known.end(), singleConcernMethods().begin(), singleConcernMethods().end());
    return known;
  }();
  return &findMethod(name, all);
}

/// Of all seeds, by measure.
class Tally {
 public:
  explicit Tally(const FeaturePair& pair) { cell_.row = pair.first, cell_.column = pair.second; }

  void add(const PairResult& result, std::uint64_t seed) {
    double strongest = 0;
    for (const auto& [measure, value] : result.measures) {
      const Limit& limit = limitOf(measure);
      const auto [worst, isNew] = worst_.try_emplace(measure, Worst{value, seed});
      if (!isNew && !(value <= worst->second.value)) worst->second = {value, seed};
      const double share = limit.most > 0 ? value / limit.most : value > 0 ? 1e9 : 0;
      strongest = share <= strongest ? strongest : share;
    }
    if (cell_.felt.empty() || !(strongest <= strongest_)) {
      strongest_ = strongest;
      cell_.plotted = result.plotted;
      cell_.felt = result.felt;
      cell_.right = result.right;
    }
  }

  struct Worst {
    double value;
    std::uint64_t seed;
  };
  [[nodiscard]] const std::map<Measure, Worst>& worst() const { return worst_; }
  [[nodiscard]] bool good() const {
    return std::ranges::all_of(worst_, [](const auto& w) { return isWithin(w.second.value, limitOf(w.first)); });
  }
  /// Beyond the limit of one of what is measured of an ablation.
  [[nodiscard]] bool fails(const AblationCase& ablation) const {
    return std::ranges::any_of(ablation.measures, [this](Measure measure) {
      const auto worst = worst_.find(measure);
      return worst != worst_.end() && !isWithin(worst->second.value, limitOf(measure));
    });
  }
  /// What the picture shows.
  [[nodiscard]] SheetPair cell() const {
    SheetPair cell = cell_;
    for (const auto& [measure, worst] : worst_) cell.worst.emplace_back(measure, worst.value);
    return cell;
  }

 private:
  SheetPair cell_;
  std::map<Measure, Worst> worst_;
  double strongest_ = 0;
};

std::string numberText(double value, double unit) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value / unit);
  return text;
}

const char* verdictOf(Measure measure, double value) { return isWithin(value, limitOf(measure)) ? "within" : "FAIL"; }

void printTable(const std::vector<FeaturePair>& pairs, const std::vector<Tally>& tallies) {
  std::printf("\n%-20s %-20s %10s %10s %6s\n", "pair", "worst of", "measured", "limit", "seed");
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    bool named = false;
    for (const auto& [measure, worst] : tallies[i].worst()) {
      const Limit& limit = limitOf(measure);
      std::printf("%-20s %-20s %10s %10s %6llu  %s\n", named ? "" : nameOf(pairs[i]).c_str(), limit.shown.data(),
                  numberText(worst.value, limit.unit).c_str(), numberText(limit.most, limit.unit).c_str(),
                  static_cast<unsigned long long>(worst.seed), verdictOf(measure, worst.value));
      named = true;
    }
  }
}

void writeCsv(const std::filesystem::path& path, const std::vector<FeaturePair>& pairs,
              const std::vector<Tally>& tallies) {
  std::ofstream file(path);
  file << "pair,measure,worst,seed,limit,verdict,why\n";
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    for (const auto& [measure, worst] : tallies[i].worst()) {
      const Limit& limit = limitOf(measure);
      file << nameOf(pairs[i]) << ',' << nameOf(measure) << ',' << worst.value << ',' << worst.seed << ',' << limit.most
           << ",\"" << verdictOf(measure, worst.value) << "\",\"" << limit.why << "\"\n";
    }
  }
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

}  // namespace

std::vector<std::string> ablationNames() {
  std::vector<std::string> names;
  for (const AblationCase& each : kAblations) names.emplace_back(each.name);
  return names;
}

bool runCombinations(const CombinationsOptions& options) {
  const AblationCase* ablation = chosenAblation(options.ablate);
  const std::vector<FeaturePair> pairs = chosenPairs(options.pair, ablation);
  if (ablation != nullptr) std::printf("%s: %s\n", ablation->name.data(), ablation->about.data());
  const Method* const guest = guestOf(options.method);
  std::vector<Tally> tallies(pairs.begin(), pairs.end());
  std::vector<Record> records;
  for (int i = 0; i < options.seeds; ++i) {
    const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    std::fflush(stdout);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      Record record{{"method", ablation != nullptr ? ablation->name
                               : guest != nullptr  ? guest->name
                                                   : kOurs},
                    {"scene", nameOf(pairs[k])},
                    {"seed", seed}};
      PairResult result;
      if (!runOrExplain(record, [&] {
            result = run(pairs[k], ablation != nullptr ? ablation->ablation : Ablation::kNone, seed, guest);
          })) {
        std::printf("%s\n", measuresText(record).c_str());
        records.push_back(std::move(record));
        continue;
      }
      tallies[k].add(result, seed);
      bool pass = true;
      for (const auto& [measure, value] : result.measures) {
        record[std::string(nameOf(measure))] = value;
        pass = pass && isWithin(value, limitOf(measure));
      }
      record["pass"] = pass;
      records.push_back(std::move(record));
    }
  }
  printTable(pairs, tallies);
  writeRecords(options.out, "combinations", records);
  writeCsv(options.out / "combinations.csv", pairs, tallies);
  if (guest != nullptr) {
    std::erase_if(tallies, [](const Tally& tally) { return tally.worst().empty(); });
    const auto faults = std::ranges::count_if(records, [](const Record& run) { return run.contains("fault"); });
    std::printf("%zu pairs not applicable, or stopped by %td faults\n", pairs.size() - tallies.size(), faults);
  }
  const auto good = std::ranges::count_if(tallies, &Tally::good);
  if (ablation != nullptr) {
    const auto failed = std::ranges::count_if(tallies, [&](const Tally& tally) { return tally.fails(*ablation); });
    std::printf("%zu pairs, %td fail by it\n", pairs.size(), failed);
    return failed == std::ssize(tallies);
  }
  std::printf("%zu pairs, %td within their limits\n", tallies.size(), good);
  std::vector<SheetPair> cells;
  for (const Tally& tally : tallies) cells.push_back(tally.cell());
  if (!cells.empty())
    drawCombinations(cells, guest != nullptr ? std::string(guest->name) : "the production step", options.seeds,
                     options.out / "combinations");
  return guest != nullptr || good == std::ssize(tallies);
}

}  // namespace haptics::eval
