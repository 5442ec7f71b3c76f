#include "tests/eval/stability/stability.h"

#include <algorithm>
#include <cstdio>

#include "tests/eval/stability/held_tool.h"
#include "tests/eval/stability/linear_loop.h"
#include "tests/eval/stability/picture.h"
#include "tests/eval/stability/strokes.h"
#include "tests/eval/stability/support.h"
#include "tests/eval/stability/tables.h"
#include "tests/eval/stability/texture_rest.h"

namespace haptics::eval {
namespace {

double number(const Record& r, const char* key) { return r.at(key).get<double>(); }

bool is(const Record& r, const char* key, std::string_view value) {
  return r.at(key).get_ref<const std::string&>() == value;
}

void printCritical(const std::vector<Record>& records) {
  std::printf("K_crit of the wall, N/m, at 1 kHz, without delay / with a period of it\n%-24s %-8s", "", "hand");
  for (const DevicePreset& device : devicePresets()) std::printf(" %15s", device.name.data());
  for (const MethodEntry& method : stabilityMethods()) {
    for (const HandPreset& hand : handPresets()) {
      std::string line;
      for (const DevicePreset& device : devicePresets()) {
        double at[2] = {-1, -1};
        for (const Record& r : records) {
          if (!is(r, "method", method.name) || !is(r, "device", device.name) || !is(r, "hand", hand.name)) continue;
          if (number(r, "rate_Hz") != 1e3 || number(r, "delay_ms") > 1) continue;
          at[number(r, "delay_ms") > 0 ? 1 : 0] = number(r, "K_crit_N_per_m");
        }
        char cell[32];
        std::snprintf(cell, sizeof cell, " %7.0f/%-7.0f", at[0], at[1]);
        line += at[0] < 0 ? std::string(16, ' ') : cell;
      }
      if (line.find('/') != std::string::npos) {
        std::printf("\n%-24s %-8s%s", method.title.data(), hand.name.data(), line.c_str());
      }
    }
  }
  std::printf("\n");
}

/// Of each scene and method the record that is worst by this measure; those beyond a limit all.
void printWorst(const char* title, const std::vector<Record>& records, const char* measure, bool leastIsWorst) {
  std::printf("\n%s\n", title);
  std::vector<const Record*> worst;
  for (const Record& r : records) {
    const auto same = [&](const Record* w) { return (*w)["scene"] == r["scene"] && (*w)["method"] == r["method"]; };
    const auto at = std::ranges::find_if(worst, same);
    if (at == worst.end()) {
      worst.push_back(&r);
    } else if (leastIsWorst ? number(r, measure) < number(**at, measure) : number(r, measure) > number(**at, measure)) {
      *at = &r;
    }
  }
  for (const Record* r : worst) std::printf("  worst: %s\n", measuresText(*r).c_str());
  for (const Record& r : records) {
    if (!r["pass"].get<bool>()) std::printf("  BEYOND ITS LIMIT: %s\n", measuresText(r).c_str());
  }
}

struct Table {
  std::vector<Record> (*measure)(Scope, const CaseChoice&);
  // How its records are printed: those that are worst by this measure. None: not, or in a table of their own.
  const char* title = nullptr;
  const char* worstBy = nullptr;
  bool leastIsWorst = false;
};

/// Of one case.
template <std::vector<Record> (*measure)()>
std::vector<Record> whole(Scope /*scope*/, const CaseChoice& isChosen) {
  return isChosen(0, 1) ? measure() : std::vector<Record>();
}

constexpr const char* kOff = "off_ratio";  // beside the measures, when printed

constexpr Table kTables[] = {
    {measureCritical},
    {whole<compareWithTheory>, "Theory: what the simulated plant bears against what it should", kOff},
    {whole<compareFootings>, "Theory: on a body that moves, on tissue", kOff},
    {measureGrounds, "Other grounds, ours", "K_crit_over_preset", true},
    {measureHeldTool, "A plate that is held, ours", "K_crit_over_preset", true},
    {measureRobustness, "Mass, friction and delay not as told, ours", "K_crit_over_preset", true},
    {measureFidelity, "Press, stroke, lift at the maker's stiffness", "force_error_rms_ratio"},
    {measureEnergy, "Energy taken from the hand, least at any time", "least_energy_taken_uJ", true},
    {measureTextureRest, "Textures in the light hand, ours", "limit_cycle_um"},
    {measureZWidth},
};

/// A part is a case of a table.
class StabilitySweep : public Sweep {
 public:
  explicit StabilitySweep(const StabilityOptions& options)
      : options_(options),
        scope_(options.shortRun ? Scope::kShort
               : options.full   ? Scope::kFull
                                : Scope::kCoarse) {
    for (const Table& table : kTables) {
      std::size_t cases = 0;
      static_cast<void>(table.measure(scope_, [&](std::size_t /*at*/, std::size_t of) {
        cases = of;
        return false;
      }));
      for (std::size_t i = 0; i < cases; ++i) parts_.push_back({&table, i});
    }
  }

  [[nodiscard]] std::size_t size() const override { return parts_.size(); }

  [[nodiscard]] Record run(std::size_t part) override {
    const std::size_t chosen = parts_[part].number;
    return Record(
        parts_[part].table->measure(scope_, [&](std::size_t at, std::size_t /*of*/) { return at == chosen; }));
  }

  void print(std::size_t /*part*/, const Record& /*records*/) override {}  // tables come when all is there

  [[nodiscard]] bool finish(const std::vector<Record>& results) override {
    std::vector<Record> all;
    for (const Table& table : kTables) {
      std::vector<Record> records;
      for (std::size_t part = 0; part < parts_.size(); ++part) {
        if (parts_[part].table == &table) records.insert(records.end(), results[part].begin(), results[part].end());
      }
      all.insert(all.end(), records.begin(), records.end());
      if (&table == &kTables[0]) printCritical(records);
      if (table.title == nullptr) continue;
      for (Record& record : records) {
        if (table.worstBy == kOff) record[kOff] = std::abs(number(record, "difference_ratio"));
      }
      printWorst(table.title, records, table.worstBy, table.leastIsWorst);
    }
    writeRecords(options_.out, "stability", all);
    if (scope_ != Scope::kShort) drawStability(all, options_.out);
    const auto failed = std::ranges::count_if(all, [](const Record& r) { return !r["pass"].get<bool>(); });
    std::printf("\n%zu records, %td beyond a limit; written to %s: stability.json%s\n", all.size(), failed,
                options_.out.c_str(), scope_ == Scope::kShort ? "" : ", stability.png, stability.svg");
    return failed == 0;
  }

 private:
  struct Part {
    const Table* table;
    std::size_t number;
  };

  StabilityOptions options_;
  Scope scope_;
  std::vector<Part> parts_;
};

}  // namespace

std::unique_ptr<Sweep> makeStabilitySweep(const StabilityOptions& options) {
  return std::make_unique<StabilitySweep>(options);
}

void redrawStability(const StabilityOptions& options) { drawStability(readRecords(options.from), options.out); }

}  // namespace haptics::eval
