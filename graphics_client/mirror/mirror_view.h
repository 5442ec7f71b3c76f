#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "common/mesh/tri_mesh.h"
#include "common/scene/scene.h"
#include "common/telemetry/telemetry_sample.h"

namespace haptics {

enum class LinkState { kConnecting, kSyncing, kLive, kRefused };

/// What a client holds and knows at one moment: an immutable picture that the network thread hands to the viewer.
struct MirrorView {
  LinkState link = LinkState::kConnecting;
  std::string linkText;                 ///< "connecting to host:port", why it was refused, ...
  std::uint64_t epoch = 0;
  std::shared_ptr<const SceneVersion> scene;  ///< Never null.
  std::map<ContentHash, std::shared_ptr<const TriMesh>> meshes;  ///< Those that arrived and whose hash was checked.
  ContentHash serverRoot;               ///< As last announced by the server, with its revision.
  std::uint64_t serverRevision = 0;
  /// Own root equals the server's at the same revision, and every mesh of the scene is here and hashed to its name.
  bool hashesEqual = false;
  std::optional<TelemetrySample> sample;  ///< Newest; nothing before the first.
  std::uint64_t samplesReceived = 0;
  double telemetryAge_s = 0;            ///< Of `sample` when the view was taken, by the estimated clock offset.
  std::uint64_t resyncs = 0;            ///< Roots that differed, each followed by a snapshot.
  std::uint64_t stateResets = 0;        ///< Server restarts that replaced the scene.
  std::string serverName, device;
  double maxForce_N = 0;
};

}  // namespace haptics
