"""The viewer's window on an X server of its own, used as a person does: pointer, keys, and what is seen, or what a screen
reader finds (AT-SPI)."""
import json
import os
import re
import struct
import subprocess
import sys
import time
from pathlib import Path

import harness

WIDTH, HEIGHT = 1270, 950
RESTING = ["--hand", "none"]  # of a server: nothing is drawn anew but what is edited


class Window(harness.Process):
    """graphics_client, in a window; it writes its files into `folder`."""

    def __init__(self, address, display, folder=None, size=(WIDTH, HEIGHT), env=None):
        self.display = display
        self.env = {"DISPLAY": display.name, "LP_NUM_THREADS": "1", **harness.FOREIGN_CODE, **(env or {})}
        super().__init__([harness.BIN / "graphics_client", "--connect", address, "--size", "%dx%d" % size, "--fps-limit",
                          "8"], env=self.env, cwd=folder)
        harness.wait_until(lambda: self.find(r"^scene revision \d+ root \w+ equal$"), harness.START_TIMEOUT_S,
                           lambda: f"the viewer holds no scene:\n{self.text()}")
        time.sleep(2)  # until the objects are drawn, and the camera shows them

    def do(self, *events):
        return subprocess.run(["xdotool", *map(str, events)], env={**os.environ, **self.env}, check=True,
                              capture_output=True, text=True).stdout

    def move_to(self, x, y):
        self.do("mousemove", x, y)

    def click(self, x, y):
        self.do("mousemove", x, y, "sleep", 0.2, "click", 1)

    def stroke(self, begin, end, seconds):
        steps, events = int(seconds * 60), []
        for i in range(steps + 1):
            events += ["mousemove", *(round(a + (b - a) * i / steps) for a, b in zip(begin, end)), "sleep", 1 / 60]
        self.do(*events)

    def drag(self, begin, end, seconds=0.5):
        self.move_to(*begin)
        time.sleep(0.2)
        self.do("mousedown", 1)
        self.stroke(begin, end, seconds)
        time.sleep(0.2)
        self.do("mouseup", 1)

    def type_into_dialog(self, title, text):
        """Into the field that has the focus when the dialog opens, with Return, again where it stays open: on a busy machine
        a Return was lost. There is no window manager to give it the focus."""
        harness.wait_until(lambda: self.windows(title), harness.START_TIMEOUT_S, f"no dialog {title!r}")
        for _ in range(3):
            if dialogs := self.windows(title):
                self.do("windowfocus", dialogs[0], "sleep", 0.2, "key", "ctrl+a", "type", "--delay", 5, text)
                self.do("key", "Return")
            try:
                harness.wait_until(lambda: not self.windows(title) and not self.windows(title), 10, f"{title!r} stays open")
            except AssertionError:
                continue
            return self.focus()
        raise AssertionError(f"{title!r} stays open")

    def windows(self, title):
        """Those that are seen. None, too, where one goes while they are looked at."""
        found = subprocess.run(["xdotool", "search", "--onlyvisible", "--name", f"^{re.escape(title)}$"],
                               env={**os.environ, **self.env}, capture_output=True, text=True, check=False)
        return found.stdout.split()

    def focus(self):
        windows = harness.wait_until(lambda: self.windows("Haptic viewer"), harness.START_TIMEOUT_S, "no window")
        self.do("windowfocus", "--sync", windows[0])

    def said(self, pattern, timeout_s=harness.START_TIMEOUT_S, times=1):
        """A line of the log, the last of so many."""
        def find():
            matches = [match for line in [*self.lines, *self.errors] if (match := re.search(pattern, line))]
            return matches[times - 1] if len(matches) >= times else None
        return harness.wait_until(find, timeout_s, lambda: f"never said {pattern!r}:\n{self.text()}", pause_s=0.005)

    def read_screen(self):
        """Four bytes a pixel, blue first; the screen's width in pixels; bytes of a line."""
        data = self.display.screen_file().read_bytes()
        header = struct.unpack(">25I", data[:100])
        width, bits, line_bytes, colors = header[4], header[11], header[12], header[19]
        if (bits, header[7]) != (32, 0):
            raise AssertionError("the screen's pixels are not four bytes, blue first")
        return data[header[0] + 12 * colors:], width, line_bytes

    def part_of_screen(self, left, top, right, bottom):
        """Bytes of its pixels."""
        data, _, line_bytes = self.read_screen()
        return b"".join(data[y * line_bytes + 4 * left:y * line_bytes + 4 * right] for y in range(top, bottom))

    def pixels(self, red, green, blue):
        """Where the screen has exactly this colour, as (x, y) from its upper left corner."""
        data, width, line_bytes = self.read_screen()
        found = []
        for match in re.finditer(re.escape(bytes((blue, green, red))), data):
            if match.start() % 4 == 0:
                y, x = divmod(match.start(), line_bytes)
                if x // 4 < width:
                    found.append((x // 4, y))
        return found


class MessageBus:
    """On which applications say what they show."""

    def __init__(self):
        self.process = subprocess.Popen(["dbus-daemon", "--session", "--nofork", "--print-address"],
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.address = self.process.stdout.readline().strip()

    def close(self):
        self.process.terminate()
        self.process.wait()
        self.process.stdout.close()


class ReadableWindow(Window):
    """Whose words and widgets are found by role ("slider", "menu item", "label") and name."""

    def __init__(self, address, display, bus, folder=None):
        super().__init__(address, display, folder=folder, env={"DBUS_SESSION_BUS_ADDRESS": bus.address,
                                                               "QT_LINUX_ACCESSIBILITY_ALWAYS_ON": "1"})

    def widgets(self):
        """All, the outer before the inner."""
        read = subprocess.run([sys.executable, Path(__file__).with_name("read_window.py"), str(self.process.pid)],
                              env={**os.environ, **self.env}, capture_output=True, text=True)
        return json.loads(read.stdout) if read.returncode == 0 else []  # it may change while it is read

    def widget(self, role, name):
        """The first of this role whose name matches."""
        def found():
            return next((each for each in self.widgets() if each["role"] == role and re.search(name, each["name"])), None)
        return harness.wait_until(found, harness.START_TIMEOUT_S, f"a {role} {name!r} in the window")

    @staticmethod
    def middle(widget):
        x, y, width, height = widget["box"]
        return x + width // 2, y + height // 2
