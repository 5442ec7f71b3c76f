#pragma once

#include <sys/types.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tests/eval/adapters/protocol.h"

namespace haptics::eval {

/// A method from outside has crashed, hung, or answered what is no answer. The text names where and how.
class MethodFault : public std::runtime_error {
  using runtime_error::runtime_error;
};

/// The scene needs what the method does not declare; the text names it.
class NotApplicable : public std::runtime_error {
  using runtime_error::runtime_error;
};

/// A process that runs a method: a shared library in method_host, or a command that speaks the protocol itself.
class AdapterProcess {
 public:
  /// Throws MethodFault.
  explicit AdapterProcess(const std::string& command);
  ~AdapterProcess();
  AdapterProcess(const AdapterProcess&) = delete;
  AdapterProcess& operator=(const AdapterProcess&) = delete;

  /// Sends, and waits for the answer, which stays until the next one. Throws MethodFault, `where` in its text; from then on
  /// there is no process.
  std::string_view ask(adapter::Kind kind, std::string_view message, std::chrono::milliseconds limit,
                       const std::string& where);

 private:
  using Clock = std::chrono::steady_clock;
  void send(std::string_view bytes, Clock::time_point until, const std::string& where);
  void receive(std::size_t count, Clock::time_point until, const std::string& where);
  void await(short what, Clock::time_point until, const std::string& where);
  [[noreturn]] void fail(const std::string& what);
  [[nodiscard]] std::string howItEnded();
  void end();

  pid_t process_ = 0;
  int socket_ = -1;
  std::string bytes_;  // read, beginning with the answer that is asked for
};

}  // namespace haptics::eval
