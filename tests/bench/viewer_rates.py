"""usage: viewer_rates.py BIN [BIN_BEFORE] [--turns 3]: how smooth the viewer's window is, as its screen shows it.

Pointer events are those of an X server of its own (XTest), and what is counted are changes of that server's pixels, in a window of
1280 x 800, drawn by software, beside the server:
  frames_per_s    while a drag turns the camera, 125 events a second, and the simulated hand explores
  event_to_pixel  from one event of a drag, all at rest before, to the first changed pixel
  settled_ms      from the end of a drag to the last changed pixel
  idle_percent    of a core, nothing moving
in the demo scene and with a sphere of a million triangles. With BIN_BEFORE, another build's, in turns. Writes JSON.
"""
import argparse
import contextlib
import ctypes
import json
import mmap
import os
import statistics
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "e2e"))

SIZE = (1280, 800)
SEEN = (600, 200, 1050, 420)  # left, top, right, bottom: in the picture, below the way of the pointer, which is drawn too
POINTER_Y = 60
MILLION = 'operations { add { name: "sphere" mesh { sphere { radius_m: 0.05 segments: 289 } } pose { position { z: 0.05 } } } }'
DRAG_S, EVENTS_HZ, FRAME_APART_S, EVENTS = 8, 125, 0.006, 40
DEMO = Path(__file__).parents[2] / "deploy" / "scenes" / "demo.scene"


class Pointer:
    """Of an X server: real events, without a program started for each."""

    def __init__(self, display):
        self.x11, self.test = ctypes.CDLL("libX11.so.6"), ctypes.CDLL("libXtst.so.6")
        self.x11.XOpenDisplay.restype = ctypes.c_void_p
        self.display = ctypes.c_void_p(self.x11.XOpenDisplay(display.encode()))

    def move(self, x, y):
        self.test.XTestFakeMotionEvent(self.display, -1, int(x), int(y), ctypes.c_ulong(0))
        self.x11.XFlush(self.display)

    def press(self, down):
        """The right button, which turns the camera."""
        self.test.XTestFakeButtonEvent(self.display, 3, int(down), ctypes.c_ulong(0))
        self.x11.XFlush(self.display)


class Screen:
    """The pixels of the picture's middle, in every eighth line."""

    def __init__(self, file):
        self.data = mmap.mmap(os.open(file, os.O_RDONLY), 0, access=mmap.ACCESS_READ)
        header = struct.unpack(">25I", self.data[:100])
        begin, line = header[0] + 12 * header[19], header[12]
        left, top, right, bottom = SEEN
        self.lines = [slice(begin + y * line + 4 * left, begin + y * line + 4 * right) for y in range(top, bottom, 8)]

    def sum(self):
        value = 0
        for line in self.lines:
            value = zlib.crc32(self.data[line], value)
        return value

    def change(self, since, timeout_s=2.0):
        """When it is no longer `since`, or None."""
        end = time.perf_counter() + timeout_s
        while (now := time.perf_counter()) < end:
            if self.sum() != since:
                return now
            time.sleep(5e-4)
        return None

    def last_change(self, quiet_s=1.0):
        """When it changed last before it stayed the same for so long."""
        last, seen = time.perf_counter(), self.sum()
        while (now := time.perf_counter()) < last + quiet_s:
            if (value := self.sum()) != seen:
                last, seen = now, value
            time.sleep(1e-3)
        return last


def frames_per_s(pointer, screen):
    x, y = (SEEN[0] + SEEN[2]) / 2, POINTER_Y
    pointer.move(x, y)
    pointer.press(True)
    begin = time.perf_counter()
    frames, seen, last, event = 0, screen.sum(), 0.0, begin
    while (now := time.perf_counter()) < begin + DRAG_S:
        if now >= event:
            step = int((now - begin) * EVENTS_HZ)
            pointer.move(x + abs(step % 400 - 200) - 100, y)
            event += 1 / EVENTS_HZ
        if (value := screen.sum()) != seen:
            frames += now - last > FRAME_APART_S
            seen, last = value, now
        time.sleep(1e-3)
    pointer.press(False)
    return frames / DRAG_S


def event_to_pixel_ms(pointer, screen):
    """(Of every event that was seen, sorted; from the end of the drag until the picture is at rest.)"""
    x, y, found = (SEEN[0] + SEEN[2]) / 2, POINTER_Y, []
    pointer.move(x, y)
    pointer.press(True)
    for i in range(EVENTS):
        screen.last_change(0.3)
        before, x = screen.sum(), x + (20 if i % 10 < 5 else -20)
        began = time.perf_counter()
        pointer.move(x, y)
        changed = screen.change(before)
        if changed:
            found.append(1e3 * (changed - began))
    pointer.move(x + 10, y)
    time.sleep(0.05)
    released = time.perf_counter()
    pointer.press(False)
    return sorted(found), max(0.0, 1e3 * (screen.last_change() - released))


def idle_percent(process, seconds=10):
    def busy_s():
        fields = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    before = busy_s()
    time.sleep(seconds)
    return 100 * (busy_s() - before) / seconds


@contextlib.contextmanager
def window(binaries, scene, options):
    """(Its pointer, its screen, its process.)"""
    import harness
    harness.BIN = binaries
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as until_end:
        server = harness.Server(folder, scene=scene, options=["--assets", "/usr/share/inventor/data", *options])
        until_end.callback(server.kill)
        display = harness.Display(folder)
        until_end.callback(display.close)
        viewer = harness.Process([binaries / "graphics_client", "--connect", server.address, "--size", "%dx%d" % SIZE],
                                 env={"DISPLAY": display.name, "XDG_CONFIG_HOME": folder})
        until_end.callback(viewer.kill)
        harness.wait_until(lambda: viewer.find("^scene revision .* equal$"), 60, viewer.text)
        time.sleep(4)
        yield Pointer(display.name), Screen(display.screen_file()), viewer.process.pid


def measure(binaries, scene):
    with window(binaries, scene, []) as (pointer, screen, _):
        rate = frames_per_s(pointer, screen)
    with window(binaries, scene, ["--hand", "none"]) as (pointer, screen, process):
        idle = idle_percent(process)
        latencies, settled = event_to_pixel_ms(pointer, screen)
    if not latencies:
        sys.exit("no event changed a pixel")
    return {"frames_per_s": rate, "event_to_pixel_p50_ms": statistics.median(latencies),
            "event_to_pixel_p95_ms": latencies[int(0.95 * len(latencies))], "events_seen": len(latencies),
            "settled_ms": settled, "idle_percent": idle}


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("usage: ")[1])
    parser.add_argument("bin", type=Path)
    parser.add_argument("before", type=Path, nargs="?")
    parser.add_argument("--turns", type=int, default=3)
    options = parser.parse_args()
    os.environ["HAPTICS_BIN"] = str(options.bin)
    builds = {"head": options.bin.resolve(), **({"before": options.before.resolve()} if options.before else {})}
    found = {}
    for turn in range(options.turns):
        for scene, text in (("demo", DEMO), ("million", MILLION)):
            for build, binaries in builds.items():
                print(f"turn {turn + 1}: {scene}, {build}", file=sys.stderr)
                found.setdefault(scene, {}).setdefault(build, []).append(measure(binaries, text))
    print(json.dumps({"events": EVENTS, "turns": options.turns, "load_average": round(os.getloadavg()[0], 1), "scenes": {
        scene: {build: {key: round(statistics.median(run[key] for run in runs), 1) for key in runs[0]}
                for build, runs in of.items()} for scene, of in found.items()}}, indent=1))


if __name__ == "__main__":
    main()
