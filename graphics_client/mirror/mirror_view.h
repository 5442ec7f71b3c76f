#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/assets/asset_content.h"
#include "common/error/error.h"
#include "common/mesh/moved_vertices.h"
#include "common/mesh/tri_mesh.h"
#include "common/scene/deformed_hash.h"
#include "common/scene/scene.h"
#include "common/surface/point_field.h"
#include "common/surface/sampled_field.h"
#include "common/telemetry/motion_state.h"
#include "common/telemetry/telemetry_sample.h"
#include "graphics_client/mirror/hand_leader.h"

namespace haptics {

/// kRefused: the server turned this client away (MirrorView::linkText says why); the link tries again, slowly. kClosed:
/// there is no server to connect to.
enum class LinkState { kConnecting, kSyncing, kLive, kRefused, kClosed };

/// What a client holds and knows at one moment: an immutable picture that the network thread hands to the viewer.
struct MirrorView {
  LinkState link = LinkState::kConnecting;
  bool isReplay = false;    ///< Of a recording, as if it were live.
  std::string linkText;     ///< "connecting to host:port", why it was refused, ...
  std::uint64_t epoch = 0;  ///< Of the server that `scene` came from; 0: nothing came yet.
  std::shared_ptr<const SceneVersion> scene = std::make_shared<const SceneVersion>();  ///< Never null.
  /// Assets that arrived and whose hash was checked.
  std::map<ContentHash, std::shared_ptr<const TriMesh>> meshes;
  std::map<ContentHash, std::shared_ptr<const SampledField>> fields;
  std::map<ContentHash, std::shared_ptr<const std::vector<float>>> vertexValues;
  std::map<ContentHash, std::shared_ptr<const MovedVertices>> movedVertices;
  std::map<ContentHash, std::shared_ptr<const PointField>> pointFields;
  std::size_t assetBytes = 0;  ///< Of these assets, canonical but for their heads.
  ContentHash serverRoot;      ///< As last announced by the server, with its revision.
  std::uint64_t serverRevision = 0;
  /// Own root equals the server's at the same revision, and every asset of the scene is here and hashed to its name.
  /// Stays as it was last known while the link is down.
  bool hashesEqual = false;
  std::optional<TelemetrySample> sample;      ///< Newest; nothing before the first.
  std::optional<TelemetrySample> secondHand;  ///< What a second hand felt in the tick of `sample`, where there is one.
  std::map<ObjectId, BodyState> bodies;       ///< Where the objects that move are, as of `sample` or last heard of.
  std::map<ObjectId, std::optional<Lattice>> shapes;  ///< Of those that are driven, likewise; none: the scene's.
  std::vector<ObjectDent> dents;                      ///< In soft objects, as of `sample`.
  std::optional<ToolState> tool;                      ///< As of `sample`, where the hand holds one.
  std::uint64_t samplesReceived = 0;
  std::uint64_t takenAt_ns = 0;   ///< This host's monotonic clock when the view was taken.
  double telemetryAge_s = 0;      ///< Of `sample` at takenAt_ns, by the estimated clock offset; 0 without a sample.
  double clockUncertainty_s = 0;  ///< The age is true to within this: half the smallest round trip.
  std::uint64_t resyncs = 0;      ///< Roots that differed, each followed by a snapshot.
  std::uint64_t stateResets = 0;  ///< Server restarts that replaced the scene.
  std::uint64_t connections = 0;  ///< Times that a server welcomed this client.
  std::string serverName, device;
  double maxForce_N = 0;
  std::string secondDevice;  ///< Of a second hand; empty: there is one hand.
  double secondMaxForce_N = 0;
  double servoRate_Hz = 0;  ///< Nominal.
  bool mayEdit = false;
  HandLeader hand;  ///< Known to a client that asked for the lead, or follows it (Options::followsHand).
  bool telemetryByDatagram = false;     ///< Else over the connection.
  std::uint64_t forgedDatagrams = 0;    ///< Ignored: not this server's, or no datagram of this connection.
  std::uint64_t datagramPathsLost = 0;  ///< Times that no datagram came for a second, and telemetry took TCP.

  /// What a hand felt, below kMaxLedHands; null: nothing came, or there is no such hand.
  [[nodiscard]] const TelemetrySample* felt(std::size_t which) const noexcept {
    const std::optional<TelemetrySample>& of = which == 0 ? sample : secondHand;
    return of ? &*of : nullptr;
  }
  /// Where the servo has it; until that is known, where the scene has it.
  [[nodiscard]] Pose poseOf(const ObjectRecord& object) const;
  /// Likewise its lattice, which takes the place of a residue too.
  [[nodiscard]] DeformationProperties deformationOf(const ObjectRecord& object) const;
  /// The object's dents; none in a rigid one.
  [[nodiscard]] std::vector<Dent> dentsIn(const ObjectRecord& object) const;
  /// The corners of one of its triangles (canonical numbering) as lattice, residue and dents have them, object frame;
  /// nothing while its mesh or residue is not here, or has no such triangle.
  [[nodiscard]] std::optional<std::array<Vec3, 3>> cornersOf(const ObjectRecord& object, std::uint32_t triangle) const;
  [[nodiscard]] bool holds(const AssetName& asset) const;
  [[nodiscard]] std::optional<AssetContent> contentOf(const AssetName& asset) const;  ///< Nothing: it is not here.
  /// Whether everything that the object's record names is here.
  [[nodiscard]] bool isComplete(const ObjectRecord& object) const;
  /// Age of `sample` at a later moment of this host's monotonic clock (monotonicNow_ns()).
  [[nodiscard]] double telemetryAgeAt_s(std::uint64_t now_ns) const noexcept {
    return sample ? telemetryAge_s + 1e-9 * static_cast<double>(now_ns - takenAt_ns) : 0;
  }
};

/// The root hash, computed anew from every byte that this client holds: assets are hashed from their decoded contents,
/// records from their fields. Refused, naming the object, while one of its assets is missing.
[[nodiscard]] Result<ContentHash> recomputedRoot(const MirrorView& view);

/// deformedHash() of what this client holds.
[[nodiscard]] std::optional<ContentHash> deformedHash(const MirrorView& view);

}  // namespace haptics
