#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "common/credentials/credentials.h"
#include "common/error/error.h"
#include "common/hash/content_hash.h"

namespace haptics {

/// The tokens that a server knows, as they stand in its credentials folder. One thread.
class TokenList {
 public:
  explicit TokenList(const ServerCredentials& credentials);

  /// The role that comes with a token, by its hash. Takes the same time whatever the token shares with those that are known.
  [[nodiscard]] std::optional<Role> roleOf(const ContentHash& token) const;
  /// Reads the file again where it is another than at the last call, or anyway. A list without a token lets nobody in.
  /// @return Whether it was read; or what is wrong with the file: the tokens then stay as they were.
  [[nodiscard]] Result<bool> refresh(bool anyway = false);

 private:
  /// File attributes that change with its content.
  struct Stamp {
    dev_t device = 0;
    ino_t inode = 0;
    off_t size = 0;
    std::int64_t modified_ns = 0, changed_ns = 0;
    bool operator==(const Stamp&) const = default;
  };
  std::filesystem::path file_;
  std::vector<ServerCredentials::KnownToken> tokens_;
  Stamp stamp_;

  [[nodiscard]] Stamp stampNow() const;
};

}  // namespace haptics
