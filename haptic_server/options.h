#pragma once

#include <variant>

#include "haptic_server/server_options.h"

namespace haptics {

/// The options, or the exit code with which to leave (0 after --help; the message has been printed).
[[nodiscard]] std::variant<ServerOptions, int> parseServerOptions(int argc, char** argv);

}  // namespace haptics
