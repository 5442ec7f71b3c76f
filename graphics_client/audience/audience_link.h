#pragma once

#include <string>

#include "graphics_client/audience/nats_connection.h"
#include "graphics_client/audience/session_subjects.h"
#include "graphics_client/mirror/server_link.h"

namespace haptics {

/// The way to a session that a relay publishes (ServerLink::Options::connect): each attempt waits for a sign of the relay,
/// reads what is stored, and then goes on with what comes. The link's mirror checks every root as it does a server's.
/// Edits, uploads and the lead of the hand are refused.
/// @param sessionName  For people, as the options named it.
[[nodiscard]] ServerLink::Connect connectThroughNats(NatsOptions options, SessionSubjects subjects,
                                                     std::string sessionName);

}  // namespace haptics
