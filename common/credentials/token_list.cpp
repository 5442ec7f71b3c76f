#include "common/credentials/token_list.h"

#include <openssl/crypto.h>
#include <sys/stat.h>

#include <utility>

namespace haptics {

TokenList::TokenList(const ServerCredentials& credentials)
    : file_(credentials.folder / kTokensFile), tokens_(credentials.tokens), stamp_(stampNow()) {}

std::optional<Role> TokenList::roleOf(const ContentHash& token) const {
  std::optional<Role> role;
  for (const auto& known : tokens_) {
    if (CRYPTO_memcmp(known.hash.bytes.data(), token.bytes.data(), token.bytes.size()) == 0) role = known.role;
  }
  return role;
}

Result<bool> TokenList::refresh(bool anyway) {
  const Stamp now = stampNow();
  if (now == stamp_ && !anyway) return false;
  stamp_ = now;
  auto tokens = readTokens(file_);
  if (!tokens) return tl::unexpected(std::move(tokens).error());
  tokens_ = *std::move(tokens);
  return true;
}

TokenList::Stamp TokenList::stampNow() const {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  struct stat file {};
  if (::stat(file_.c_str(), &file) != 0) return {};
  return {file.st_dev, file.st_ino, file.st_size, file.st_mtim.tv_sec * kSecond_ns + file.st_mtim.tv_nsec,
          file.st_ctim.tv_sec * kSecond_ns + file.st_ctim.tv_nsec};
}

}  // namespace haptics
