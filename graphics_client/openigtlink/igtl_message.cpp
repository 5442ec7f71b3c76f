#include "graphics_client/openigtlink/igtl_message.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace haptics::igtl {
namespace {

constexpr double kMillimetres_per_m = 1000;
constexpr std::int64_t kSecond_ns = 1'000'000'000;

// Of the header: u16 version, the type's and the device's name, filled up with 0; u64 time, u64 size of the body, u64 its CRC.
constexpr std::size_t kTypeAt = 2, kMaxType = 12, kNameAt = 14, kSizeAt = 42, kCrcAt = 50, kHeader_bytes = 58;
// Of the second version's extended header: u16 its size, u16 and u32 those of two parts after the content, u32 a number.
constexpr std::size_t kExtended_bytes = 12;
constexpr std::size_t kNumbersOfTransform = 12;
/// Of a matrix by floats, from rows and columns of length 1 at right angles.
constexpr double kSkewed = 1e-3;
/// One newton, without prefix, in OpenIGTLink's units: 4 bits of prefix, then 6 of the unit and 4 of its power.
constexpr std::uint64_t kNewton = std::uint64_t{0x0B} << 54 | std::uint64_t{1} << 50;

template <class Number>
void append(std::string& bytes, Number number) {
  for (int shift = 8 * static_cast<int>(sizeof number) - 8; shift >= 0; shift -= 8)
    bytes += static_cast<char>(number >> shift & 0xFF);
}
void append(std::string& bytes, float number) { append(bytes, std::bit_cast<std::uint32_t>(number)); }
void append(std::string& bytes, double number) { append(bytes, std::bit_cast<std::uint64_t>(number)); }

[[nodiscard]] std::uint64_t numberAt(std::string_view bytes, std::size_t at, std::size_t size) {
  std::uint64_t number = 0;
  for (const char byte : bytes.substr(at, size)) number = number << 8 | static_cast<unsigned char>(byte);
  return number;
}

[[nodiscard]] std::string_view nameAt(std::string_view bytes, std::size_t at, std::size_t most) {
  const std::string_view name = bytes.substr(at, most);
  return name.substr(0, name.find('\0'));
}

/// ECMA-182, from 0.
[[nodiscard]] std::uint64_t crcOf(std::string_view bytes) {
  constexpr std::uint64_t kPolynomial = 0x42F0E1EBA9EA3693, kTop = std::uint64_t{1} << 63;
  std::uint64_t crc = 0;
  for (const char byte : bytes) {
    crc ^= std::uint64_t{static_cast<unsigned char>(byte)} << 56;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & kTop) != 0 ? crc << 1 ^ kPolynomial : crc << 1;
  }
  return crc;
}

[[nodiscard]] std::string message(std::string_view type, std::string_view name, std::int64_t unix_ns,
                                  std::string_view body) {
  std::string bytes;
  append(bytes, std::uint16_t{1});
  bytes += type;
  bytes.resize(kNameAt);
  bytes += name.substr(0, kMaxName);
  bytes.resize(kNameAt + kMaxName);
  append(bytes, static_cast<std::uint32_t>(unix_ns / kSecond_ns));
  append(bytes, static_cast<std::uint32_t>(std::ldexp(static_cast<double>(unix_ns % kSecond_ns) * 1e-9, 32)));
  append(bytes, std::uint64_t{body.size()});
  append(bytes, crcOf(body));
  bytes += body;
  return bytes;
}

void append(std::string& bytes, Vec3 position_m) {
  for (int i = 0; i < 3; ++i) append(bytes, static_cast<float>(position_m[i] * kMillimetres_per_m));
}

/// Where the header's body has its content. Refused: not within it.
[[nodiscard]] Result<std::string_view> contentOf(std::uint64_t version, std::string_view body) {
  if (version < 2) return body;
  if (body.size() < kExtended_bytes) return refused("body", "is shorter than its extended header");
  const std::uint64_t before = numberAt(body, 0, 2), after = numberAt(body, 2, 2) + numberAt(body, 4, 4);
  if (before + after > body.size()) return refused("body", "is shorter than the parts that it names");
  return body.substr(before, body.size() - before - after);
}

}  // namespace

