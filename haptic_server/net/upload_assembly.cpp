#include "haptic_server/net/upload_assembly.h"

#include <utility>

namespace haptics {

bool UploadAssembly::ignores(const v1::AssetChunk& chunk, const ContentHash& hash) const {
  return chunk.offset() != 0 && ignored_ == hash;
}

Result<void> UploadAssembly::check(const v1::AssetChunk& chunk, const AssetName& name) const {
  if (chunk.total_size() == 0 || chunk.total_size() > kMaxUploadBytes) {
    return refused("chunk.total_size", "is " + std::to_string(chunk.total_size()) + "; an upload has 1 to " +
                                           std::to_string(kMaxUploadBytes) + " bytes");
  }
  if (chunk.data().empty() || chunk.data().size() > chunk_bytes_) {
    return refused("chunk.data", "has " + std::to_string(chunk.data().size()) + " bytes; a chunk has 1 to " +
                                     std::to_string(chunk_bytes_));
  }
  const bool continues = total_ != 0 && name == name_ && chunk.total_size() == total_;
  if (chunk.offset() != 0 && !(continues && chunk.offset() == bytes_.size())) {
    return refused("chunk.offset", "is " + std::to_string(chunk.offset()) + " where " +
                                       std::to_string(continues ? bytes_.size() : 0) +
                                       " was next; chunks come in order, one asset after the other");
  }
  if (chunk.data().size() > chunk.total_size() - chunk.offset()) {
    return refused("chunk.data", "goes beyond the declared " + std::to_string(chunk.total_size()) + " bytes");
  }
  return {};
}

void UploadAssembly::add(const v1::AssetChunk& chunk, const AssetName& name) {
  if (chunk.offset() == 0) {
    name_ = name;
    total_ = chunk.total_size();
    std::string().swap(bytes_);  // its room was given back
    if (ignored_ == name.hash) ignored_.reset();
  }
  bytes_ += chunk.data();
}

void UploadAssembly::abandon(const ContentHash& hash) {
  ignored_ = hash;
  total_ = 0;
  std::string().swap(bytes_);
}

std::string UploadAssembly::take() {
  total_ = 0;
  return std::exchange(bytes_, {});
}

}  // namespace haptics
