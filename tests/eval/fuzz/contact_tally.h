#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "haptic_server/engine/contact/contact.h"
#include "tests/eval/fuzz/contact_judge.h"
#include "tests/eval/fuzz/duration_histogram.h"
#include "tests/eval/report.h"

namespace haptics::eval {

enum class ContactFailure {
  kInside,    ///< In a tick that does not say that it put the IHIP out, or in a second tick running.
  kCrossing,  ///< Of a sheet, in a tick that does not say that it put the IHIP out, or where that had room on this side.
  kNotFinite,
  kAside,  ///< Where the surface is flat, by what is felt as a force along it (kFeltAside_m), though the tick's allowance lasted.
};
/// 0.01 N of a spring of 1,000 N/m.
inline constexpr double kFeltAside_m = 1e-5;
[[nodiscard]] std::string_view nameOf(ContactFailure failure);

/// Says of a run of verdicts, tick by tick, which of them fail.
class ContactRule {
 public:
  [[nodiscard]] std::optional<ContactFailure> apply(const ContactVerdict& verdict, const ContactWork& work);
  /// Ticks inside, up to the last one.
  [[nodiscard]] std::int64_t insideInARow() const noexcept { return insideInARow_; }

 private:
  std::int64_t insideInARow_ = 0;
};

/// What was counted over scenes.
class ContactTally {
 public:
  /// `insideInARow` as ContactRule has it after this tick.
  void add(const ContactResult& result, const ContactVerdict& verdict, std::int64_t insideInARow, double duration_ns);
  void addScene(bool failed) {
    ++scenes_;
    failedScenes_ += failed ? 1 : 0;
  }
  [[nodiscard]] Record record() const;
  [[nodiscard]] std::int64_t ticks() const noexcept { return ticks_; }

 private:
  std::int64_t scenes_ = 0;
  std::int64_t failedScenes_ = 0;
  std::int64_t ticks_ = 0;
  std::int64_t touching_ = 0;
  std::int64_t inside_ = 0;
  std::int64_t insideNotDepenetrated_ = 0;
  std::int64_t episodes_ = 0;
  std::int64_t longestEpisode_ = 0;
  std::int64_t depenetrated_ = 0;
  std::int64_t notConverged_ = 0;
  std::int64_t crossings_ = 0;
  std::int64_t crossingsDepenetrated_ = 0;
  std::int64_t notFinite_ = 0;
  std::int64_t aside_ = 0;
  std::int64_t asideWaiting_ = 0;
  std::int64_t waiting_ = 0;
  double deepest_m_ = 0;
  int maxTriangles_ = 0;
  int maxSegments_ = 0;
  int maxSolverRounds_ = 0;
  int maxSteps_ = 0;
  DurationHistogram durations_;
};

}  // namespace haptics::eval
