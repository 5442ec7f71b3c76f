#pragma once

#include <atomic>
#include <cstdint>

namespace haptics {

/// When the process is about to end by a signal of its own making (abort, and with it std::terminate; a fault of memory or
/// arithmetic), the watchdog hears of it on this socket at once: writing a core file takes seconds, during which the process
/// has not ended. Nothing else is done there. Whoever has a handler for such a signal keeps it.
/// @param socket  Of the watchdog; -1: there is none. Any thread.
void setDeathNoticeSocket(int socket) noexcept;
/// The same sets this flag; null: none. Any thread.
void setCrashFlag(std::atomic<std::uint32_t>* flag) noexcept;

}  // namespace haptics
