#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "graphics_client/audience/nats_connection.h"
#include "graphics_client/audience/session_subjects.h"
#include "graphics_client/mirror/server_link.h"

namespace haptics {

/// A relay gives a sign 60 times a second, at least once: without one for so long there is none.
inline constexpr std::uint64_t kSignWithin_ns = 3'000'000'000;
/// A sample behind which more messages wait is not looked at: the newest counts, and all came while the session was read.
inline constexpr std::size_t kMaxBehindSample = 4;

/// The way to a session that a relay publishes (ServerLink::Options::connect): each attempt waits for a sign of the relay,
/// reads what is stored, and then goes on with what comes. The link's mirror checks every root as it does a server's.
/// Edits, uploads and the lead of the hand are refused.
/// @param sessionName  For people, as the options named it.
[[nodiscard]] ServerLink::Connect connectThroughNats(NatsOptions options, SessionSubjects subjects,
                                                     std::string sessionName);

}  // namespace haptics
