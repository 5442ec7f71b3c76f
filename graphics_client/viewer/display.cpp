#include <X11/Xlib.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <utility>

#include "graphics_client/viewer/viewer.h"

namespace haptics {
namespace {

std::function<void()> beforeTheEnd;  // called with the display gone

}  // namespace

Result<void> checkDisplay() {
  const std::string advice =
      "; run it in a desktop session, or as: xvfb-run -a -s \"-screen 0 1280x1024x24\" graphics_client ...";
  const char* name = std::getenv("DISPLAY");
  if (!name || !*name) return refused("DISPLAY", "is not set, so there is no X display to draw on" + advice);
  // Held until the process ends: Xvfb resets itself when its last client leaves, and would turn VTK away that moment.
  static const Display* const display = XOpenDisplay(nullptr);
  if (display == nullptr)
    return refused("DISPLAY", "names \"" + std::string(name) + "\", which does not answer" + advice);
  return {};
}

void onDisplayLost(std::function<void()> orderly) {
  beforeTheEnd = std::move(orderly);
  XSetIOErrorHandler([](Display*) -> int { displayLost(); });
}

void displayLost() {
  std::fprintf(stderr, "graphics_client: DISPLAY: the X server has gone away\n");
  if (const auto orderly = std::exchange(beforeTheEnd, nullptr)) orderly();
  std::fflush(nullptr);
  std::_Exit(EXIT_FAILURE);
}

}  // namespace haptics
