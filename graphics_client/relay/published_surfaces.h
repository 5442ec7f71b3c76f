#pragma once

#include <cstddef>
#include <deque>
#include <future>
#include <optional>
#include <set>
#include <string>

#include "common/hash/content_hash.h"
#include "common/scene/scene.h"
#include "graphics_client/mirror/mirror_view.h"
#include "graphics_client/surface/surface_request.h"

namespace haptics {

/// A textured surface as it is drawn, for who cannot evaluate a texture: HSRF, u32 1, u64 points, u64 triangles, f32 x y z of
/// each point (object frame, m; dents aside), u32 indices of the three points of each triangle, u8 height of each point: 0 at
/// the texture's lowest, 255 at its highest.
[[nodiscard]] std::string encodeSurface(const DisplayedSurface& surface);

/// Makes the surfaces of a session's textured objects, one after the other, on a thread of their own. For one calling thread.
class PublishedSurfaces {
 public:
  /// Of each object: what a page without a graphics card still draws fluently.
  static constexpr std::size_t kMaxTriangles = 20'000;

  struct Surface {
    ContentHash key;
    std::string bytes;
  };

  /// The textured objects of this view's scene; those whose assets are not all here are left for a later call.
  void want(const MirrorView& view);
  /// With the next want().
  void makeAgain(const ContentHash& key) { begun_.erase(key); }
  /// Of the objects wanted. A key names a surface among a session's assets: the hash of the object's record with nothing in it
  /// but mesh, shading, texture, lattice and residue (audience.proto).
  [[nodiscard]] const std::set<ContentHash>& keys() const noexcept { return keys_; }
  /// One that has been made and is wanted; nothing: none is ready yet.
  [[nodiscard]] std::optional<Surface> takeMade();

 private:
  struct Order {
    ContentHash key;
    SurfaceRequest request;
  };

  std::set<ContentHash> keys_, begun_;
  std::deque<Order> waiting_;
  std::future<Surface> making_;

  void makeNext();
};

}  // namespace haptics
