#include "common/credentials/credentials.h"

#include <openssl/pem.h>

#include <cstdlib>
#include <span>
#include <sstream>
#include <utility>

#include "common/credentials/openssl_handles.h"
#include "common/text/plain_text.h"

namespace haptics {
namespace {

namespace fs = std::filesystem;

/// No file of credentials comes near it; what does is no file of credentials.
constexpr std::uintmax_t kMaxFileBytes = 64U << 10;
constexpr std::string_view kPemBegin = "-----BEGIN CERTIFICATE-----", kPemEnd = "-----END CERTIFICATE-----";
constexpr std::string_view kTokenKey = "token:";
constexpr const char* kHowToMake = "; make the credentials with: hapticctl credentials DIR";

Result<std::string> readSmallFile(const fs::path& file) {
  return plainLinesOf(file, kMaxFileBytes).map_error([](Error bad) {
    bad.reason += kHowToMake;
    return bad;
  });
}

std::optional<std::string> bytesOfHex(std::string_view digits) {
  const auto valueOf = [](char c) { return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1; };
  std::string bytes;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
    const int high = valueOf(digits[i]), low = valueOf(digits[i + 1]);
    if (high < 0 || low < 0) return std::nullopt;
    bytes += static_cast<char>(high << 4 | low);
  }
  if (digits.size() % 2 != 0) return std::nullopt;
  return bytes;
}

bool isCertificate(const std::string& pem) {
  const openssl::Bio in(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  return openssl::Certificate(PEM_read_bio_X509(in.get(), nullptr, nullptr, nullptr)) != nullptr;
}

/// Whether systemd keeps it for this service alone (LoadCredential=), which it may do by an access control list: the mode
/// then shows a group's right that no group has.
bool isKeptBySystemd(const fs::path& file) {
  const char* folder = std::getenv("CREDENTIALS_DIRECTORY");
  std::error_code error;
  return folder != nullptr && fs::equivalent(file.parent_path(), folder, error);
}

Result<void> checkPrivate(const fs::path& file) {
  std::error_code error;
  const fs::perms perms = fs::status(file, error).permissions();
  fs::perms others = fs::perms::group_all | fs::perms::others_all;
  if (isKeptBySystemd(file)) others &= ~fs::perms::group_read;
  if (!error && (perms & others) == fs::perms::none) return {};
  return refused(file.string(),
                 error ? error.message() + kHowToMake : "others may read it; run: chmod 600 " + file.string());
}

Result<ServerCredentials::KnownToken> knownToken(const std::string& line) {
  std::istringstream words(line);
  std::string role, digits, more;
  words >> role >> digits;
  const auto bytes = bytesOfHex(digits);
  const auto hash = bytes ? ContentHash::fromBytes(*bytes) : std::nullopt;
  if ((role != "view" && role != "edit") || !hash || words >> more) {
    return refused("", "is not a role (view or edit) and the SHA-256 of a token");  // the line may be a token itself
  }
  return ServerCredentials::KnownToken{role == "view" ? Role::kView : Role::kEdit, *hash};
}

}  // namespace

std::string_view nameOf(Role role) { return role == Role::kView ? "view" : "edit"; }

ContentHash hashOfToken(std::string_view token) { return Hasher().add(std::as_bytes(std::span(token))).finish(); }

Result<ClientCredentials> readClientCredentials(const fs::path& file) {
  const auto text = readSmallFile(file);
  if (!text) return tl::unexpected(text.error());
  const std::size_t begin = text->find(kPemBegin), end = text->find(kPemEnd);
  if (begin == std::string::npos || end == std::string::npos || end < begin) {
    return refused(file.string(), "holds no certificate of a server; give viewer.credentials or editor.credentials");
  }
  ClientCredentials credentials;
  credentials.serverCertificatePem = text->substr(begin, end + kPemEnd.size() - begin) + "\n";
  if (!isCertificate(credentials.serverCertificatePem)) return refused(file.string(), "holds a damaged certificate");
  std::istringstream lines(*text);
  std::string where = file.string();
  int number = 1;
  for (std::string line; std::getline(lines, line); ++number) {
    const std::size_t key = line.find_first_not_of(" \t");
    if (key == line.npos || line.compare(key, kTokenKey.size(), kTokenKey) != 0) continue;
    std::istringstream rest(line.substr(key + kTokenKey.size()));
    std::string digits;
    rest >> digits;
    credentials.token = bytesOfHex(digits).value_or("");
    where = file.string() + ':' + std::to_string(number);
  }
  if (credentials.token.size() != kTokenBytes) {
    return refused(where, "holds no \"token: \" with 64 hexadecimal digits");
  }
  return credentials;
}

Result<std::vector<ServerCredentials::KnownToken>> readTokens(const fs::path& file) {
  const auto list = readSmallFile(file);
  if (!list) return tl::unexpected(list.error());
  std::vector<ServerCredentials::KnownToken> tokens;
  std::istringstream lines(*list);
  int number = 1;
  for (std::string line; std::getline(lines, line); ++number) {
    const std::size_t begin = line.find_first_not_of(" \t");
    if (begin == line.npos || line[begin] == '#') continue;
    const auto token = knownToken(line);
    if (!token) return refused(file.string() + ':' + std::to_string(number), token.error().reason);
    tokens.push_back(*token);
  }
  return tokens;
}

Result<ServerCredentials> readServerCredentials(const fs::path& folder) {
  auto certificate = readSmallFile(folder / kServerCertificateFile);
  if (!certificate) return tl::unexpected(certificate.error());
  if (auto kept = checkPrivate(folder / kServerKeyFile); !kept) return tl::unexpected(kept.error());
  auto key = readSmallFile(folder / kServerKeyFile);
  if (!key) return tl::unexpected(key.error());
  auto tokens = readTokens(folder / kTokensFile);
  if (!tokens) return tl::unexpected(std::move(tokens).error());
  if (tokens->empty()) return refused((folder / kTokensFile).string(), "names no token: nobody could connect");
  return ServerCredentials{folder, *std::move(certificate), *std::move(key), *std::move(tokens)};
}

}  // namespace haptics
