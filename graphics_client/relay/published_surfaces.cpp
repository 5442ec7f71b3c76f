#include "graphics_client/relay/published_surfaces.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/mesh/canonical_bytes.h"

namespace haptics {
namespace {

/// The object's record with nothing in it but what its textured surface is drawn from.
ObjectRecord surfaceOf(const ObjectRecord& object) {
  ObjectRecord record;
  record.mesh = object.mesh;
  record.material = {.stiffness_N_per_m = 0, .damping_Ns_per_m = 0, .color = {0, 0, 0}};
  record.material.surface.shading = object.material.surface.shading;
  record.material.surface.texture = object.material.surface.texture;
  record.deformation.lattice = object.deformation.lattice;
  record.deformation.residue = object.deformation.residue;
  return record;
}

}  // namespace

std::string encodeSurface(const DisplayedSurface& surface) {
  constexpr float kHighest = 255;
  std::vector<std::uint8_t> heights;
  heights.reserve(surface.heights.size());
  for (const float height : surface.heights) {
    heights.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(height, 0.0F, 1.0F) * kHighest)));
  }
  std::string header = listHeader("HSRF", surface.points.size());
  append(header, std::uint64_t{surface.triangles.size()});
  const auto bytes = [](const auto& list) { return std::as_bytes(std::span(list)); };
  return CanonicalBytes(std::move(header), {bytes(surface.points), bytes(surface.triangles), bytes(heights)}).copy();
}

void PublishedSurfaces::want(const MirrorView& view) {
  keys_.clear();
  waiting_.clear();
  for (const SceneVersion::Object& object : view.scene->objects()) {
    if (!object->material.surface.texture) continue;
    const ObjectRecord surface = surfaceOf(*object);
    const ContentHash key = surface.hash();
    if (!keys_.insert(key).second || begun_.contains(key)) continue;
    auto request = surfaceRequest(surface, view, kMaxTriangles);
    if (request) waiting_.push_back({key, *std::move(request)});
  }
  std::erase_if(begun_, [&](const ContentHash& key) { return !keys_.contains(key); });
}

std::optional<PublishedSurfaces::Surface> PublishedSurfaces::takeMade() {
  if (!making_.valid()) {
    makeNext();
    return std::nullopt;
  }
  if (making_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return std::nullopt;
  Surface made = making_.get();
  makeNext();
  return keys_.contains(made.key) ? std::optional(std::move(made)) : std::nullopt;
}

void PublishedSurfaces::makeNext() {
  if (waiting_.empty()) return;
  begun_.insert(waiting_.front().key);
  making_ = std::async(std::launch::async, [order = std::move(waiting_.front())] {
    return Surface{order.key, encodeSurface(displaySurface(order.request, *shapeAtRest(order.request)))};
  });
  waiting_.pop_front();
}

}  // namespace haptics
