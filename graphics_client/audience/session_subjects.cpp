#include "graphics_client/audience/session_subjects.h"

#include <algorithm>

namespace haptics {

Result<SessionSubjects> SessionSubjects::of(std::string_view name) {
  constexpr std::size_t kLongest = 32;
  const auto isAllowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  };
  if (name.empty() || name.size() > kLongest || !std::ranges::all_of(name, isAllowed)) {
    return refused("--session", "\"" + std::string(name) + "\" is not a name of 1 to 32 letters, digits, - and _");
  }
  // The stream of its scene would be that of another's assets.
  if (name.ends_with("-assets")) return refused("--session", "the name \"" + std::string(name) + "\" ends in -assets");
  SessionSubjects subjects;
  subjects.sceneStream = "haptics-" + std::string(name);
  subjects.assetStream = subjects.sceneStream + "-assets";
  subjects.root_ = "haptics." + std::string(name) + ".";
  subjects.snapshot = subjects.root_ + "snapshot";
  subjects.latest = subjects.root_ + "latest";
  subjects.commit = subjects.root_ + "live.commit";
  subjects.sample = subjects.root_ + "live.sample";
  subjects.live = subjects.root_ + "live.*";
  subjects.audienceLive = "_R_." + subjects.live;
  subjects.relay = subjects.root_ + "relay";
  subjects.assets = subjects.root_ + "asset.>";
  return subjects;
}

std::string SessionSubjects::chunksOf(std::string_view assetInHex) const {
  return root_ + "asset." + std::string(assetInHex) + ".*";
}

std::string SessionSubjects::chunk(const ContentHash& asset, std::uint64_t index) const {
  return root_ + "asset." + asset.hex() + "." + std::to_string(index);
}

}  // namespace haptics
