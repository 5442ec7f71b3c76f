#include "tests/eval/fuzz/contact_judge.h"

#include <algorithm>
#include <cmath>

namespace haptics::eval {
namespace {

std::vector<TriangleIndices> allTriangles(const FuzzMesh& mesh) {
  std::vector<TriangleIndices> all = mesh.triangles;
  all.insert(all.end(), mesh.missing.begin(), mesh.missing.end());
  return all;
}

/// Of a plate its upper face alone, as a sheet.
FuzzMesh upperFace(const FuzzMesh& plate) {
  FuzzMesh sheet;
  sheet.vertices = plate.vertices;
  sheet.triangles.assign(plate.triangles.begin(), plate.triangles.begin() + static_cast<std::ptrdiff_t>(plate.upper));
  sheet.missing = coneOverBoundary(sheet.vertices, sheet.triangles);
  constexpr float kFarBelow_m = 0.5F;  // a cone near the face would be passed with it
  sheet.vertices.back().z -= kFarBelow_m;
  return sheet;
}

}  // namespace

ContactJudge::Sheet::Sheet(const FuzzMesh& mesh, Vec3 hip)
    : closed_(mesh.vertices, allTriangles(mesh)),
      gap_(mesh.vertices, mesh.missing),
      side_(closed_.side(hip)),
      hip_(hip),
      ihip_(hip) {}

bool ContactJudge::Sheet::crosses(Vec3 hip, Vec3 ihip, bool depenetrated) {
  // Twice: bodies that move may push the IHIP away from the HIP for a part of the tick.
  const double reach = 2 * (glm::distance(ihip_, hip_) + glm::distance(ihip, hip) + glm::distance(hip_, hip) +
                            glm::distance(ihip_, ihip)) +
                       closed_.rounding_m();
  hip_ = hip;
  ihip_ = ihip;
  before_ = side_;
  nearGap_ = nearGap_ || gap_.isNear(hip, reach);
  const SolidOracle::Side side = closed_.side(ihip);
  if (side == SolidOracle::Side::kOnSurface) {
    if (depenetrated) side_ = side;
    return false;
  }
  const bool changed = side_ != SolidOracle::Side::kOnSurface && side != side_;
  const bool crossed = changed && !nearGap_;
  side_ = side;
  nearGap_ = false;
  return crossed;
}

ContactJudge::ContactJudge(const std::vector<FuzzMesh>& meshes, const ContactFrame& first) : last_(first.hip) {
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    Judged& judged = bodies_.emplace_back();
    if (meshes[i].closed()) {
      judged.solid.emplace(meshes[i].vertices, meshes[i].triangles);
      if (meshes[i].upper > 0) judged.sheet.emplace(upperFace(meshes[i]), toLocal(first.poses[i], first.hip));
    } else {
      judged.sheet.emplace(meshes[i], toLocal(first.poses[i], first.hip));
    }
    if (judged.sheet) {
      rounding_m_ = std::max(rounding_m_, judged.sheet->rounding_m());
    }
  }
}

ContactVerdict ContactJudge::judge(const ContactFrame& frame, Vec3 ihip, bool depenetrated) {
  ContactVerdict verdict;
  verdict.finite = isFinite(ihip);
  if (!verdict.finite) return verdict;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Vec3 local = toLocal(frame.poses[i], ihip);
    const double depth_m = bodies_[i].solid ? bodies_[i].solid->depth_m(local) : 0;
    if (depth_m > rounding_m_) verdict.inside_m = std::max(verdict.inside_m, depth_m);
    if (bodies_[i].sheet && bodies_[i].sheet->crosses(toLocal(frame.poses[i], frame.hip), local, depenetrated))
      verdict.crossed = true;
  }
  if (flat_) verdict.aside_m = asideOnFlat(frame, ihip);
  verdict.hadRoom = verdict.crossed && depenetrated && hadRoom(frame);
  last_ = ihip;
  return verdict;
}

