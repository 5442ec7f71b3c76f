#pragma once

#include <filesystem>
#include <string>

#include "common/error/error.h"

namespace haptics {

/// How a program shows a NATS server who it is. The file has the lines "user: NAME" and "password: TEXT", and may have PEM
/// certificates, which then are the only ones that are trusted.
struct NatsCredentials {
  std::string user, password;
  std::string trustedPem = {};  ///< Empty: those that the system trusts.
};

/// Errors name the file and what is missing in it.
[[nodiscard]] Result<NatsCredentials> readNatsCredentials(const std::filesystem::path& file);

}  // namespace haptics
