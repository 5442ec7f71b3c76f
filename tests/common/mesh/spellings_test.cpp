#include <cstdlib>

#include "mesh_files.h"
#include "spelling.h"

// A file that is written in another way holds the same mesh. The judge is the solid in memory.
namespace haptics::spellings_test {
namespace {

using fixture::PlainSolid;
using fixture::Spelling;
using fixture::SpeltFile;

constexpr std::uint64_t kSpellings = 5000;

/// Another seed, or one file alone: HAPTICS_SEED.
std::uint64_t firstSeed() {
  const char* const seed = std::getenv("HAPTICS_SEED");
  return seed == nullptr ? 1 : std::strtoull(seed, nullptr, 10);
}

class SpellingsOf : public fixture::MeshFiles {
 protected:
  template <class Write>
  static void expectTheSolid(const std::string& name, Write write) {
    const TriMesh solids[] = {PlainSolid::mesh(false), PlainSolid::mesh(true)};
    int wrong = 0;
    std::uint64_t ambiguous = 0;
    for (std::uint64_t seed = firstSeed(); seed < firstSeed() + kSpellings && wrong < 5; ++seed) {
      Spelling spelling(seed);
      const SpeltFile file = write(spelling);
      const auto imported = import(name, file.bytes);
      const bool same = imported && imported->mesh == solids[file.areStrips ? 1 : 0] &&
                        imported->report.linesSkipped == file.linesSkipped &&
                        imported->report.headerLinesSkipped == file.headerLinesSkipped;
      const bool isRefused =
          !imported && file.mayBeAmbiguous && imported.error().reason.find("in more than one way") != std::string::npos;
      ambiguous += isRefused ? 1 : 0;
      if (same || isRefused) continue;
      ++wrong;
      ADD_FAILURE() << "seed " << seed << ", " << spelling.made() << ": "
                    << (imported ? imported->report.text() : imported.error().text()) << "\n"
                    << file.bytes.substr(0, 3000);
    }
    EXPECT_LT(ambiguous, kSpellings / 100);
  }

  /// The refusal has the line of the word that is no number, and the word.
  template <class Write>
  static void expectTheLine(const std::string& name, Write write) {
    int wrong = 0;
    for (std::uint64_t seed = firstSeed(); seed < firstSeed() + kSpellings && wrong < 5; ++seed) {
      Spelling spelling(seed);
      const SpeltFile file = write(spelling);
      const std::size_t at = file.bytes.find(fixture::kBadWord);
      ASSERT_NE(at, file.bytes.npos);
      std::size_t line = 1;
      for (std::size_t i = 0; i < at; ++i) {
        line += file.bytes[i] == '\n' || (file.bytes[i] == '\r' && file.bytes[i + 1] != '\n') ? 1 : 0;
      }
      const std::string reason = refusal(name, file.bytes);
      if (reason.starts_with("line " + std::to_string(line) + ": ") &&
          reason.find('"' + std::string(fixture::kBadWord) + '"') != reason.npos)
        continue;
      ++wrong;
      ADD_FAILURE() << "seed " << seed << ", " << spelling.made() << ": should name line " << line << ": " << reason
                    << "\n"
                    << file.bytes.substr(0, 3000);
    }
  }
};

TEST_F(SpellingsOf, ObjAreTheSameSolid) {
  expectTheSolid("t.obj", [](Spelling& s) { return fixture::speltObj(s, false); });
}
TEST_F(SpellingsOf, StlAreTheSameSolid) {
  expectTheSolid("t.stl", [](Spelling& s) { return fixture::speltStl(s, false); });
}
TEST_F(SpellingsOf, PlyAreTheSameSolid) {
  expectTheSolid("t.ply", [](Spelling& s) { return fixture::speltPly(s, false); });
}
TEST_F(SpellingsOf, OffAreTheSameSolid) {
  expectTheSolid("t.off", [](Spelling& s) { return fixture::speltOff(s, false); });
}
TEST_F(SpellingsOf, BinaryStlAreTheSameSolid) { expectTheSolid("t.stl", fixture::speltBinaryStl); }
TEST_F(SpellingsOf, BinaryPlyAreTheSameSolid) { expectTheSolid("t.ply", fixture::speltBinaryPly); }

TEST_F(SpellingsOf, ObjNameTheLineOfADamage) {
  expectTheLine("t.obj", [](Spelling& s) { return fixture::speltObj(s, true); });
}
TEST_F(SpellingsOf, StlNameTheLineOfADamage) {
  expectTheLine("t.stl", [](Spelling& s) { return fixture::speltStl(s, true); });
}
TEST_F(SpellingsOf, PlyNameTheLineOfADamage) {
  expectTheLine("t.ply", [](Spelling& s) { return fixture::speltPly(s, true); });
}
TEST_F(SpellingsOf, OffNameTheLineOfADamage) {
  expectTheLine("t.off", [](Spelling& s) { return fixture::speltOff(s, true); });
}

}  // namespace
}  // namespace haptics::spellings_test
