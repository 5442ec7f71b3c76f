#include "graphics_client/audience/nats_credentials.h"

#include <fstream>
#include <iterator>
#include <string_view>

namespace haptics {

Result<NatsCredentials> readNatsCredentials(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) return refused(file.string(), "cannot be read");
  NatsCredentials credentials;
  constexpr std::string_view kUser = "user: ", kPassword = "password: ";
  bool inCertificate = false;
  for (std::string line; std::getline(stream, line);) {
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

}  // namespace haptics
