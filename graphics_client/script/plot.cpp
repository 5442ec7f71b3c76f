#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "common/process/spawn.h"
#include "graphics_client/script/interrupt.h"
#include "graphics_client/script/progress_bar.h"
#include "graphics_client/script/verbs.h"

namespace haptics {
namespace {

/// Made, and removed with what is in it.
class TemporaryFolder {
 public:
  [[nodiscard]] static Result<TemporaryFolder> make() {
    std::error_code failure;
    const auto where = std::filesystem::temp_directory_path(failure);
    std::string made = (where / "hapticctl-XXXXXX").string();
    if (!failure && mkdtemp(made.data()) == nullptr) failure.assign(errno, std::generic_category());
    if (failure) return refused("TMPDIR", "no folder can be made there: " + failure.message());
    return TemporaryFolder(made);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(TemporaryFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  explicit TemporaryFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

/// The module haptic_plot of the Python client: beside the programs of a build, else where Python finds it.
[[nodiscard]] Result<void> draw(const std::filesystem::path& session, const PlotOptions& options) {
  std::error_code ignored;
  const auto beside = std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path().parent_path() / "python";
  const std::string title = options.title.empty() ? options.recording.filename().string() : options.title;
  if (exists(beside / "haptic_plot.py")) setenv("PYTHONPATH", beside.c_str(), 1);
  const auto child =
      spawn("/usr/bin/python3",
            {.arguments = {"-m", "haptic_plot", "--out", options.out.string(), "--title", title, session.string()},
             .descriptors = {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}});
  if (!child) return refused("", "a plot needs python3 with the packages python3-matplotlib and python3-h5py");
  int status = 0;
  while (waitpid(*child, &status, 0) < 0 && errno == EINTR) {
  }
  return status == 0 ? Result<void>() : refused("", "no plot was made");
}

}  // namespace

int plot(const CommonOptions& /*common*/, const PlotOptions& options) {
  const Interrupt interrupt;
  std::filesystem::path session = options.recording;
  std::optional<TemporaryFolder> folder;
  if (options.recording.extension() != ".h5" && options.recording.extension() != ".hdf5") {
    auto made = TemporaryFolder::make();
    if (!made) return fail(kRefused, made.error());
    session = folder.emplace(*std::move(made)).path() / "session.h5";
    const auto end = exportRecording(options.recording, session, ExportFormat::kHdf5, [](double share) {
      showProgress("reading", share);
      return !Interrupt::interrupted();
    });
    endProgress();
    if (Interrupt::interrupted()) return kInterrupted;
    if (!end) return fail(kRefused, end.error());
    if (!end->note.empty()) std::fprintf(stderr, "hapticctl: %s\n", end->note.c_str());
  }
  if (const auto drawn = draw(session, options); !drawn) return fail(kRefused, drawn.error());
  return kDone;
}

}  // namespace haptics
