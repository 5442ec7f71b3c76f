#pragma once

#include <nats/nats.h>

#include <filesystem>
#include <optional>
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

/// A connection with these options is to one of these servers and no other, each "nats://HOST:PORT" or "tls://HOST:PORT", with
/// commas between them; by TLS where one of them says so or the credentials say whom to trust.
[[nodiscard]] natsStatus setNatsServers(natsOptions& options, const std::string& urls,
                                        const std::optional<NatsCredentials>& credentials);

/// "why (detail)" of what the library last said on this thread.
[[nodiscard]] std::string natsErrorText(natsStatus status);

}  // namespace haptics
