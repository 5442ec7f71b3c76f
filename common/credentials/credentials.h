#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/error/error.h"
#include "common/hash/content_hash.h"

// Who may reach a server that other machines can reach. A folder holds the server's side; in it lie two files for
// clients, one a role, each with everything that a client needs: the server's certificate, by which it knows the server,
// and a token, by which the server knows the role.
namespace haptics {

enum class Role { kView, kEdit };

[[nodiscard]] std::string_view nameOf(Role role);  ///< "view", "edit".

/// Bytes of a token: random, so that it cannot be guessed, and may be kept as a plain hash.
inline constexpr std::size_t kTokenBytes = 32;

inline constexpr const char* kServerKeyFile = "server.key";
inline constexpr const char* kServerCertificateFile = "server.crt";
inline constexpr const char* kTokensFile = "tokens";
inline constexpr const char* kViewerFile = "viewer.credentials";
inline constexpr const char* kEditorFile = "editor.credentials";
/// The name in the certificate. A client knows the server by the certificate itself, wherever it is reached.
inline constexpr const char* kServerName = "haptic_server";

/// One file, for one client or several: PEM certificate of the server, and a line "token: <64 hexadecimal digits>".
struct ClientCredentials {
  std::string serverCertificatePem;  ///< The only one that is trusted.
  std::string token;                 ///< kTokenBytes raw bytes.
};

/// Errors name the file and what is missing in it.
[[nodiscard]] Result<ClientCredentials> readClientCredentials(const std::filesystem::path& file);

struct ServerCredentials {
  struct KnownToken {
    Role role;
    ContentHash hash;  ///< SHA-256: a stolen copy of the list opens nothing.
  };
  std::filesystem::path folder;
  std::string certificatePem, privateKeyPem;
  std::vector<KnownToken> tokens;
};

/// A list of tokens: a role and the SHA-256 of a token on each line; empty lines and those that begin with # say nothing.
[[nodiscard]] Result<std::vector<ServerCredentials::KnownToken>> readTokens(const std::filesystem::path& file);

/// Reads the folder that makeCredentials() made. Refused also while others may read the private key.
[[nodiscard]] Result<ServerCredentials> readServerCredentials(const std::filesystem::path& folder);

/// Makes a private key (P-256), a certificate signed with it, and one random token for each role; writes them to the
/// folder, which is made if missing, readable by its owner only. Nothing that is there is replaced; on an error nothing is
/// left. Refused: a folder that holds credentials, or what a run that was interrupted left of them.
[[nodiscard]] Result<void> makeCredentials(const std::filesystem::path& folder);

[[nodiscard]] ContentHash hashOfToken(std::string_view token);

}  // namespace haptics
