#include "tests/eval/exchange/judge.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <map>
#include <stdexcept>
#include <utility>

#include "tests/eval/adapters/outside_method.h"
#include "tests/eval/exchange/recorder.h"
#include "tests/eval/scenes/scenes.h"

namespace haptics::eval {
namespace {

/// Rows of a file with commas, each with its number.
class Rows {
 public:
  Rows(const std::filesystem::path& path, std::size_t columns) : path_(path), file_(path), columns_(columns) {
    std::string head;
    if (!std::getline(file_, head)) throw std::runtime_error(path.string() + ": is missing or empty");
  }

  /// @return Whether there is another one.
  bool next() {
    if (!std::getline(file_, line_)) return false;
    if (line_.ends_with('\r')) line_.pop_back();
    ++number_;
    cells_.clear();
    for (std::string_view rest = line_;; rest.remove_prefix(rest.find(',') + 1)) {
      cells_.push_back(rest.substr(0, rest.find(',')));
      if (rest.find(',') == std::string_view::npos) break;
    }
    if (cells_.size() != columns_)
      wrong("has " + std::to_string(cells_.size()) + " columns; " + std::to_string(columns_) + " are right");
    return true;
  }

  [[nodiscard]] std::string_view cell(std::size_t column) const { return cells_[column]; }
  [[nodiscard]] double number(std::size_t column) const {
    double value = 0;
    const std::string_view text = cells_[column];
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size())
      wrong("has no number in column " + std::to_string(column + 1));
    return value;
  }
  [[nodiscard]] Vec3 vec3(std::size_t column) const { return {number(column), number(column + 1), number(column + 2)}; }
  [[noreturn]] void wrong(const std::string& what) const {
    throw std::runtime_error(path_.string() + ": row " + std::to_string(number_) + ' ' + what);
  }

 private:
  std::filesystem::path path_;
  std::ifstream file_;
  std::size_t columns_;
  std::string line_;
  std::vector<std::string_view> cells_;
  std::int64_t number_ = 0;
};

/// Answers what forces.csv has, to a hand that goes where motion.csv has it.
class Playback final : public Renderer {
 public:
  explicit Playback(const std::filesystem::path& folder, bool turnsMirroredOver)
      : motion_(folder / "motion.csv", 6), folder_(folder), turnsMirroredOver_(turnsMirroredOver) {
    readForces();
    if (exists(folder / kDentsFile)) {
      for (Rows rows(folder / kDentsFile, 8); rows.next();)
        dents_[at(rows)].push_back({Vec3f(rows.vec3(2)), Vec3f(rows.vec3(5))});
    }
    if (exists(folder / kBulgesFile)) {
      for (Rows rows(folder / kBulgesFile, 3); rows.next();) bulges_m_[at(rows)] = rows.number(2);
    }
  }

  void begin(std::span<const std::shared_ptr<const CollisionMesh>>, std::span<const Pose>, Vec3 hip) override {
    go("load", hip);
  }
  void place(Vec3 hip) override { go("place", hip); }
  void edit(const EditedScene&, Vec3 hip) override { go("edit", hip); }
  Felt tick(std::span<const Pose>, Vec3 hip) override { return answerTo("tick", hip); }
  Felt drive(std::span<const Pose>, bool haveCome, Vec3 hip) override {
    return answerTo(haveCome ? "tick_with_sample" : "tick_without_sample", hip);
  }
  [[nodiscard]] std::vector<Dent> dents(std::size_t body) const override {
    const auto found = dents_.find({row_, body});
    return found == dents_.end() ? std::vector<Dent>{} : found->second;
  }
  [[nodiscard]] double highestBulge_m(std::size_t body) const override {
    const auto found = bulges_m_.find({row_, body});
    return found == bulges_m_.end() ? 0 : found->second;
  }
  [[nodiscard]] bool turnsMirroredOver() const override { return turnsMirroredOver_; }

  void mustBeAtEnd() {
    if (motion_.next()) motion_.wrong("is there, but the scene has ended");
  }

 private:
  struct Row {
    std::int64_t row;
    Felt felt;
  };
  using RowAndBody = std::pair<std::int64_t, std::size_t>;

  static RowAndBody at(const Rows& rows) {
    if (!(rows.number(0) >= 0 && rows.number(0) < 1e15 && rows.number(1) >= 0 && rows.number(1) < 1e6))
      rows.wrong("has no row of motion.csv and body");
    return {static_cast<std::int64_t>(rows.number(0)), static_cast<std::size_t>(rows.number(1))};
  }

  void readForces() {
    constexpr std::size_t kColumns = 16;
    std::ifstream file(folder_ / "forces.csv");
    std::string line;
    if (!std::getline(file, line))
      throw std::runtime_error((folder_ / "forces.csv").string() + ": is missing or empty");
    for (std::int64_t number = 2; std::getline(file, line); ++number) {
      const auto wrong = [&](const std::string& what) -> std::runtime_error {
        return std::runtime_error((folder_ / "forces.csv").string() + ": line " + std::to_string(number) + ' ' + what);
      };
      std::vector<std::optional<double>> cells;
      for (const char *at = line.data(), *const end = at + line.size() - (line.ends_with('\r') ? 1 : 0);;) {
        const char* const comma = std::find(at, end, ',');
        double value = 0;
        if (at != comma) {
          const auto [stop, error] = std::from_chars(at, comma, value);
          if (error != std::errc{} || stop != comma)
            throw wrong("has no number in column " + std::to_string(cells.size() + 1));
        }
        cells.push_back(at == comma ? std::nullopt : std::optional(value));
        if (comma == end) break;
        at = comma + 1;
      }
      if (cells.size() != kColumns)
        throw wrong("has " + std::to_string(cells.size()) + " columns; " + std::to_string(kColumns) + " are right");
      if (std::ranges::any_of(cells.begin(), cells.begin() + 10, [](const auto& cell) { return !cell; }))
        throw wrong("has an empty cell; only written_* and followed_* may be empty");
      const auto vec3 = [&](std::size_t k) {
        return Vec3(*cells[k], cells[k + 1].value_or(0), cells[k + 2].value_or(0));
      };
      Felt felt{*cells[1] != 0, vec3(6), vec3(3), static_cast<int>(std::clamp(*cells[9], 0.0, 1e9)), *cells[2] != 0};
      if (cells[10]) felt.written_N = vec3(10);
      if (cells[13]) felt.followed = vec3(13);
      forces_.push_back({static_cast<std::int64_t>(*cells[0]), felt});
    }
  }

