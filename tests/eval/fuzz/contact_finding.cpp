#include "tests/eval/fuzz/contact_finding.h"

#include <algorithm>

namespace haptics::eval {
namespace {

ContactMotion withoutBody(const ContactMotion& motion, std::size_t body) {
  ContactMotion less = motion;
  const auto at = static_cast<std::ptrdiff_t>(body);
  less.meshes.erase(less.meshes.begin() + at);
  for (ContactFrame& frame : less.frames) frame.poses.erase(frame.poses.begin() + at);
  return less;
}

ContactMotion fromFrame(const ContactMotion& motion, std::size_t first) {
  ContactMotion less = motion;
  less.frames.erase(less.frames.begin(), less.frames.begin() + static_cast<std::ptrdiff_t>(first));
  return less;
}

bool failsSo(const ContactMotion& motion, ContactFailure failure) {
  return findFailure(motion, nullptr, failure).has_value();
}

void dropBodies(ContactMotion& motion, ContactFailure failure) {
  if (motion.flat) return;  // which they make together
  for (std::size_t i = motion.meshes.size(); i-- > 0 && motion.meshes.size() > 1;) {
    ContactMotion less = withoutBody(motion, i);
    if (failsSo(less, failure)) motion = std::move(less);
  }
}

/// Begins as late as it can where the HIP is outside of everything, as it is where a motion begins.
void dropFirstFrames(ContactMotion& motion, ContactFailure failure) {
  constexpr std::size_t kTries = 64;
  const std::size_t stride = std::max<std::size_t>(1, motion.frames.size() / kTries);
  for (std::size_t first = motion.frames.size() - 2; first >= stride; first -= stride) {
    if (!ContactJudge::isOutside(motion.meshes, motion.frames[first])) continue;
    ContactMotion less = fromFrame(motion, first);
    if (!failsSo(less, failure)) continue;
    motion = std::move(less);
    return;
  }
}

}  // namespace

std::optional<ContactFinding> findFailure(const ContactMotion& motion, ContactTally* tally,
                                          std::optional<ContactFailure> kind) {
  std::optional<ContactFinding> first;
  ContactDrive drive(motion.meshes, motion.frames.front());
  ContactJudge judge(motion.meshes, motion.frames.front());
  if (motion.flat) judge.expect(*motion.flat);
  ContactRule rule;
  for (std::size_t i = 1; i < motion.frames.size(); ++i) {
    const ContactResult& result = drive.tick(motion.frames[i]);
    const ContactVerdict verdict = judge.judge(motion.frames[i], result.ihip, result.work.depenetrated);
    const auto failure = rule.apply(verdict, result.work);
    if (tally != nullptr) tally->add(result, verdict, rule.insideInARow(), drive.duration_ns());
    if (failure && !first && (!kind || failure == kind)) {
      first = {*failure, i, verdict.inside_m};
      if (tally == nullptr) break;
    }
  }
  return first;
}

ContactMotion reduced(ContactMotion motion, const ContactFinding& finding) {
  constexpr std::size_t kAfterwards = 20;  // ticks, to see how it goes on
  motion.frames.resize(std::min(motion.frames.size(), finding.frame + 1 + kAfterwards));
  dropBodies(motion, finding.failure);
  dropFirstFrames(motion, finding.failure);
  dropBodies(motion, finding.failure);
  return motion;
}

}  // namespace haptics::eval
