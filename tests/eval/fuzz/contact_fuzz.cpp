#include "tests/eval/fuzz/contact_fuzz.h"

#include <array>
#include <chrono>
#include <cstdio>
#include <sstream>
#include <string>

#include "tests/eval/adapters/outside_method.h"
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

/// Another method in the place of the contact core.
class MethodDrive {
 public:
  MethodDrive(std::unique_ptr<Renderer> method, const std::vector<FuzzMesh>& meshes, const ContactFrame& first)
      : method_(std::move(method)) {
    std::vector<std::shared_ptr<const CollisionMesh>> surfaces;
    for (const FuzzMesh& mesh : meshes) surfaces.push_back(mesh.build());
    method_->begin(surfaces, first.poses, first.hip);
  }

  const ContactResult& tick(const ContactFrame& frame) {
    const auto begin = std::chrono::steady_clock::now();
    const Felt felt = method_->tick(frame.poses, frame.hip);
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - begin;
    duration_ns_ = ownTime_ns(*method_).value_or(taken.count());
    result_ = {};
    result_.touching = felt.touching;
    result_.ihip = felt.touching ? felt.ihip : frame.hip;
    result_.work.triangles = felt.triangles;
    const auto* const outside = dynamic_cast<const OutsideRenderer*>(method_.get());
    result_.work.depenetrated = outside != nullptr && outside->putOutside();
    return result_;
  }
  [[nodiscard]] double duration_ns() const noexcept { return duration_ns_; }

 private:
  std::unique_ptr<Renderer> method_;
  ContactResult result_;
  double duration_ns_ = 0;
};

/// A scene and how the HIP went in it, led by where `drive(meshes, first frame)` has the IHIP.
template <class MakeDrive>
ContactMotion record(std::uint64_t seed, ContactSceneKind kind, MakeDrive makeDrive, ContactTally& tally,
                     std::optional<ContactFinding>& finding) {
  ContactScene scene(seed, kind);
  ContactMotion motion{scene.meshes(), {scene.frame()}, scene.flat()};
  auto drive = makeDrive(motion.meshes, scene.frame());
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
  ContactFuzz(const FuzzOptions& options, const std::filesystem::path& out, const Method* method)
      : options_(options), out_(out), method_(method) {}

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
    Record why{{"fuzz", "contact"}, {"scene", nameOf(kind)}, {"seed", seed}};
    const bool ended = runOrExplain(why, [&] {
      std::optional<ContactFinding> finding;
      const ContactMotion motion = recordScene(seed, kind, finding);
      if (finding) keep(seed, kind, motion, *finding);
    });
    if (ended) return;
    if (why["pass"].is_null()) {
      ++notApplicable_;
      return;
    }
    ++found_;
    showFinding(why);
    findings_.push_back(std::move(why));
  }

  ContactMotion recordScene(std::uint64_t seed, ContactSceneKind kind, std::optional<ContactFinding>& finding) {
    using Meshes = std::vector<FuzzMesh>;
    const auto core = [](const Meshes& meshes, const ContactFrame& first) { return ContactDrive(meshes, first); };
    const auto other = [this](const Meshes& meshes, const ContactFrame& first) {
      return MethodDrive(method_->make(), meshes, first);
    };
    return method_ == nullptr ? record(seed, kind, core, tallyOf(kind), finding)
                              : record(seed, kind, other, tallyOf(kind), finding);
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
      const ContactMotion less = method_ == nullptr ? reduced(motion, finding) : motion;
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
    if (notApplicable_ > 0) std::printf(", %d not applicable", notApplicable_);
    if (found_ > kMaxRecordings) std::printf("; %d of them without a recording", found_ - kMaxRecordings);
    std::printf("\n");
  }

  const FuzzOptions& options_;
  const std::filesystem::path& out_;
  const Method* method_;  // null: the contact core
  Interruption interruption_;
  std::vector<OfKind> tallies_;
  std::vector<Record> findings_;
  int found_ = 0;
  int notApplicable_ = 0;
};

}  // namespace

bool runFuzzContact(const FuzzOptions& options, const std::filesystem::path& out) {
  return ContactFuzz(options, out, nullptr).run();
}

bool runFuzzContactOf(const Method& method, const FuzzOptions& options, const std::filesystem::path& out) {
  return ContactFuzz(options, out, &method).run();
}

}  // namespace haptics::eval
