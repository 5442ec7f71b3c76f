#pragma once

#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <cstdio>

namespace haptics::eval {

/// How far a sweep is and how long it will take, on standard error: a bar on a terminal, else a line every ten seconds.
class SweepProgress {
 public:
  explicit SweepProgress(std::size_t size, std::size_t done = 0) : size_(size), already_(done) {}

  /// Makes room for other text on a terminal.
  void clear() const {
    if (onTerminal_) std::fprintf(stderr, "\r%79s\r", "");
  }

  void show(std::size_t done) {
    const auto now = std::chrono::steady_clock::now();
    const std::chrono::duration<double> since = now - shown_;
    if (!onTerminal_ && (done == size_ || since.count() < kLine_s)) return;
    shown_ = now;
    const std::chrono::duration<double> taken = now - begin_;
    const double left_s =
        done > already_ ? taken.count() / static_cast<double>(done - already_) * static_cast<double>(size_ - done) : 0;
    if (!onTerminal_) {
      std::fprintf(stderr, "%zu of %zu parts, some %.0f s left\n", done, size_, left_s);
      return;
    }
    char bar[kWidth + 1] = {};
    for (int i = 0; i < kWidth; ++i) bar[i] = static_cast<std::size_t>(i) * size_ < done * kWidth ? '#' : '.';
    std::fprintf(stderr, "\r%s %zu of %zu parts, some %.0f s left   %s", bar, done, size_, left_s,
                 done == size_ ? "\n" : "");
  }

 private:
  static constexpr int kWidth = 30;
  static constexpr double kLine_s = 10;

  const bool onTerminal_ = isatty(STDERR_FILENO) != 0;
  std::size_t size_, already_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now(), shown_ = begin_;
};

}  // namespace haptics::eval
