#include <cstdio>
#include <map>
#include <string>

#include "tests/eval/fuzz/edit_finding.h"
#include "tests/eval/fuzz/edit_scene.h"
#include "tests/eval/fuzz/fuzz.h"
#include "tests/eval/statistics.h"
#include "tests/eval/table1/interruption.h"

namespace haptics::eval {
namespace {

constexpr int kMaxRecordings = 20;
constexpr std::uint64_t kProgress = 1000;  ///< Scenes from one line about it to the next.
constexpr double kNoticed_N = 0.1;
constexpr double kFelt_N = 0.5;

/// Edits of a kind.
class EditTally {
 public:
  void add(const EditVerdict& verdict, bool inContact) {
    steps_N_.add(verdict.step_N);
    inContact_ += inContact ? 1 : 0;
    kicks_ += verdict.excess_N > 0 ? 1 : 0;
    noticed_ += verdict.step_N > kNoticed_N && verdict.excess_N > 0 ? 1 : 0;
    felt_ += verdict.step_N > kFelt_N && verdict.excess_N > 0 ? 1 : 0;
    inside_ += verdict.inside_m > 0 ? 1 : 0;
    unfelt_ += !verdict.adopted || verdict.missing_N > 0 ? 1 : 0;
    notFinite_ += verdict.finite ? 0 : 1;
    failed_ += verdict.failure() ? 1 : 0;
  }
  [[nodiscard]] Record record() {
    return {{"edits", steps_N_.count()},
            {"in_contact", inContact_},
            {"steps_above_limit", kicks_},
            {"steps_above_0.1_N", noticed_},
            {"steps_above_0.5_N", felt_},
            {"step_p50_N", steps_N_.quantile(0.5)},
            {"step_p99_N", steps_N_.quantile(0.99)},
            {"step_max_N", steps_N_.max()},
            {"inside_afterwards", inside_},
            {"not_felt_in_full", unfelt_},
            {"nan", notFinite_},
            {"pass", failed_ == 0}};
  }

 private:
  Statistics steps_N_;
  std::int64_t inContact_ = 0;
  std::int64_t kicks_ = 0;
  std::int64_t noticed_ = 0;
  std::int64_t felt_ = 0;
  std::int64_t inside_ = 0;
  std::int64_t unfelt_ = 0;
  std::int64_t notFinite_ = 0;
  std::int64_t failed_ = 0;
};

std::string countWord(std::size_t objects) { return objects == 1 ? "one" : objects == 2 ? "two" : "more"; }

class EditFuzz {
 public:
  EditFuzz(const FuzzOptions& options, const std::filesystem::path& out) : options_(options), out_(out) {}

  [[nodiscard]] bool run() {
    std::uint64_t done = 0;
    for (; done < options_.scenes && !interruption_.came(); ++done) {
      runScene(options_.seed + done);
      if ((done + 1) % kProgress == 0) {
        std::fprintf(stderr, "%llu of %llu scenes, %d edits failed\n", static_cast<unsigned long long>(done + 1),
                     static_cast<unsigned long long>(options_.scenes), found_);
      }
    }
    report(done);
    return found_ == 0;
  }

 private:
  void runScene(std::uint64_t seed) {
    EditScene scene(seed);
    for (int i = 0; i < EditScene::kEdits && !interruption_.came(); ++i) {
      const EditVerdict verdict = scene.next();
      const EditWindow& window = scene.run().windows.back();
      tallies_[{window.edit, countWord(window.objects)}].add(verdict, scene.inContact());
      all_.add(verdict, scene.inContact());
      if (verdict.failure()) keep(seed, scene.run(), {*verdict.failure(), scene.run().windows.size() - 1, verdict});
      if (!verdict.finite || verdict.inside_m > 0) return;  // what comes next is no fault of the next edit
    }
  }

  void keep(std::uint64_t seed, const EditRun& run, const EditFinding& finding) {
    const EditWindow& window = run.windows[finding.window];
    Record record{{"fuzz", "edits"},
                  {"scene", window.edit},
                  {"seed", seed},
                  {"edit", finding.window},
                  {"failure", nameOf(finding.failure)},
                  {"objects", window.objects},
                  {"rate_Hz", run.rate_Hz},
                  {"device", run.device},
                  {"stabiliser", run.stabiliser},
                  {"step_N", finding.verdict.step_N},
                  {"tick", finding.verdict.tick - window.begin},
                  {"inside_mm", finding.verdict.inside_m * 1e3},
                  {"missing_N", finding.verdict.missing_N}};
    if (found_++ < kMaxRecordings) {
      const std::string folder = "fuzz-" + std::string(nameOf(finding.failure)) + '-' + std::to_string(seed) + '-' +
                                 std::to_string(finding.window);
      const EditRun less = reduced(run, finding);
      writeRun(less, out_ / folder);
      record["recording"] = folder;
      record["recording_objects"] = less.scenes.front().objects.size();
      record["recording_ticks"] = less.hips.size();
      std::printf("  %s\n", measuresText(record).c_str());
      std::fflush(stdout);
    }
    record["pass"] = false;
    findings_.push_back(std::move(record));
  }

  void report(std::uint64_t done) {
    std::vector<Record> records;
    std::printf("%-18s %-5s %6s %8s %7s %7s %7s %8s %8s %7s %7s\n", "edit", "objs", "edits", "contact", "kicks",
                ">0.1 N", ">0.5 N", "p99 N", "worst N", "inside", "unfelt");
    for (auto& [key, tally] : tallies_) print(key.first, key.second, tally, records);
    print("all", "", all_, records);
    records.insert(records.end(), findings_.begin(), findings_.end());
    writeRecords(out_, "fuzz", records);
    if (interruption_.came()) std::printf("interrupted: this is what was found by then\n");
    std::printf("%llu scenes, %d edits failed", static_cast<unsigned long long>(done), found_);
    if (found_ > kMaxRecordings) std::printf("; %d of them without a recording", found_ - kMaxRecordings);
    std::printf("\n");
  }

  void print(const std::string& edit, const std::string& objects, EditTally& tally, std::vector<Record>& records) {
    Record record{{"fuzz", "edits"}, {"scene", edit}, {"objects", objects}, {"seed", options_.seed}};
    record.update(tally.record());
    const auto count = [&](const char* key) { return record[key].get<long long>(); };
    std::printf("%-18s %-5s %6lld %8lld %7lld %7lld %7lld %8.3f %8.3f %7lld %7lld\n", edit.c_str(), objects.c_str(),
                count("edits"), count("in_contact"), count("steps_above_limit"), count("steps_above_0.1_N"),
                count("steps_above_0.5_N"), record["step_p99_N"].get<double>(), record["step_max_N"].get<double>(),
                count("inside_afterwards"), count("not_felt_in_full"));
    records.push_back(std::move(record));
  }

  const FuzzOptions& options_;
  const std::filesystem::path& out_;
  Interruption interruption_;
  std::map<std::pair<std::string, std::string>, EditTally> tallies_;
  EditTally all_;
  std::vector<Record> findings_;
  int found_ = 0;
};

}  // namespace

bool runFuzzEdits(const FuzzOptions& options, const std::filesystem::path& out) { return EditFuzz(options, out).run(); }

}  // namespace haptics::eval
