#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>

#include "common/error/error.h"
#include "common/process/file_handle.h"

namespace haptics {

/// A program that runs beside this one and is talked with over a socket, which is its standard input and output; it gets
/// no other descriptors, and standard error goes nowhere. Killed with the object, if it has not ended by then.
/// One thread, which must not end before.
class ChildProcess {
 public:
  /// \param patience  How long all that it does may take.
  /// \param stop      Ends what send() and receive() wait for.
  ChildProcess(const std::filesystem::path& program, std::chrono::milliseconds patience, std::stop_token stop);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// With a descriptor, unless that is -1. All are refused when the program could not be started, has ended (saying how),
  /// takes too long or was to stop.
  [[nodiscard]] Result<void> send(const void* bytes, std::size_t size, int descriptor = -1);
  [[nodiscard]] Result<void> receive(void* bytes, std::size_t size);
  [[nodiscard]] Result<std::string> receive(std::size_t size);

 private:
  using Clock = std::chrono::steady_clock;

  /// Ends a wait, from any thread.
  struct WakeUp {
    void operator()() const noexcept;
    FileHandle event;
  };

  std::string name_;
  Clock::time_point deadline_;
  std::stop_token stop_;
  WakeUp wakeUp_;
  std::stop_callback<std::reference_wrapper<WakeUp>> onStop_;
  FileHandle socket_;
  pid_t child_ = 0;      // 0: it was not started, or was waited for
  std::string failure_;  // why it was not started

  void start(const std::filesystem::path& program);
  [[nodiscard]] Result<void> waitFor(short events);
  [[nodiscard]] tl::unexpected<Error> ended();
  /// Killed if it has not ended after `patience`. @return Its status, as waitpid() has it.
  int wait(std::chrono::milliseconds patience) noexcept;
};

}  // namespace haptics
