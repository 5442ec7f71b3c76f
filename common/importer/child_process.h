#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>

#include "common/error/error.h"

namespace haptics {

/// A program that runs beside this one and is talked with over a socket, which is its standard input and output; it gets
/// no other descriptors, and standard error goes nowhere. Killed with the object, if it has not ended by then. Spawned,
/// not forked, so that the pages of a process with locked memory are not copied. One thread, which must not end before.
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

  class WakeUp {
   public:
    WakeUp();
    ~WakeUp();
    WakeUp(const WakeUp&) = delete;
    WakeUp& operator=(const WakeUp&) = delete;
    [[nodiscard]] int descriptor() const noexcept { return descriptor_; }
    void operator()() const noexcept;

   private:
    int descriptor_;
  };

  std::string name_;
  Clock::time_point deadline_;
  std::stop_token stop_;
  WakeUp wakeUp_;
  std::stop_callback<std::reference_wrapper<WakeUp>> onStop_;
  int socket_ = -1;
  pid_t child_ = 0;      // 0: it was not started, or was waited for
  std::string failure_;  // why it was not started

  void start(const std::filesystem::path& program);
  [[nodiscard]] Result<void> waitFor(short events);
  [[nodiscard]] tl::unexpected<Error> ended();
  /// Killed if it has not ended after `patience`. @return Its status, as waitpid() has it.
  int wait(std::chrono::milliseconds patience) noexcept;
};

}  // namespace haptics
