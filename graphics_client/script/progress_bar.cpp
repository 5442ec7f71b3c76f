#include "graphics_client/script/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>

namespace haptics {

void showProgress(const std::string& what, std::optional<double> share, const std::string& after) {
  constexpr int kBar = 30;  // characters
  if (isatty(STDERR_FILENO) == 0) return;
  const double done = share ? std::clamp(*share, 0.0, 1.0) : 0;
  const std::string bar(static_cast<std::size_t>(kBar * done), '#');
  const std::string percent = share ? std::to_string(static_cast<int>(100 * done)) + " % " : "";
  std::fprintf(stderr, "\r%s [%-*s] %s%s\033[K", what.c_str(), kBar, bar.c_str(), percent.c_str(), after.c_str());
}

void endProgress() {
  if (isatty(STDERR_FILENO) != 0) std::fputc('\n', stderr);
}

}  // namespace haptics
