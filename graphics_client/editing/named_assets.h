#pragma once

#include <google/protobuf/message.h>

#include <functional>
#include <map>
#include <optional>
#include <set>

#include "common/assets/asset_content.h"
#include "common/scene/asset_source.h"
#include "graphics_client/mirror/mirror_view.h"
#include "haptics/v1/scene.pb.h"

namespace haptics {

using NamedAssets = std::map<AssetName, AssetContent>;

/// Visits the message and every message in it, the outer before the inner.
void forEachMessage(google::protobuf::Message& message, const std::function<void(google::protobuf::Message&)>& visit);

/// Assets that the transaction names by their hash. What has no hash's size is left out: the server refuses it.
[[nodiscard]] std::set<AssetName> assetsNamedBy(v1::Transaction transaction);
[[nodiscard]] std::set<AssetName> assetsNamedBy(const SceneVersion& scene);

/// Nothing while the asset is not here.
[[nodiscard]] std::optional<AssetContent> assetIn(const MirrorView& view, const AssetName& name);

}  // namespace haptics
