#pragma once

namespace haptics {

/// When the process is about to end by a signal of its own making (abort, and with it std::terminate; a fault of memory or
/// arithmetic), the watchdog hears of it on this socket at once: writing a core file takes seconds, during which the process
/// has not ended. Nothing else is done there. Whoever has a handler for such a signal keeps it.
/// @param socket  Of the watchdog; -1: there is none. Any thread.
void setDeathNoticeSocket(int socket) noexcept;

}  // namespace haptics
