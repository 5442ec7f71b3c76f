#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/error/error.h"
#include "common/wire/endpoint.h"
#include "graphics_client/mirror/server_link.h"

namespace haptics {

/// What every verb of hapticctl takes.
struct CommonOptions {
  Endpoint server;
  std::optional<ClientCredentials> credentials{};  ///< Of the server; nothing: it is spoken to without TLS.
  double timeout_s = 10;  ///< Longest time without a connection, or without news of what a verb waits for.
  bool json = false;
};

/// What hapticctl exits with; scripts rely on it.
enum ExitCode : int { kDone = 0, kRefused = 1, kUsage = 2, kNoConnection = 3, kInterrupted = 130 };

/// Of what a Connection, or what is done over one, was refused for: kNoConnection, or kRefused.
[[nodiscard]] ExitCode codeOf(const Error& error);
/// Prints "hapticctl: ..." on standard error and returns the code.
int fail(ExitCode code, const Error& error);

/// The link of one command to the server.
class Connection {
 public:
  struct Needs {
    double telemetryRate_Hz = 0;
    bool meshes = false;
    bool datagrams = false;
    TicksCallback onTicks = {};  ///< As ServerLink::Options.
  };

  Connection(const CommonOptions& options, Needs needs);

  /// Waits until the scene is mirrored. Refused: nobody answers in time, or the server turns this client away.
  [[nodiscard]] Result<std::shared_ptr<const MirrorView>> open();

  /// Waits for an answer. Refused: no connection, or nothing of the answer, for timeout_s.
  template <class T>
  [[nodiscard]] Result<T> await(std::future<T> answer) {
    return await(std::move(answer), [] { return false; });
  }
  /// The same; `look`, called now and then meanwhile, says whether more is known of the answer than before.
  template <class T, class Look>
  [[nodiscard]] Result<T> await(std::future<T> answer, Look look) {
    auto awaited = await(std::move(answer), std::move(look), [] { return false; });
    if (!awaited) return tl::unexpected(std::move(awaited).error());
    return **std::move(awaited);
  }
  /// The same; nothing once `givesUp` says so.
  template <class T, class Look, class GivesUp>
  [[nodiscard]] Result<std::optional<T>> await(std::future<T> answer, Look look, GivesUp givesUp) {
    std::uint64_t heard_ns = monotonicNow_ns();
    while (answer.wait_for(kLook) != std::future_status::ready) {
      if (givesUp()) return std::optional<T>();
      if (look()) heard_ns = monotonicNow_ns();
      if (1e-9 * static_cast<double>(monotonicNow_ns() - heard_ns) > options_.timeout_s) return noAnswer();
    }
    return std::optional<T>(answer.get());
  }

  [[nodiscard]] tl::unexpected<Error> noConnection(const MirrorView& view) const;
  [[nodiscard]] tl::unexpected<Error> noAnswer() const;
  [[nodiscard]] std::chrono::nanoseconds timeout() const noexcept;
  [[nodiscard]] ServerLink& link() noexcept { return link_; }

 private:
  static constexpr std::chrono::milliseconds kLook{50};  // between looks at how far the answer is

  CommonOptions options_;
  ServerLink link_;
};

}  // namespace haptics
