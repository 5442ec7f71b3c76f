#pragma once

#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>

#include "common/wire/event_loop.h"

// Asio behind the EventLoop: for this folder's own sources only.
namespace haptics {

struct EventLoop::Context {
  asio::io_context io{1};
};

}  // namespace haptics