std::string transform(std::string_view name, std::int64_t unix_ns, const Pose& pose) {
  const glm::dmat3 turned = glm::mat3_cast(pose.rotation);
  std::string body;
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) append(body, static_cast<float>(turned[column][row]));
  }
  append(body, pose.position);
  return message("TRANSFORM", name, unix_ns, body);
}

std::string position(std::string_view name, std::int64_t unix_ns, const Pose& pose) {
  std::string body;
  append(body, pose.position);
  const Quat& q = pose.rotation;
  for (const double number : {q.x, q.y, q.z, q.w}) append(body, static_cast<float>(number));
  return message("POSITION", name, unix_ns, body);
}

std::string force(std::string_view name, std::int64_t unix_ns, Vec3 force_N) {
  std::string body{3, 0};  // numbers, status
  append(body, kNewton);
  for (int i = 0; i < 3; ++i) append(body, force_N[i]);
  return message("SENSOR", name, unix_ns, body);
}

Result<Pose> poseFrom(std::string_view content) {
  if (content.size() != kNumbersOfTransform * sizeof(float)) return refused("TRANSFORM", "it has to have 12 numbers");
  std::array<double, kNumbersOfTransform> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i)
    numbers[i] = std::bit_cast<float>(static_cast<std::uint32_t>(numberAt(content, sizeof(float) * i, sizeof(float))));
  if (!std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); }))
    return refused("TRANSFORM", "its numbers have to be finite");
  glm::dmat3 turned;
  for (int i = 0; i < 9; ++i) turned[i / 3][i % 3] = numbers[static_cast<std::size_t>(i)];
  const glm::dmat3 product = glm::transpose(turned) * turned;
  bool turns = glm::determinant(turned) > 0;
  for (int i = 0; i < 9; ++i) turns = turns && std::abs(product[i / 3][i % 3] - (i % 4 == 0 ? 1 : 0)) < kSkewed;
  if (!turns) return refused("TRANSFORM", "its matrix has to be a rotation");
  return Pose{glm::normalize(glm::quat_cast(turned)), Vec3(numbers[9], numbers[10], numbers[11]) / kMillimetres_per_m};
}

Result<void> Reader::read(std::span<const char> bytes, const std::function<void(const Message&)>& take) {
  std::string_view more(bytes.data(), bytes.size());
  while (!more.empty()) {
    const auto left = static_cast<std::size_t>(std::min<std::uint64_t>(toLeave_, more.size()));
    toLeave_ -= left;
    more.remove_prefix(left);
    const auto takeUpTo = [&](std::size_t size) {
      const std::size_t lacks = std::min(size - held_.size(), more.size());
      held_ += more.substr(0, lacks);
      more.remove_prefix(lacks);
      return held_.size() == size;
    };
    if (held_.size() < kHeader_bytes && !takeUpTo(kHeader_bytes)) continue;
    const std::uint64_t version = numberAt(held_, 0, 2), size = numberAt(held_, kSizeAt, 8);
    if (version < 1 || version > 2)
      return refused("header", "its version is " + std::to_string(version) + "; there are 1 and 2");
    if (size > kMaxBody_bytes) {
      toLeave_ = size;
      held_.clear();
      continue;
    }
    if (!takeUpTo(kHeader_bytes + static_cast<std::size_t>(size))) continue;
    const std::string_view whole = held_, body = whole.substr(kHeader_bytes);
    if (crcOf(body) != numberAt(whole, kCrcAt, 8)) return refused("header", "its checksum is not that of the body");
    const auto content = contentOf(version, body);
    if (!content) return tl::unexpected(content.error());
    take({nameAt(whole, kTypeAt, kMaxType), nameAt(whole, kNameAt, kMaxName), *content});
    held_.clear();
  }
  return {};
}

}  // namespace haptics::igtl
