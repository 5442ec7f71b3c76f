#include "tests/eval/figure/figure.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "common/process/spawn.h"

namespace haptics::eval {

void drawFigure(const std::string& kind, const nlohmann::ordered_json& data, const std::filesystem::path& stem) {
  const auto script = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "eval_figures.py";
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> input(std::tmpfile(), std::fclose);
  const std::string text = data.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  if (!input || std::fwrite(text.data(), 1, text.size(), input.get()) != text.size() || std::fflush(input.get()) != 0)
    throw std::runtime_error("no temporary file can be written");
  std::rewind(input.get());
  const auto child = spawn("/usr/bin/python3", {.arguments = {"-B", script.string(), kind, stem.string()},
                                                .descriptors = {fileno(input.get()), STDOUT_FILENO, STDERR_FILENO}});
  int status = -1;
  while (child && waitpid(*child, &status, 0) < 0 && errno == EINTR) {
  }
  if (status != 0) throw std::runtime_error(stem.string() + ".png: is not drawn");
}

}  // namespace haptics::eval
