#include "graphics_client/script/connection.h"

#include <cstdio>
#include <sstream>
#include <string>
#include <utility>

#include "common/text/printable.h"

namespace haptics {

namespace {

constexpr const char* kConnect = "--connect ";

}  // namespace

ExitCode codeOf(const Error& error) { return error.field.starts_with(kConnect) ? kNoConnection : kRefused; }

int fail(ExitCode code, const Error& error) {
  std::fprintf(stderr, "hapticctl: %s\n", printable(error.text()).c_str());
  return code;
}

Connection::Connection(const CommonOptions& options, Needs needs)
    : options_(options),
      link_({.server = options.server,
             .clientName = "hapticctl",
             .credentials = options.credentials,
             .telemetryRate_Hz = needs.telemetryRate_Hz,
             .fetchAssets = needs.meshes,
             .datagrams = needs.datagrams,
             .onTicks = std::move(needs.onTicks)}) {}

Result<std::shared_ptr<const MirrorView>> Connection::open() {
  auto view = link_.waitUntil(
      [](const MirrorView& v) { return v.link == LinkState::kLive || v.link == LinkState::kRefused; }, timeout());
  if (!view || view->link == LinkState::kRefused) return noConnection(*link_.latest());
  return view;
}

tl::unexpected<Error> Connection::noConnection(const MirrorView& view) const {
  return refused(kConnect + options_.server.text(), "no connection: " + view.linkText);
}

tl::unexpected<Error> Connection::noAnswer() const {
  const auto view = link_.latest();
  if (view->link != LinkState::kLive) return noConnection(*view);
  std::ostringstream seconds;
  seconds << options_.timeout_s;
  return refused(kConnect + options_.server.text(),
                 "no answer within " + seconds.str() + " s; --timeout gives it longer");
}

std::chrono::nanoseconds Connection::timeout() const noexcept {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(options_.timeout_s * 1e9));
}

}  // namespace haptics
