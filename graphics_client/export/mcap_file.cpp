#include "graphics_client/export/mcap_file.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <system_error>
#include <type_traits>

namespace haptics {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::size_t kChunk_bytes = 1U << 20;

enum Opcode : unsigned char {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kDataEnd = 0x0F,
};

template <class Number>
requires std::is_arithmetic_v<Number>
void put(std::string& to, Number number) { to.append(reinterpret_cast<const char*>(&number), sizeof number); }

void put(std::string& to, std::string_view text) {
  put(to, static_cast<std::uint32_t>(text.size()));
  to += text;
}

void put(std::string& to, const std::map<std::string, std::string>& values) {
  std::string content;
  for (const auto& [key, value] : values) {
    put(content, std::string_view(key));
    put(content, std::string_view(value));
  }
  put(to, std::string_view(content));
}

[[nodiscard]] std::string record(Opcode opcode, std::string_view content) {
  std::string bytes(1, static_cast<char>(opcode));
  put(bytes, std::uint64_t{content.size()});
  return bytes.append(content);
}

/// No checksum is given.
constexpr std::uint32_t kNoCrc = 0;

}  // namespace

McapFile::~McapFile() {
  if (out_ != nullptr) std::fclose(out_);
}

Result<void> McapFile::open(const std::filesystem::path& file, std::string_view library) {
  name_ = file.string();
  out_ = std::fopen(file.c_str(), "wb");
  if (out_ == nullptr) return cannotWrite();
  std::string content;
  put(content, std::string_view());
  put(content, library);
  return write(std::string(kMagic) + record(kHeader, content));
}

std::uint16_t McapFile::addChannel(std::string_view topic, std::string_view message, std::string_view schema) {
  const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
  std::string ofSchema, ofChannel;
  put(ofSchema, id);
  put(ofSchema, message);
  put(ofSchema, std::string_view("protobuf"));
  put(ofSchema, schema);
  put(ofChannel, id);
  put(ofChannel, id);
  put(ofChannel, topic);
  put(ofChannel, std::string_view("protobuf"));
  put(ofChannel, std::map<std::string, std::string>{});
  channels_.push_back({record(kSchema, ofSchema), record(kChannel, ofChannel)});
  chunk_ += channels_.back().schema + channels_.back().channel;
  return id;
}

Result<void> McapFile::add(std::uint16_t channel, std::uint64_t time_unix_ns, std::string_view message) {
  Channel& to = channels_[channel - 1U];
  chunkBegan_ns_ = chunkEnded_ns_ == 0 ? time_unix_ns : std::min(chunkBegan_ns_, time_unix_ns);
  chunkEnded_ns_ = std::max(chunkEnded_ns_, time_unix_ns);
  began_ns_ = messages_ == 0 ? time_unix_ns : std::min(began_ns_, time_unix_ns);
  ended_ns_ = std::max(ended_ns_, time_unix_ns);
  to.inChunk.emplace_back(time_unix_ns, chunk_.size());
  ++messages_;
  constexpr std::size_t kHead_bytes = 22;
  chunk_ += static_cast<char>(kMessage);
  put(chunk_, std::uint64_t{kHead_bytes + message.size()});
  put(chunk_, channel);
  put(chunk_, static_cast<std::uint32_t>(to.messages++));
  put(chunk_, time_unix_ns);
  put(chunk_, time_unix_ns);
  chunk_ += message;
  return chunk_.size() < kChunk_bytes ? Result<void>() : endChunk();
}

void McapFile::setMetadata(std::string_view name, const std::map<std::string, std::string>& values) {
  std::string content;
  put(content, name);
  put(content, values);
  metadata_ = record(kMetadata, content);
  metadataName_ = name;
}

Result<void> McapFile::endChunk() {
  if (chunk_.empty()) return {};
  std::string content;
  put(content, chunkBegan_ns_);
  put(content, chunkEnded_ns_);
  put(content, std::uint64_t{chunk_.size()});
  put(content, kNoCrc);
  put(content, std::string_view());
  put(content, std::uint64_t{chunk_.size()});
  content += chunk_;
  const std::string chunk = record(kChunk, content);
  std::string indexes, offsets;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (channels_[i].inChunk.empty()) continue;
    const auto id = static_cast<std::uint16_t>(i + 1);
    put(offsets, id);
    put(offsets, written_ + chunk.size() + indexes.size());
    std::string index, places;
    for (const auto& [time_ns, offset] : std::exchange(channels_[i].inChunk, {})) {
      put(places, time_ns);
      put(places, offset);
    }
    put(index, id);
    put(index, std::string_view(places));
    indexes += record(kMessageIndex, index);
  }
  std::string index;
  put(index, chunkBegan_ns_);
  put(index, chunkEnded_ns_);
  put(index, written_);
  put(index, std::uint64_t{chunk.size()});
  put(index, std::string_view(offsets));
  put(index, std::uint64_t{indexes.size()});
  put(index, std::string_view());
  put(index, std::uint64_t{chunk_.size()});
  put(index, std::uint64_t{chunk_.size()});
  chunkIndexes_ += record(kChunkIndex, index);
  ++chunks_;
  chunk_.clear();
  chunkBegan_ns_ = chunkEnded_ns_ = 0;
  return write(chunk + indexes);
}

Result<void> McapFile::finish() {
  if (auto ended = endChunk(); !ended) return ended;
  std::string index;
  put(index, written_);
  put(index, std::uint64_t{metadata_.size()});
  put(index, std::string_view(metadataName_));
  std::string dataEnd;
  put(dataEnd, kNoCrc);
  if (auto written = write(metadata_ + record(kDataEnd, dataEnd)); !written) return written;

  std::string summary, counts, statistics;
  for (const Channel& channel : channels_) summary += channel.schema;
  for (const Channel& channel : channels_) summary += channel.channel;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    put(counts, static_cast<std::uint16_t>(i + 1));
    put(counts, channels_[i].messages);
  }
  const auto channels = static_cast<std::uint32_t>(channels_.size());
  put(statistics, messages_);
  put(statistics, static_cast<std::uint16_t>(channels));
  put(statistics, channels);
  put(statistics, std::uint32_t{0});
  put(statistics, std::uint32_t{1});
  put(statistics, chunks_);
  put(statistics, began_ns_);
  put(statistics, ended_ns_);
  put(statistics, std::string_view(counts));
  summary += chunkIndexes_ + record(kStatistics, statistics) + record(kMetadataIndex, index);
  std::string footer;
  put(footer, written_);
  put(footer, std::uint64_t{0});
  put(footer, kNoCrc);
  if (auto written = write(summary + record(kFooter, footer) + std::string(kMagic)); !written) return written;
  return std::fclose(std::exchange(out_, nullptr)) == 0 ? Result<void>() : cannotWrite();
}

Result<void> McapFile::write(std::string_view bytes) {
  written_ += bytes.size();
  return std::fwrite(bytes.data(), 1, bytes.size(), out_) == bytes.size() ? Result<void>() : cannotWrite();
}

tl::unexpected<Error> McapFile::cannotWrite() const {
  return refused(name_, "cannot be written: " + std::generic_category().message(errno));
}

}  // namespace haptics
