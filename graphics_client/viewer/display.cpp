#include <X11/Xlib.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "graphics_client/viewer/viewer.h"

namespace haptics {

Result<void> checkDisplay() {
  const std::string advice =
      "; run it in a desktop session, or as: xvfb-run -a -s \"-screen 0 1280x1024x24\" graphics_client ...";
  const char* name = std::getenv("DISPLAY");
  if (!name || !*name) return refused("DISPLAY", "is not set, so there is no X display to draw on" + advice);
  // Held until the process ends: Xvfb resets itself when its last client leaves, and would turn VTK away that moment.
  static const std::unique_ptr<Display, int (*)(Display*)> display(XOpenDisplay(nullptr), XCloseDisplay);
  if (!display) return refused("DISPLAY", "names \"" + std::string(name) + "\", which does not answer" + advice);
  return {};
}

}  // namespace haptics
