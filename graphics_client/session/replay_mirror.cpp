#include "graphics_client/session/replay_mirror.h"

#include <memory>

namespace haptics {
namespace {

std::shared_ptr<const Asset> find(const RemadeScene& remade, const AssetName& name) {
  for (const ServoObjectSource& object : remade.objects) {
    if (auto asset = object.assets.find(name.hash)) return asset;
  }
  return nullptr;
}

}  // namespace

Result<bool> ReplayMirror::follow(const RemadeScene* remade) {
  const std::uint64_t number = remade == nullptr ? 0 : remade->scene->number;
  if (any_ && number == number_) return false;
  any_ = true;
  number_ = number;
  added_bytes_ = 0;
  const SceneVersion empty;
  const SceneVersion& version = remade == nullptr ? empty : remade->version;
  if (auto held = mirror_.replaceScene(epoch_, version, version.root()); !held)
    return tl::unexpected(std::move(held).error());
  for (const AssetName& name : mirror_.lackingAssets()) {
    const auto asset = find(*remade, name);
    if (!asset) continue;
    const std::size_t before = mirror_.contents().assetBytes;
    if (auto held = mirror_.addAsset(name, asset->content()); !held) return tl::unexpected(std::move(held).error());
    added_bytes_ += mirror_.contents().assetBytes - before;
  }
  mirror_.announce(version.revision(), version.root());
  return true;
}

}  // namespace haptics
