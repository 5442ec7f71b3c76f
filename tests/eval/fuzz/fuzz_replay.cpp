#include <cstdio>

#include "tests/eval/fuzz/contact_finding.h"
#include "tests/eval/fuzz/fuzz.h"

namespace haptics::eval {

bool runFuzzReplay(const std::filesystem::path& folder, const std::filesystem::path& out) {
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
