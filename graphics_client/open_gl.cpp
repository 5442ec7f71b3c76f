#include "graphics_client/open_gl.h"

#include <GL/glx.h>

#include <memory>

namespace haptics {

Result<void> checkOpenGl() {
  const std::unique_ptr<Display, int (*)(Display*)> display(XOpenDisplay(nullptr), XCloseDisplay);
  if (!display) return {};  // checkDisplay() says so
  const std::string name = DisplayString(display.get());
  const std::string advice =
      "; over ssh or VNC run the viewer where the screen is (graphics_client --connect HOST:PORT), or without a "
      "screen: "
      "xvfb-run -a -s \"-screen 0 1280x1024x24\" graphics_client ...";
  int error = 0, event = 0;
  if (glXQueryExtension(display.get(), &error, &event) == 0) {
    return refused("DISPLAY", "\"" + name + "\" has no OpenGL (no GLX extension)" + advice);
  }
  const int wanted[] = {GLX_DRAWABLE_TYPE,
                        GLX_WINDOW_BIT,
                        GLX_RENDER_TYPE,
                        GLX_RGBA_BIT,
                        GLX_RED_SIZE,
                        1,
                        GLX_GREEN_SIZE,
                        1,
                        GLX_BLUE_SIZE,
                        1,
                        GLX_DEPTH_SIZE,
                        1,
                        GLX_DOUBLEBUFFER,
                        1,
                        None};
  int count = 0;
  const std::unique_ptr<GLXFBConfig, int (*)(void*)> found(
      glXChooseFBConfig(display.get(), DefaultScreen(display.get()), wanted, &count), XFree);
  if (count > 0) return {};
  return refused("DISPLAY", "\"" + name + "\" shows " +
                                std::to_string(DefaultDepth(display.get(), DefaultScreen(display.get()))) +
                                " bits a pixel, in which OpenGL does not draw; it takes 24" + advice);
}

}  // namespace haptics
