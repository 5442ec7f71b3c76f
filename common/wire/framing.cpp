#include "common/wire/framing.h"

namespace haptics {
namespace {

constexpr std::size_t kLengthBytes = 4;

std::uint32_t readLength(const char* bytes) {
  std::uint32_t length = 0;
  for (std::size_t i = kLengthBytes; i-- > 0;) length = length << 8 | static_cast<unsigned char>(bytes[i]);
  return length;
}

}  // namespace

Result<void> appendFrame(std::string& out, const v1::Envelope& envelope, std::size_t limit) {
  const std::size_t length = envelope.ByteSizeLong();
  if (length > limit) {
    return refused("frame.length",
                   "is " + std::to_string(length) + " bytes; a frame has at most " + std::to_string(limit));
  }
  for (std::size_t i = 0; i < kLengthBytes; ++i) out += static_cast<char>(length >> (8 * i));
  const std::size_t start = out.size();
  out.resize(start + length);
  envelope.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(out.data() + start));
  return {};
}

void FrameDecoder::feed(std::span<const char> bytes) {
  if (broken_) return;
  buffer_.erase(0, consumed_);
  consumed_ = 0;
  buffer_.append(bytes.data(), bytes.size());
}

Result<std::optional<v1::Envelope>> FrameDecoder::next() {
  if (broken_) return tl::unexpected<Error>(*broken_);
  const auto fail = [this](const char* field, std::string reason) {
    broken_ = Error{field, std::move(reason)};
    buffer_ = {};
    consumed_ = 0;
    return tl::unexpected<Error>(*broken_);
  };
  const std::size_t available = buffer_.size() - consumed_;
  if (available < kLengthBytes) return std::optional<v1::Envelope>{};
  const std::uint32_t length = readLength(buffer_.data() + consumed_);
  if (length == 0 || length > limit_) {
    return fail("frame.length",
                "is " + std::to_string(length) + " bytes; a frame here has 1 to " + std::to_string(limit_));
  }
  if (available < kLengthBytes + length) return std::optional<v1::Envelope>{};
  std::optional<v1::Envelope> envelope(std::in_place);
  if (!envelope->ParseFromArray(buffer_.data() + consumed_ + kLengthBytes, static_cast<int>(length))) {
    return fail("frame", "does not hold a haptics.v1.Envelope");
  }
  if (envelope->body_case() == v1::Envelope::BODY_NOT_SET) {
    return fail("body", "is missing or of a kind that this version does not know");
  }
  consumed_ += kLengthBytes + length;
  return envelope;
}

}  // namespace haptics
