#include "haptic_server/state/asset_files.h"

#include <algorithm>
#include <charconv>
#include <exception>
#include <span>
#include <utility>
#include <vector>

namespace haptics {
namespace fs = std::filesystem;

std::optional<std::int64_t> asideSince(std::string_view name) {
  const auto at = name.find(kAsideMark);
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view digits = name.substr(at + kAsideMark.size());
  std::int64_t time_s = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), time_s);
  return time_s;
}

Result<std::string> AssetFiles::read(const ContentHash& hash) {
  const fs::path path = folder_ / hash.hex();
  auto bytes = files_.read(path);
  if (!bytes) return refused(path.string(), bytes.error().reason);
  if (Hasher().add(std::as_bytes(std::span(*bytes))).finish() == hash) {
    const std::lock_guard lock(mutex_);
    stored_.insert(hash);
    return bytes;
  }
  const std::string aside = hash.hex() + std::string(kAsideMark) + std::to_string(files_.now_s());
  const auto kept = renameDurably(files_, path, folder_ / aside);
  return refused(path.string(), "is damaged" + (kept ? "; it is kept as " + aside : std::string()));
}

Result<std::size_t> AssetFiles::store(const Asset& asset) {
  {
    const std::lock_guard lock(mutex_);
    if (stored_.contains(asset.name.hash)) return 0;
  }
  if (auto written = write(asset, ".new"); !written) return tl::unexpected(std::move(written).error());
  return asset.bytes().size();
}

Result<void> AssetFiles::write(const Asset& asset, const char* unfinishedMark) {
  const fs::path path = folder_ / asset.name.hash.hex();
  const fs::path unfinished = path.string() + unfinishedMark;
  const std::string bytes = asset.bytes().copy();
  if (auto made = createDurably(files_, unfinished, bytes); !made) return tl::unexpected(std::move(made).error());
  if (auto renamed = renameDurably(files_, unfinished, path); !renamed) return renamed;
  const std::lock_guard lock(mutex_);
  stored_.insert(asset.name.hash);
  return {};
}

void AssetFiles::prepare(const std::shared_ptr<const Asset>& asset) {
  try {
    {
      const std::lock_guard lock(mutex_);
      std::erase_if(prepared_, [](const auto& entry) { return entry.second.expired(); });
      if (!prepared_.emplace(asset->name.hash, asset).second || stored_.contains(asset->name.hash)) return;
    }
    if (!write(*asset, ".ahead.new")) return;
    const std::lock_guard lock(mutex_);
    prepared_bytes_ += asset->bytes().size();
  } catch (const std::exception&) {  // for want of memory
  }
}

std::size_t AssetFiles::takePrepared_bytes() {
  const std::lock_guard lock(mutex_);
  return std::exchange(prepared_bytes_, 0);
}

void AssetFiles::distrust(const ContentHash& asset) {
  const std::lock_guard lock(mutex_);
  stored_.erase(asset);
}

AssetFiles::Names AssetFiles::preparedNames() {
  const std::lock_guard lock(mutex_);
  Names names;
  for (const auto& [hash, asset] : prepared_) {
    if (!asset.expired()) names.insert(hash.hex());
  }
  return names;
}

void AssetFiles::collect(Names named, std::int64_t keepUpTo_s) {
  auto assets = files_.list(folder_);  // first: what is prepared from here on is not among them
  if (!assets) return;
  named.merge(preparedNames());
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(stored_, [&](const ContentHash& hash) { return !named.contains(hash.hex()); });
  }
  std::ranges::sort(*assets, std::ranges::greater(), &FileSystem::Entry::changed_s);
  std::size_t unnamed_bytes = 0;
  for (const auto& asset : *assets) {
    const std::string hash = asset.name.substr(0, asset.name.find('.'));
    const bool isAhead = asset.name.ends_with(".ahead.new") && named.contains(hash);
    if (named.contains(asset.name) || isAhead || asideSince(asset.name)) continue;
    const bool mayBeNamed = asset.changed_s <= keepUpTo_s && !asset.name.ends_with(".new");
    if (mayBeNamed) unnamed_bytes += asset.size;
    if (mayBeNamed && unnamed_bytes <= kMaxUnnamed_bytes) continue;
    files_.remove(folder_ / asset.name);  // a file that cannot be removed costs its space
  }
}

AssetFiles::Bytes AssetFiles::bytes(const Names& named) const {
  Bytes bytes;
  for (const auto& entry : files_.list(folder_).value_or(std::vector<FileSystem::Entry>{})) {
    (named.contains(entry.name) ? bytes.named : bytes.others) += entry.size;
  }
  return bytes;
}

}  // namespace haptics
