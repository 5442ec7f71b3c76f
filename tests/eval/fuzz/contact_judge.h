#pragma once

#include <optional>
#include <vector>

#include "tests/eval/fuzz/contact_motion.h"
#include "tests/eval/fuzz/solid_oracle.h"

namespace haptics::eval {

/// What is wrong with the IHIP of a tick.
struct ContactVerdict {
  double inside_m = 0;   ///< Depth in a closed body, judged by its winding number; 0 outside of all.
  bool crossed = false;  ///< It is on the other side of a sheet and has not gone round its rim.
  /// It crossed in a tick that says that it put the IHIP outside, though there was room for it: a place within 0.2 mm of the
  /// last one that is outside of all closed bodies, and on the side of every sheet that it was on.
  bool hadRoom = false;
  bool finite = true;
  double aside_m = 0;  ///< From the exact place on a FlatTop, along it; 0 where none is known.
};

/// Judges the IHIP of each tick by triangles alone: solid angles and distances. Of the contact core it knows nothing.
class ContactJudge {
 public:
  ContactJudge(const std::vector<FuzzMesh>& meshes, const ContactFrame& first);

  /// @param depenetrated  The core says that it put the IHIP outside: the sides that it is on now are taken as they are.
  [[nodiscard]] ContactVerdict judge(const ContactFrame& frame, Vec3 ihip, bool depenetrated = false);
  /// Judges the place on it, too: of an IHIP that was on it in the last tick, the one right above the HIP.
  void expect(const FlatTop& flat) { flat_ = flat; }
  /// Is the IHIP of the tick that was judged last in equilibrium, to within `off_m`? It is not where steps, drawn at random, each
  /// of them nearer to the HIP, outside of all closed bodies, and on the side of every sheet that it is on, lead farther from
  /// it, of 20 um and less, and of a micrometre and less, which pass no ridge.
  [[nodiscard]] bool isAtRest(const ContactFrame& frame, double off_m, Random& random) const;
  /// Is no closed body around a point of the world?
  [[nodiscard]] static bool isOutside(const std::vector<FuzzMesh>& meshes, const ContactFrame& frame);

 private:
  /// A sheet or an open scan. It is closed by what it is missing, so that it has an inside; the side of the IHIP may
  /// change only through the gap. A path that brings the IHIP nearer to the HIP stays in the ball about the HIP that
  /// it begins on the rim of: where no part of the gap is in the ball, nothing goes round.
  class Sheet {
   public:
    Sheet(const FuzzMesh& mesh, Vec3 hip);
    [[nodiscard]] bool crosses(Vec3 hip, Vec3 ihip, bool depenetrated);  ///< In the mesh's frame.
    [[nodiscard]] double rounding_m() const noexcept { return closed_.rounding_m(); }
    /// Is a place of its frame on the side that the IHIP is known to be on,
    [[nodiscard]] bool isOnSideOf(Vec3 place) const {
      return side_ != SolidOracle::Side::kOnSurface && (closed_.side(place) == side_);
    }
    /// or was, a tick before?
    [[nodiscard]] bool wasOnSideOf(Vec3 place) const {
      return before_ == SolidOracle::Side::kOnSurface || closed_.side(place) == before_;
    }

   private:
    SolidOracle closed_;
    SolidOracle gap_;
    SolidOracle::Side side_;                                    // the last that was certain; kOnSurface: none is
    SolidOracle::Side before_ = SolidOracle::Side::kOnSurface;  // the same, a tick ago
    bool nearGap_ = false;                                      // since then
    Vec3 hip_;                                                  // of the last tick, as is the next
    Vec3 ihip_;
  };
  [[nodiscard]] double asideOnFlat(const ContactFrame& frame, Vec3 ihip);
  [[nodiscard]] bool hadRoom(const ContactFrame& frame) const;
  [[nodiscard]] bool leadsAway(const ContactFrame& frame, double longest_m, double off_m, Random& random) const;
  [[nodiscard]] bool isFree(const ContactFrame& frame, Vec3 place) const;

  struct Judged {
    std::optional<SolidOracle> solid;
    std::optional<Sheet> sheet;
  };
  std::vector<Judged> bodies_;
  std::optional<FlatTop> flat_;
  bool wasOnFlat_ = false;
  Vec3 last_;              // IHIP
  double rounding_m_ = 0;  // of the largest sheet's vertices: an IHIP that it holds is as deep in what touches it there
};

}  // namespace haptics::eval
