#include "haptic_server/engine/contact/near_bodies.h"

#include <algorithm>

namespace haptics {
namespace {

/// How far a moving body can push an IHIP that it reaches: the motion, in the body's frame, of HIP and IHIP, twice
/// because both ends of the path move.
double pushReach_m(const Body& body, const ContactState& state, Vec3 hip, double reach) noexcept {
  const double hipMotion = glm::distance(toLocal(body.previous, state.hip), toLocal(body.current, state.hip));
  const double ihipMotion = glm::distance(toLocal(body.previous, state.ihip), toLocal(body.current, state.ihip));
  const double motion = hipMotion + ihipMotion + 2 * glm::length(body.shift);
  const double inReach = body.surface->radius_m() + reach + motion;
  return squaredLength(hip - body.centre) > inReach * inReach ? 0 : 2 * motion;
}

}  // namespace

double reachOf(const ContactState& state, Vec3 hip) noexcept {
  return glm::distance(state.ihip, state.hip) + 2 * glm::distance(hip, state.hip);
}

std::optional<double> squaredGap(const Body& body, Vec3 hip, double reach) noexcept {
  const CollisionMesh& surface = *body.surface;
  const double inReach = surface.radius_m() + reach;
  if (squaredLength(hip - body.centre) > inReach * inReach) return std::nullopt;
  const Vec3 local = body.frame.toLocal(hip);
  const double gap = squaredLength(glm::max(glm::max(surface.low() - local, local - surface.high()), Vec3(0)));
  return gap <= reach * reach ? std::optional(gap) : std::nullopt;
}

void NearBodies::gather(std::span<const Body> bodies, const ContactState& state, Vec3 hip, ContactWork& work) noexcept {
  const std::int64_t once = (Allowance::kPlace + Allowance::kSphere) * static_cast<std::int64_t>(bodies.size());
  work.allowance.spend(once);
  double reach = reachOf(state, hip);
  std::array<bool, kMaxNear> pushes{};
  for (bool isLarger = true; isLarger;) {  // one that pushes may bring another into reach
    isLarger = false;
    bool isLeftOut = false;
    for (std::size_t b = 0; b < std::min(bodies.size(), pushes.size()); ++b) {
      if (!bodies[b].moving || pushes[b]) continue;
      const double push_m = pushReach_m(bodies[b], state, hip, reach);
      pushes[b] = push_m > 0;
      isLarger = isLarger || (pushes[b] && isLeftOut);
      isLeftOut = isLeftOut || !pushes[b];
      reach += push_m;
    }
    isLarger = isLarger && !work.allowance.isSpent();
    if (isLarger) work.allowance.spend(once);
  }
  count_ = 0;
  for (int b = 0; b < static_cast<int>(bodies.size()); ++b) {
    const Body& body = bodies[static_cast<std::size_t>(b)];
    if (state.holds(b)) {
      admit(body, b, -1, work);
      continue;
    }
    if (body.pendingRemoval) continue;
    if (const auto gap = squaredGap(body, hip, reach)) admit(body, b, *gap, work);
  }
  extent_ = 0;
  for (int i = 0; i < count_; ++i) {
    extent_ = std::max(extent_, (*this)[i].surface->extent_m() + glm::length((*this)[i].frame.origin));
  }
}

void NearBodies::admit(const Body& body, int index, double gap, ContactWork& work) noexcept {
  int place = count_;
  if (count_ == kMaxNear) {
    ++work.droppedBodies;
    place = static_cast<int>(std::max_element(gap_.begin(), gap_.end()) - gap_.begin());
    if (gap >= gap_[static_cast<std::size_t>(place)]) return;
  } else {
    ++count_;
  }
  Near& near = (*this)[place];
  near.body = index;
  near.pendingRemoval = body.pendingRemoval;
  near.surface = body.surface;
  near.from = Vec3(0);
  near.frame = body.moving ? Frame(body.previous) : body.frame;
  gap_[static_cast<std::size_t>(place)] = gap;
}

void NearBodies::setTime(std::span<const Body> bodies, double time) noexcept {
  for (int i = 0; i < count_; ++i) {
    const Body& body = bodies[static_cast<std::size_t>((*this)[i].body)];
    if (!body.moving) continue;
    (*this)[i].frame = time >= 1 ? body.frame : Frame(interpolate(body.previous, body.current, time));
  }
}

bool isInGap(std::span<const NearBody> all, const NearBody& near, Vec3 to, const Crossing& rimmed,
             const Crossing& entered, Allowance& allowance) noexcept {
  const CollisionMesh& surface = *near.surface;
  const TriangleRecord& triangle = surface.triangle(rimmed.triangle);
  const Vec3 place = glm::mix(near.from, to, rimmed.time);
  const ClosestPoint foot = closestOn(triangle, rimmed.triangle, place);
  const double distance = std::sqrt(foot.squaredDistance);
  if (distance == 0) return true;
  const double rim_m = kRim * surface.extent_m();
  const Vec3 away = near.frame.rotate((place - foot.point) * (2 * rim_m / distance));
  const Vec3 end = near.frame.toWorld(to);
  const auto isEnteredAnyway = [&](const NearBody& of, std::uint32_t face) noexcept {
    if (!entered) return false;
    const Vec3 normal = of.frame.rotate(of.surface->faceNormal(face));
    const Vec3 corner = of.frame.toWorld(of.surface->triangle(face).corner(0));
    const Vec3 at = near.frame.toWorld(glm::mix(near.from, to, entered.time));
    return std::abs(glm::dot(normal, near.frame.rotate(surface.faceNormal(entered.triangle)))) > kBend &&
           std::abs(glm::dot(normal, at - corner)) < 4 * rim_m;
  };
  for (const NearBody& other : all) {
    const Vec3 aside = other.frame.toLocal(other.frame.origin + away);
    const Vec3 way = other.frame.toLocal(end) - other.from;
    // Of two level planes rounding has one met first. At the boundary of an open mesh the mesh itself has no such two.
    const bool mayBeLevel = surface.closed() || other.body != near.body;
    const Vec3 longer = mayBeLevel ? way * (2 * rim_m / std::max(glm::length(way), rim_m)) : Vec3(0);
    const Vec3 from = other.from + aside - longer, onwards = other.from + way + aside + longer;
    allowance.spend(2 * Allowance::kPlace);
    const Vec3 beside = glm::mix(from, onwards, rimmed.time);
    const bool passesBy = glm::any(glm::lessThan(beside, other.surface->low() - 8 * rim_m)) ||
                          glm::any(glm::greaterThan(beside, other.surface->high() + 8 * rim_m));
    if (passesBy) continue;
    const Crossing beyond = other.surface->firstCrossing(from, onwards, allowance);
    if (beyond && !isEnteredAnyway(other, beyond.triangle)) return true;
  }
  return false;
}

NearBodies::Points NearBodies::inEachFrame(Vec3 world) const noexcept {
  Points points;
  for (int i = 0; i < count_; ++i) points[static_cast<std::size_t>(i)] = (*this)[i].frame.toLocal(world);
  return points;
}

NearBodies::Points NearBodies::from() const noexcept {
  Points points;
  for (int i = 0; i < count_; ++i) points[static_cast<std::size_t>(i)] = (*this)[i].from;
  return points;
}

void NearBodies::shiftWithSurfaces(std::span<const Body> bodies) noexcept {
  for (int i = 0; i < count_; ++i) {
    const Body& body = bodies[static_cast<std::size_t>((*this)[i].body)];
    if (body.deforming) [[unlikely]]
      (*this)[i].from += body.shift;
  }
}

void NearBodies::moveAll(const Points& to, double time) noexcept {
  for (int i = 0; i < count_; ++i) {
    const Vec3 end = to[static_cast<std::size_t>(i)];
    (*this)[i].from = time >= 1 ? end : glm::mix((*this)[i].from, end, time);
  }
}

}  // namespace haptics