  void go(std::string_view event, Vec3 hip) {
    if (!motion_.next()) throw std::runtime_error((folder_ / "motion.csv").string() + ": ends before the scene does");
    if (motion_.number(0) != static_cast<double>(++row_)) motion_.wrong("is not numbered so");
    if (motion_.cell(1) != event)
      motion_.wrong("is \"" + std::string(motion_.cell(1)) + "\" where the scene has \"" + std::string(event) + "\"");
    if (motion_.vec3(3) != hip)
      motion_.wrong("has the hand elsewhere than the scene: it was led by another answer, and can only be judged live");
  }

  Felt answerTo(std::string_view event, Vec3 hip) {
    go(event, hip);
    if (next_ == forces_.size()) throw MethodFault("forces.csv ends before row " + std::to_string(row_));
    const Row& answer = forces_[next_++];
    if (answer.row != row_)
      throw MethodFault("forces.csv has row " + std::to_string(answer.row) + " where row " + std::to_string(row_) +
                        " is right");
    if (!isFinite(answer.felt.ihip) || !isFinite(answer.felt.force_N))
      throw MethodFault("forces.csv: row " + std::to_string(row_) + " is not finite");
    return answer.felt;
  }

  Rows motion_;
  std::filesystem::path folder_;
  bool turnsMirroredOver_;
  std::vector<Row> forces_;
  std::map<RowAndBody, std::vector<Dent>> dents_;
  std::map<RowAndBody, double> bulges_m_;
  std::size_t next_ = 0;
  std::int64_t row_ = 0;
};

Record readJson(const std::filesystem::path& path) {
  std::ifstream file(path);
  Record json = Record::parse(file, nullptr, false);
  if (!json.is_object()) throw std::runtime_error(path.string() + ": is missing, or no JSON object");
  return json;
}

template <class Type>
Type fieldOf(const Record& json, const std::filesystem::path& path, const char* key) {
  try {
    return json.at(key).get<Type>();
  } catch (const Record::exception&) {
    throw std::runtime_error(path.string() + ": \"" + key + "\" is missing, or of another type");
  }
}

Record judge(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "scene.json";
  const Record json = readJson(path);
  if (fieldOf<std::string>(json, path, "format") != kExchangeFormat)
    throw std::runtime_error(path.string() + ": \"format\": \"" + std::string(kExchangeFormat) + "\" is right");
  const auto name = fieldOf<std::string>(json, path, "scene");
  const auto seed = fieldOf<std::uint64_t>(json, path, "seed");
  const auto* const scene = std::ranges::find(kFailureScenes, name, &FailureScene::name);
  if (scene == kFailureScenes.end())
    throw std::runtime_error(path.string() + ": \"scene\": there is none called " + name);
  if (!isExchanged(scene->concern))
    throw std::runtime_error(path.string() + ": \"scene\": " + name + " can only be judged live");
  Record record{{"method", fieldOf<std::string>(json, path, "method")}, {"scene", name}, {"seed", seed}};
  runOrExplain(record, [&] {
    Playback playback(folder, json.value("turns_mirrored_over", false));
    Random random = scene->random(seed);
    const SceneResult result = scene->run(playback, random);
    playback.mustBeAtEnd();
    record.update(result.measures);
    record["pass"] = result.pass;
  });
  return record;
}

/// Is the verdict that of a run's? What stopped a method is not in the files: only that it was stopped.
bool agree(const Record& judged, const Record& live) {
  if (judged.at("pass") != live.value("pass", Record())) return false;
  if (live.contains("fault") || judged.at("pass").is_null()) return true;
  return std::ranges::all_of(judged.items(),
                             [&](const auto& of) { return live.value(of.key(), Record()) == of.value(); });
}

}  // namespace

bool runJudge(const JudgeOptions& options) {
  std::vector<std::filesystem::path> folders;
  if (exists(options.folder / "scene.json")) {
    folders.push_back(options.folder);
  } else {
    for (const auto& entry : std::filesystem::directory_iterator(options.folder)) {
      if (exists(entry.path() / "scene.json")) folders.push_back(entry.path());
    }
  }
  if (folders.empty())
    throw std::runtime_error(options.folder.string() + ": holds no scene.json, nor a folder that does");
  std::ranges::sort(folders);
  std::vector<Record> records;
  bool good = true;
  for (const auto& folder : folders) {
    Record record = judge(folder);
    const char* against = "";
    bool right = record.at("pass") != Record(false);
    if (exists(folder / "verdict.json")) {
      right = agree(record, readJson(folder / "verdict.json"));
      against = right ? ", as in verdict.json" : ", OTHER than in verdict.json";
    }
    good = good && right;
    const char* const verdict = record.at("pass").is_null() ? "n/a " : record.at("pass") ? "pass" : "FAIL";
    std::printf("%s%s  %s\n", verdict, against, measuresText(record).c_str());
    records.push_back(std::move(record));
  }
  writeRecords(options.out, "judge", records);
  return good;
}

}  // namespace haptics::eval
