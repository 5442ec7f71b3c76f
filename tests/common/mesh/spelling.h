#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "common/mesh/import.h"

namespace haptics::fixture {

/// A way in which a file of a format may be written, drawn at random: of each of the format's transformations, whether it
/// is made, and how.
class Spelling {
 public:
  explicit Spelling(std::uint64_t seed) : random_(seed) {}

  [[nodiscard]] int upTo(int most) { return std::uniform_int_distribution(0, most)(random_); }
  [[nodiscard]] bool oneIn(int n) { return upTo(n - 1) == 0; }
  template <class T>
  [[nodiscard]] T oneOf(std::initializer_list<T> those) {
    return *(those.begin() + upTo(static_cast<int>(those.size()) - 1));
  }
  /// Whether the transformation is made in this file; asked once a file.
  [[nodiscard]] bool has(const std::string& transformation);
  /// Those that are made, for a message.
  [[nodiscard]] const std::string& made() const { return made_; }

  [[nodiscard]] std::string number(double value);
  [[nodiscard]] std::string blank();
  [[nodiscard]] std::string inAnyCase(std::string word);
  [[nodiscard]] std::string comment();

  // Drawn by begin(), the same all over a file.
  void begin();
  std::string lineEnd;
  bool spellsNumbers = false, hasBlanks = false, hasAnyCase = false;

  /// What may be in front of a text and after it.
  [[nodiscard]] std::string wrapped(std::string text);

 private:
  std::mt19937_64 random_;
  std::string made_;
};

/// A number in the text that is no number any more.
inline constexpr const char* kBadWord = "4.0D+01";

/// A file; and what of it a reader has to say that it left out.
struct SpeltFile {
  std::string bytes;
  std::uint64_t headerLinesSkipped = 0, linesSkipped = 0;
  bool mayBeAmbiguous = false;
  bool areStrips = false;  ///< A strip for each quadrilateral.
};

/// An L-shaped solid of 10 quadrilaterals, whose coordinates are float32 exactly.
struct PlainSolid {
  static const std::vector<Vec3>& vertices();
  static const std::vector<std::array<std::uint32_t, 4>>& faces();
  static TriMesh mesh(bool asStrips);
};

/// The solid. `damaged`: one coordinate is kBadWord.
SpeltFile speltObj(Spelling& spelling, bool damaged);
SpeltFile speltStl(Spelling& spelling, bool damaged);
SpeltFile speltPly(Spelling& spelling, bool damaged);
SpeltFile speltOff(Spelling& spelling, bool damaged);
SpeltFile speltBinaryStl(Spelling& spelling);
SpeltFile speltBinaryPly(Spelling& spelling);

}  // namespace haptics::fixture
