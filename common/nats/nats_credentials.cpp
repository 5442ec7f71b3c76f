#include "common/nats/nats_credentials.h"

#include <cstdint>
#include <sstream>
#include <string_view>
#include <vector>

#include "common/text/plain_text.h"

namespace haptics {

Result<NatsCredentials> readNatsCredentials(const std::filesystem::path& file) {
  constexpr std::uintmax_t kMax_bytes = 1'000'000;
  const auto text = plainLinesOf(file, kMax_bytes);
  if (!text) return tl::unexpected(text.error());
  std::istringstream lines(*text);
  NatsCredentials credentials;
  constexpr std::string_view kUser = "user: ", kPassword = "password: ";
  bool inCertificate = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("-----BEGIN ")) {
      if (line != "-----BEGIN CERTIFICATE-----") return refused(file.string(), "holds PEM that is no certificate");
      inCertificate = true;
    }
    if (inCertificate) {
      credentials.trustedPem += line + "\n";
      if (line.starts_with("-----END ")) inCertificate = false;
    } else if (line.starts_with(kUser)) {
      credentials.user = line.substr(kUser.size());
    } else if (line.starts_with(kPassword)) {
      credentials.password = line.substr(kPassword.size());
    }
  }
  if (inCertificate) return refused(file.string(), "ends within a certificate");
  if (credentials.user.empty() != credentials.password.empty() ||
      (credentials.user.empty() && credentials.trustedPem.empty())) {
    return refused(file.string(), "needs the lines \"user: NAME\" and \"password: TEXT\"");
  }
  return credentials;
}

natsStatus setNatsServers(natsOptions& options, const std::string& urls,
                          const std::optional<NatsCredentials>& credentials) {
  std::vector<std::string> split;
  std::istringstream in(urls);
  for (std::string url; std::getline(in, url, ',');) split.push_back(std::move(url));
  std::vector<const char*> servers;
  for (const std::string& url : split) servers.push_back(url.c_str());
  natsStatus status = natsOptions_SetServers(&options, servers.data(), static_cast<int>(servers.size()));
  const bool hasUser = credentials && !credentials->user.empty();
  const bool hasTrusted = credentials && !credentials->trustedPem.empty();
  // Others that a server names, in a line before TLS, are none of these.
  if (status == NATS_OK) status = natsOptions_SetIgnoreDiscoveredServers(&options, true);
  const bool isSecure = hasTrusted || urls.find("tls://") != std::string::npos;
  if (status == NATS_OK && isSecure) status = natsOptions_SetSecure(&options, true);
  if (status == NATS_OK && hasUser)
    status = natsOptions_SetUserInfo(&options, credentials->user.c_str(), credentials->password.c_str());
  if (status == NATS_OK && hasTrusted)
    status = natsOptions_SetCATrustedCertificates(&options, credentials->trustedPem.c_str());
  return status;
}

std::string natsErrorText(natsStatus status) {
  natsStatus last = NATS_OK;
  const char* detail = nats_GetLastError(&last);
  std::string text = natsStatus_GetText(status);
  if (last == status && detail != nullptr && *detail != '\0') text += " (" + std::string(detail) + ")";
  return text;
}

}  // namespace haptics
