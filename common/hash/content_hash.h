#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/maths/vec.h"

namespace haptics {

/// A SHA-256 digest. All zero stands for "nothing".
struct ContentHash {
  std::array<std::uint8_t, 32> bytes{};

  auto operator<=>(const ContentHash&) const = default;
  [[nodiscard]] bool isZero() const noexcept { return *this == ContentHash{}; }
  [[nodiscard]] std::string hex() const;      ///< 64 lower-case digits.
  [[nodiscard]] std::string asBytes() const;  ///< 32 bytes, as protobuf carries them.
  [[nodiscard]] static std::optional<ContentHash> fromBytes(std::string_view bytes);  ///< Nothing unless 32 bytes.
};

/// SHA-256 over values in canonical form: little-endian, fixed width, -0 hashed as +0.
/// Callers refuse NaN and infinities before they hash.
class Hasher {
 public:
  Hasher();
  ~Hasher();
  Hasher(Hasher&&) noexcept;
  Hasher& operator=(Hasher&&) noexcept;

  Hasher& add(std::span<const std::byte> raw);
  Hasher& add(std::uint64_t value);
  Hasher& add(double value);
  Hasher& add(float value);
  Hasher& add(Vec3 vector);
  Hasher& add(std::string_view text);  ///< Its length, then its bytes.
  Hasher& add(const ContentHash& hash);
  [[nodiscard]] ContentHash finish();  ///< Leaves the hasher unusable.

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace haptics

template <>
struct std::hash<haptics::ContentHash> {
  std::size_t operator()(const haptics::ContentHash& h) const noexcept {
    std::size_t value = 0;
    for (std::size_t i = 0; i < sizeof value; ++i) value = value << 8 | h.bytes[i];
    return value;
  }
};
