#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/error/error.h"

namespace haptics {

/// A file of MCAP 0 (mcap.dev/spec): messages in channels, in chunks that are not compressed, with an index behind them.
class McapFile {
 public:
  McapFile() = default;
  ~McapFile();
  McapFile(const McapFile&) = delete;
  McapFile& operator=(const McapFile&) = delete;

  /// Refused: it cannot be written.
  [[nodiscard]] Result<void> open(const std::filesystem::path& file, std::string_view library);
  /// Of protobuf messages. @param schema  A FileDescriptorSet with the message and all that it uses.
  [[nodiscard]] std::uint16_t addChannel(std::string_view topic, std::string_view message, std::string_view schema);
  [[nodiscard]] Result<void> add(std::uint16_t channel, std::uint64_t time_unix_ns, std::string_view message);
  /// Once, before finish().
  void setMetadata(std::string_view name, const std::map<std::string, std::string>& values);
  [[nodiscard]] Result<void> finish();

 private:
  struct Channel {
    std::string schema, channel;  // records
    std::uint64_t messages = 0;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> inChunk{};  // time, offset
  };
  std::string name_;
  std::FILE* out_ = nullptr;
  std::uint64_t written_ = 0;
  std::vector<Channel> channels_;  // by id - 1
  std::string chunk_;
  std::uint64_t chunkBegan_ns_ = 0, chunkEnded_ns_ = 0;  // 0: without a message
  std::uint64_t began_ns_ = 0, ended_ns_ = 0;
  std::uint64_t messages_ = 0;
  std::uint32_t chunks_ = 0;
  std::string chunkIndexes_, metadata_, metadataName_;  // records, but for the name

  [[nodiscard]] Result<void> endChunk();
  [[nodiscard]] Result<void> write(std::string_view bytes);
  [[nodiscard]] tl::unexpected<Error> cannotWrite() const;
};

}  // namespace haptics