bool ContactJudge::hadRoom(const ContactFrame& frame) const {
  constexpr int kPlaces = 3000;
  constexpr double kFarthest_m = 2e-4;
  Random random(1);
  for (int i = 0; i < kPlaces; ++i) {
    const Vec3 place = last_ + kFarthest_m * std::pow(100, random.between(-1, 0)) * random.direction();
    bool fits = true;
    for (std::size_t k = 0; k < bodies_.size() && fits; ++k) {
      const Vec3 local = toLocal(frame.poses[k], place);
      fits = (!bodies_[k].solid || bodies_[k].solid->side(local) == SolidOracle::Side::kOutside) &&
             (!bodies_[k].sheet || bodies_[k].sheet->wasOnSideOf(local));
    }
    if (fits) return true;
  }
  return false;
}

bool ContactJudge::isFree(const ContactFrame& frame, Vec3 place) const {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Vec3 local = toLocal(frame.poses[i], place);
    if (bodies_[i].sheet && !bodies_[i].sheet->isOnSideOf(local)) return false;
    if (bodies_[i].solid && bodies_[i].solid->side(local) == SolidOracle::Side::kInside) return false;
  }
  return true;
}

bool ContactJudge::leadsAway(const ContactFrame& frame, double longest_m, double off_m, Random& random) const {
  constexpr int kMaxInVain = 40;
  Vec3 at = last_;
  double step_m = longest_m;
  for (int inVain = 0; step_m > longest_m / 16;) {
    const Vec3 way = frame.hip - at;
    const double depth_m = glm::length(way);
    if (depth_m < longest_m) break;
    const Vec3 down = way / depth_m;
    const Vec3 any = random.direction();
    const Vec3 aside = glm::normalize(any - glm::dot(any, down) * down);  // in equilibrium the way down is closed
    const Vec3 to = at + step_m * glm::normalize(aside + std::pow(random.between(0, 1), 3) * down);
    if (glm::distance(to, frame.hip) < depth_m && isFree(frame, to)) {
      at = to;
      inVain = 0;
      if (glm::distance(at, last_) > off_m) return true;
    } else if (++inVain == kMaxInVain) {
      step_m /= 2;
      inVain = 0;
    }
  }
  return glm::distance(at, last_) > off_m;
}

bool ContactJudge::isAtRest(const ContactFrame& frame, double off_m, Random& random) const {
  return !leadsAway(frame, 2e-5, off_m, random) || !leadsAway(frame, 1e-6, off_m, random);
}

double ContactJudge::asideOnFlat(const ContactFrame& frame, Vec3 ihip) {
  constexpr double kOn_m = 2e-6;
  constexpr double kDeepest_m = 0.012;  // of a HIP: bodies are thicker
  constexpr double kRim = 1.5;          // of its depth: else the rim is as near
  const Pose& first = frame.poses.front();
  const Vec3 hip = toLocal(flat_->inFirst, toLocal(first, frame.hip)),
             at = toLocal(flat_->inFirst, toLocal(first, ihip));
  const auto isWithin = [&](Vec3 p, double rim_m) {
    return p.x > flat_->low.x + rim_m && p.x < flat_->high.x - rim_m && p.y > flat_->low.y + rim_m &&
           p.y < flat_->high.y - rim_m;
  };
  const bool isKnown = wasOnFlat_ && hip.z < 0 && hip.z > -kDeepest_m && isWithin(hip, -kRim * hip.z);
  const double aside_m = std::hypot(at.x - hip.x, at.y - hip.y);
  wasOnFlat_ = at.z > -kOn_m && isWithin(at, kOn_m) && isWithin(hip, std::abs(hip.z));
  return isKnown ? aside_m : 0;
}

bool ContactJudge::isOutside(const std::vector<FuzzMesh>& meshes, const ContactFrame& frame) {
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    if (!meshes[i].closed()) continue;
    if (SolidOracle(meshes[i].vertices, meshes[i].triangles).depth_m(toLocal(frame.poses[i], frame.hip)) > 0)
      return false;
  }
  return true;
}

}  // namespace haptics::eval
