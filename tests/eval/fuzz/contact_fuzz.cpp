#include <array>
#include <cstdio>
#include <sstream>
#include <string>

#include "tests/eval/fuzz/contact_finding.h"
#include "tests/eval/fuzz/contact_scene.h"
#include "tests/eval/fuzz/fuzz.h"
#include "tests/eval/table1/interruption.h"

namespace haptics::eval {
namespace {

constexpr int kTicks = 2000;  ///< Of a scene.
constexpr int kMaxRecordings = 20;
constexpr std::uint64_t kProgress = 1000;  ///< Scenes from one line about it to the next.
constexpr std::array kSpeeds_m_per_s{1.0, 4.0};

std::string nameOf(ContactSceneKind kind) {
  std::ostringstream name;
  if (kind.world != ContactWorld::kWild) name << kContactWorlds[static_cast<std::size_t>(kind.world)] << '_';
  name << (kind.moving ? "moving_" : "rest_") << kind.speed_m_per_s << "_m_per_s";
  return name.str();
}

/// All kinds by turns, from seed to seed, of those that were asked for.
ContactSceneKind kindOf(std::uint64_t seed, const FuzzOptions& options) {
  const auto byTurns = static_cast<ContactWorld>(seed / 4 % kContactWorlds.size());
  return {options.moving.value_or(seed % 2 == 1), options.speed_m_per_s.value_or(kSpeeds_m_per_s[seed / 2 % 2]),
          options.world.value_or(byTurns)};
}

/// A scene and how the HIP went in it.
ContactMotion record(std::uint64_t seed, ContactSceneKind kind, ContactTally& tally,
                     std::optional<ContactFinding>& finding) {
  ContactScene scene(seed, kind);
  ContactMotion motion{scene.meshes(), {scene.frame()}, scene.flat()};
  ContactDrive drive(motion.meshes, scene.frame());
  ContactJudge judge(motion.meshes, scene.frame());
  if (motion.flat) judge.expect(*motion.flat);
  ContactRule rule;
  Vec3 ihip = scene.frame().hip;
  for (int tick = 1; tick <= kTicks; ++tick) {
    motion.frames.push_back(scene.next(ihip));
    const ContactResult& result = drive.tick(scene.frame());
    const ContactVerdict verdict = judge.judge(scene.frame(), result.ihip, result.work.depenetrated);
    const auto failure = rule.apply(verdict, result.work);
    tally.add(result, verdict, rule.insideInARow(), drive.duration_ns());
    if (failure && !finding) finding = {*failure, static_cast<std::size_t>(tick), verdict.inside_m};
    if (!verdict.finite) break;  // nothing leads the HIP any more
    ihip = result.ihip;
  }
  tally.addScene(finding.has_value());
  return motion;
}

class ContactFuzz {
 public:
  ContactFuzz(const FuzzOptions& options, const std::filesystem::path& out) : options_(options), out_(out) {}

  [[nodiscard]] bool run() {
    std::uint64_t done = 0;
    for (; done < options_.scenes && !interruption_.came(); ++done) {
      runScene(options_.seed + done);
      if ((done + 1) % kProgress == 0) {
        std::fprintf(stderr, "%llu of %llu scenes, %d failed\n", static_cast<unsigned long long>(done + 1),
                     static_cast<unsigned long long>(options_.scenes), found_);
      }
    }
    report(done);
    return found_ == 0;
  }

 private:
  struct OfKind {
    ContactSceneKind kind;
    ContactTally tally;
  };

  ContactTally& tallyOf(ContactSceneKind kind) {
    for (OfKind& known : tallies_) {
      if (nameOf(known.kind) == nameOf(kind)) return known.tally;
    }
    return tallies_.emplace_back(OfKind{kind, {}}).tally;
  }

  void runScene(std::uint64_t seed) {
    const ContactSceneKind kind = kindOf(seed, options_);
    std::optional<ContactFinding> finding;
    const ContactMotion motion = record(seed, kind, tallyOf(kind), finding);
    if (finding) keep(seed, kind, motion, *finding);
  }

  void keep(std::uint64_t seed, ContactSceneKind kind, const ContactMotion& motion, const ContactFinding& finding) {
    Record record{{"fuzz", "contact"},
                  {"scene", nameOf(kind)},
                  {"seed", seed},
                  {"failure", nameOf(finding.failure)},
                  {"tick", finding.frame},
                  {"bodies", motion.meshes.size()},
                  {"inside_mm", finding.inside_m * 1e3}};
    if (found_++ < kMaxRecordings) {
      const std::string folder = "fuzz-" + std::string(nameOf(finding.failure)) + '-' + std::to_string(seed);
      const ContactMotion less = reduced(motion, finding);
      writeMotion(less, out_ / folder);
      record["recording"] = folder;
      record["recording_bodies"] = less.meshes.size();
      record["recording_ticks"] = less.frames.size() - 1;
      showFinding(record);
    }
    record["pass"] = false;
    findings_.push_back(std::move(record));
  }

  void report(std::uint64_t done) {
    std::vector<Record> records;
    std::int64_t ticks = 0;
    for (const OfKind& known : tallies_) {
      Record record{{"fuzz", "contact"}, {"scene", nameOf(known.kind)}, {"seed", options_.seed}};
      record.update(known.tally.record());
      std::printf("%s\n", measuresText(record).c_str());
      ticks += known.tally.ticks();
      records.push_back(std::move(record));
    }
    records.insert(records.end(), findings_.begin(), findings_.end());
    writeRecords(out_, "fuzz", records);
    if (interruption_.came()) std::printf("interrupted: this is what was found by then\n");
    std::printf("%llu scenes, %lld ticks, %d scenes failed", static_cast<unsigned long long>(done),
                static_cast<long long>(ticks), found_);
    if (found_ > kMaxRecordings) std::printf("; %d of them without a recording", found_ - kMaxRecordings);
    std::printf("\n");
  }

  const FuzzOptions& options_;
  const std::filesystem::path& out_;
  Interruption interruption_;
  std::vector<OfKind> tallies_;
  std::vector<Record> findings_;
  int found_ = 0;
};

}  // namespace

bool runFuzzContact(const FuzzOptions& options, const std::filesystem::path& out) {
  return ContactFuzz(options, out).run();
}

}  // namespace haptics::eval
