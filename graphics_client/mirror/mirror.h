#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "common/assets/asset_content.h"
#include "common/error/error.h"
#include "common/wire/driven_shapes.h"
#include "graphics_client/mirror/mirror_view.h"

namespace haptics {

/// The client's copy of the scene, its assets and the newest telemetry: plain data, without sockets, threads or a
/// clock. Nothing enters it unchecked: commits and snapshots must lead to the root that the server announced, assets
/// must hash to their name after decoding.
class Mirror {
 public:
  /// The server's revision and root, from whatever message carried them last.
  void announce(std::uint64_t revision, const ContentHash& root);
  /// A snapshot. Another epoch than the scene's before counts as a state reset. Refused when the root differs.
  [[nodiscard]] Result<void> replaceScene(std::uint64_t epoch, SceneVersion scene, const ContentHash& root);
  /// Refused, and nothing changed, when prevRoot is not the own root or root not the one that results, or when that scene
  /// would have more than kMaxHeldObjects objects.
  [[nodiscard]] Result<void> apply(const Commit& commit);
  /// Decodes, hashes what was decoded, and keeps it if the scene still uses it.
  [[nodiscard]] Result<void> addAsset(const AssetName& name, std::string_view bytes);
  /// The same with what is decoded already, which is shared from now on.
  [[nodiscard]] Result<void> addAsset(const AssetName& name, AssetContent content);
  /// Hashes every record anew, and assets, in turn, until so many bytes of them are done (at least one asset): finds
  /// memory that changed behind the mirror's back. Refused: something is not what it was; such an asset is dropped.
  [[nodiscard]] Result<void> audit(std::size_t assetBytes);
  /// Latest wins: a sample that is not newer than the newest is dropped (false).
  bool take(const TelemetrySample& sample, std::span<const BodyState> bodies = {}, std::vector<ObjectDent> dents = {},
            const std::optional<ToolState>& tool = std::nullopt,
            const std::optional<TelemetrySample>& secondHand = std::nullopt, std::vector<ShapeState> shapes = {});
  /// A new connection: its ticks may start anew (a server that restarted and kept its state).
  void startTelemetry() noexcept { newestTick_.reset(); }
  void countResync() noexcept { ++view_.resyncs; }

  [[nodiscard]] const SceneVersion& scene() const noexcept { return *view_.scene; }
  [[nodiscard]] std::uint64_t epoch() const noexcept { return view_.epoch; }
  /// Assets that the scene names and that are not here, each once, in order of object id.
  [[nodiscard]] std::vector<AssetName> lackingAssets() const;
  /// All that is known, but for the link's and the clock's part.
  [[nodiscard]] const MirrorView& contents() const noexcept { return view_; }

 private:
  MirrorView view_;
  std::optional<std::uint64_t> newestTick_;
  AssetName lastAudited_;

  void setScene(SceneVersion scene);
  void drop(const AssetName& asset);
  void countAssets();
  void compare();
};

}  // namespace haptics
