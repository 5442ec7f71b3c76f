#include "haptic_server/state/record_chain.h"

#include <algorithm>
#include <span>

namespace haptics {
namespace {

constexpr std::size_t kLengthBytes = 4;
constexpr std::size_t kCheckBytes = 4;
constexpr std::size_t kHeadBytes = kLengthBytes + kCheckBytes;
constexpr std::size_t kHashBytes = sizeof(ContentHash::bytes);

std::span<const std::byte> bytesOf(std::string_view text) { return std::as_bytes(std::span(text)); }

ContentHash hashOf(std::string_view text) { return Hasher().add(bytesOf(text)).finish(); }

std::string_view viewOf(const ContentHash& hash, std::size_t bytes) {
  return {reinterpret_cast<const char*>(hash.bytes.data()), bytes};
}

std::string headOf(const ContentHash& chain, std::size_t length) {
  std::string head;
  for (std::size_t i = 0; i < kLengthBytes; ++i) head += static_cast<char>(length >> (8 * i));
  const ContentHash check = Hasher().add(chain).add(bytesOf(head)).finish();
  return head.append(viewOf(check, kCheckBytes));
}

std::size_t lengthIn(std::string_view head) {
  std::size_t length = 0;
  for (std::size_t i = kLengthBytes; i-- > 0;) length = length << 8 | static_cast<unsigned char>(head[i]);
  return length;
}

bool isZero(std::string_view text) { return text.find_first_not_of('\0') == std::string_view::npos; }

ContentHash linkOf(const ContentHash& chain, std::string_view headAndPayload) {
  return Hasher().add(chain).add(bytesOf(headAndPayload)).finish();
}

}  // namespace

RecordWriter::RecordWriter(std::string_view head) : chain_(hashOf(head)) {}
RecordWriter::RecordWriter(const ContentHash& chain) : chain_(chain) {}

void RecordWriter::append(std::string& out, std::string_view payload) {
  const std::size_t start = out.size();
  out += headOf(chain_, payload.size());
  out += payload;
  chain_ = linkOf(chain_, std::string_view(out).substr(start));
  out += viewOf(chain_, kHashBytes);
}

RecordReader::RecordReader(std::string_view log, std::string_view head)
    : log_(log), offset_(std::min(log.size(), head.size())), chain_(hashOf(head)) {}
RecordReader::RecordReader(std::string_view rest, const ContentHash& chain) : log_(rest), offset_(0), chain_(chain) {}

std::optional<std::string_view> RecordReader::next() {
  const std::string_view rest = log_.substr(offset_);
  if (rest.empty()) return std::nullopt;
  end_ = LogEnd::kTorn;
  needed_ = 0;
  if (rest.size() < kHeadBytes) return std::nullopt;

  const std::size_t length = lengthIn(rest);
  const bool lengthIsRight = rest.starts_with(headOf(chain_, length));
  const std::size_t hashAt = kHeadBytes + length;
  if (lengthIsRight) needed_ = hashAt + kHashBytes;
  if (isZero(rest.substr(kHeadBytes)) || rest.size() < needed_) return std::nullopt;
  end_ = LogEnd::kDamaged;
  if (!lengthIsRight) return std::nullopt;
  const ContentHash link = linkOf(chain_, rest.substr(0, hashAt));
  const std::string_view right = viewOf(link, kHashBytes), stored = rest.substr(hashAt, kHashBytes);
  if (stored != right) {
    const auto wrong = std::ranges::mismatch(stored, right).in1 - stored.begin();
    if (isZero(rest.substr(hashAt + static_cast<std::size_t>(wrong)))) end_ = LogEnd::kTorn;
    return std::nullopt;
  }

  end_ = LogEnd::kWhole;
  chain_ = link;
  offset_ += hashAt + kHashBytes;
  return rest.substr(kHeadBytes, length);
}

}  // namespace haptics
