#include <cstdio>

#include "tests/eval/fuzz/contact_finding.h"
#include "tests/eval/fuzz/edit_finding.h"
#include "tests/eval/fuzz/fuzz.h"

namespace haptics::eval {
namespace {

bool replayEdits(const std::filesystem::path& folder, const std::filesystem::path& out) {
  const EditRun run = readRun(folder);
  const std::optional<EditFinding> finding = findFailure(run);
  Record record{{"fuzz", "edits"}, {"scene", folder.filename().string()}, {"windows", run.windows.size()}};
  if (finding) {
    const EditVerdict& verdict = finding->verdict;
    record.update({{"failure", nameOf(finding->failure)},
                   {"edit", run.windows[finding->window].edit},
                   {"step_N", verdict.step_N},
                   {"tick", verdict.tick},
                   {"inside_mm", verdict.inside_m * 1e3},
                   {"missing_N", verdict.missing_N}});
  }
  record["pass"] = !finding;
  std::printf("%s\n", measuresText(record).c_str());
  writeRecords(out, "fuzz", {record});
  return !finding;
}

}  // namespace

bool runFuzzReplay(const std::filesystem::path& folder, const std::filesystem::path& out) {
  if (isRun(folder)) return replayEdits(folder, out);
  const ContactMotion motion = readMotion(folder);
  ContactTally tally;
  const std::optional<ContactFinding> finding = findFailure(motion, &tally);
  tally.addScene(finding.has_value());
  Record record{{"fuzz", "contact"}, {"scene", folder.filename().string()}, {"bodies", motion.meshes.size()}};
  if (finding) {
    record["failure"] = nameOf(finding->failure);
    record["tick"] = finding->frame;
    record["inside_mm"] = finding->inside_m * 1e3;
  }
  record.update(tally.record());
  std::printf("%s\n", measuresText(record).c_str());
  writeRecords(out, "fuzz", {record});
  return !finding;
}

}  // namespace haptics::eval
