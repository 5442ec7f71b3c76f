#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "common/wire/transport.h"

// TLS 1.3, and nothing older, as a Transport around another: OpenSSL between two queues of bytes, with no socket of its
// own. What is below decides about time-outs, backlog and closing; what is above sees plain bytes.
namespace haptics {

/// How the reason begins when a handshake or a record failed: trying again will not help.
inline constexpr std::string_view kTlsFailure = "TLS: ";

class TlsContext {
 public:
  /// `plainAnswer` is what a peer that does not begin with TLS gets before it is disconnected, as it stands.
  /// Refused: PEM that cannot be read, or a key that is not the certificate's.
  [[nodiscard]] static Result<TlsContext> server(const std::string& certificatePem, const std::string& privateKeyPem,
                                                 std::string plainAnswer);
  /// Trusts the server that holds the key of this very certificate, wherever it is reached, and no other.
  [[nodiscard]] static Result<TlsContext> client(const std::string& serverCertificatePem);

  /// `line` secured. What is sent before the handshake is done waits for it; close() before that sends none of it. A
  /// handshake or a record that fails closes the line; the reason begins with kTlsFailure.
  [[nodiscard]] std::unique_ptr<Transport> secure(std::unique_ptr<Transport> line) const;

  struct State;

 private:
  explicit TlsContext(std::shared_ptr<const State> state);
  std::shared_ptr<const State> state_;
};

}  // namespace haptics
