#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "common/credentials/credentials.h"
#include "common/error/error.h"
#include "common/wire/endpoint.h"
#include "graphics_client/audience/nats_connection.h"
#include "graphics_client/audience/session_subjects.h"

namespace haptics {

struct RelayOptions {
  Endpoint server;
  std::optional<ClientCredentials> credentials{};  ///< Of the server.
  NatsOptions nats;
  SessionSubjects subjects;
  double sampleRate_Hz = 60;
  int replicas = 1;  ///< As SessionPublisher::open().
};

/// Publishes the server's session until `stop` is set; comes back from a loss of either side by itself, with all that was
/// published read anew. Refused: what somebody has to change first.
/// @param say  Gets a line whenever something changes.
[[nodiscard]] Result<void> runRelay(const RelayOptions& options, const std::atomic<bool>& stop,
                                    const std::function<void(const std::string&)>& say);

}  // namespace haptics
