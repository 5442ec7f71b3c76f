#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace haptics::stress {

/// A process of ours, killed when this goes.
class Child {
 public:
  Child() = default;
  /// `prepare` runs in the child before the program; what the program prints goes to `output`.
  Child(const std::vector<std::string>& command, const std::filesystem::path& output,
        const std::function<void()>& prepare);
  ~Child() { kill(); }
  Child(Child&& other) noexcept : process_(other.process_) { other.process_ = 0; }
  Child& operator=(Child&& other) noexcept {
    std::swap(process_, other.process_);
    return *this;
  }

  void signal(int number) const;
  void kill();                  ///< SIGKILL, and waits.
  int wait();                   ///< Until it ends; the exit code, or -1 when it was killed.
  int stop(double patience_s);  ///< SIGTERM; the exit code, or -1 when it had to be killed.
  [[nodiscard]] pid_t id() const noexcept { return process_; }
  [[nodiscard]] bool alive();
  [[nodiscard]] double resident_MB() const;
  [[nodiscard]] double processor_s() const;  ///< That it has had, of all cores.

 private:
  pid_t process_ = 0;
};

}  // namespace haptics::stress
