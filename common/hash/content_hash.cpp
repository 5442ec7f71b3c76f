#include "common/hash/content_hash.h"

#include <openssl/evp.h>

#include <algorithm>
#include <bit>
#include <stdexcept>

namespace haptics {

static_assert(std::endian::native == std::endian::little, "canonical bytes are little-endian");

std::string ContentHash::hex() const {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  text.reserve(2 * bytes.size());
  for (const std::uint8_t b : bytes) {
    text += kDigits[b >> 4];
    text += kDigits[b & 15];
  }
  return text;
}

std::string ContentHash::asBytes() const { return {bytes.begin(), bytes.end()}; }

std::optional<ContentHash> ContentHash::fromBytes(std::string_view raw) {
  ContentHash hash;
  if (raw.size() != hash.bytes.size()) return std::nullopt;
  std::copy(raw.begin(), raw.end(), hash.bytes.begin());
  return hash;
}

struct Hasher::Context {
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> digest{EVP_MD_CTX_new(), &EVP_MD_CTX_free};
};

Hasher::Hasher() : context_(std::make_unique<Context>()) {
  if (!context_->digest || EVP_DigestInit_ex(context_->digest.get(), EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("SHA-256 is not available in this OpenSSL");
  }
}
Hasher::~Hasher() = default;
Hasher::Hasher(Hasher&&) noexcept = default;
Hasher& Hasher::operator=(Hasher&&) noexcept = default;

Hasher& Hasher::add(std::span<const std::byte> raw) {
  EVP_DigestUpdate(context_->digest.get(), raw.data(), raw.size());
  return *this;
}
Hasher& Hasher::add(std::uint64_t value) { return add(std::as_bytes(std::span(&value, 1))); }
Hasher& Hasher::add(double value) {
  const double canonical = value + 0.0;  // -0 + 0 is +0
  return add(std::as_bytes(std::span(&canonical, 1)));
}
Hasher& Hasher::add(float value) {
  const float canonical = value + 0.0F;
  return add(std::as_bytes(std::span(&canonical, 1)));
}
Hasher& Hasher::add(Vec3 vector) { return add(vector.x).add(vector.y).add(vector.z); }
Hasher& Hasher::add(std::string_view text) {
  add(static_cast<std::uint64_t>(text.size()));
  return add(std::as_bytes(std::span(text)));
}
Hasher& Hasher::add(const ContentHash& hash) { return add(std::as_bytes(std::span(hash.bytes))); }

ContentHash Hasher::finish() {
  ContentHash hash;
  EVP_DigestFinal_ex(context_->digest.get(), hash.bytes.data(), nullptr);
  context_.reset();
  return hash;
}

}  // namespace haptics
