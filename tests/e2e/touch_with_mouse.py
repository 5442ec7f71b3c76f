"""The viewer's window, used as a person does: pointer and keys of an X server of its own."""
import os
import signal
import statistics
import subprocess
import threading
import time
import unittest

import harness
from haptic_client import Client
from led_hand import GROUND, MAX_JUMP_N, force_N, jumps_N

WIDTH, HEIGHT = 1270, 950


class Window(harness.Process):
    """graphics_client, in a window."""

    def __init__(self, address, display):
        self.env = {"DISPLAY": display.name, "LP_NUM_THREADS": "1", **harness.FOREIGN_CODE}
        super().__init__([harness.BIN / "graphics_client", "--connect", address, "--size", f"{WIDTH}x{HEIGHT}",
                          "--fps-limit", "60"], env=self.env)
        harness.wait_until(lambda: self.find(r"^scene revision \d+ root \w+ equal$"), harness.START_TIMEOUT_S,
                           lambda: f"the viewer holds no scene:\n{self.text()}")
        time.sleep(2)  # until the objects are drawn, and the camera shows them

    def do(self, *events):
        subprocess.run(["xdotool", *map(str, events)], env={**os.environ, **self.env}, check=True)

    def move_to(self, x, y):
        self.do("mousemove", x, y)

    def stroke(self, begin, end, seconds):
        steps = int(seconds * 60)
        for i in range(steps + 1):
            self.move_to(*(round(a + (b - a) * i / steps) for a, b in zip(begin, end)))
            time.sleep(1 / 60)


class TouchWithMouse(harness.EndToEnd):
    def start(self, scene):
        self.server = self.start_server(scene=scene)
        self.window = Window(self.server.address, self.start_display())
        self.addCleanup(self.window.kill)
        self.watcher = Client(self.server.address, "watcher", telemetry_hz=1000)
        self.watcher.wait_live()
        self.addCleanup(self.watcher.close)

    def felt_during(self, act, *arguments):
        felt, act = [], threading.Thread(target=act, args=arguments)
        act.start()
        while act.is_alive():
            felt += self.watcher.samples(0.05)
        return felt

    def press(self, place):
        self.window.move_to(*place)
        self.window.do("mousedown", 1)
        self.addCleanup(self.window.do, "mouseup", 1)
        for _ in range(100):
            felt = list(self.watcher.samples(0.1))
            if '"hand_leader":"graphics_client"' in self.server.ctl("status").output and force_N(felt[-1]) > 0.9:
                return
        self.fail("the hand does not press")

    def test_strokes_flat_ground_with_the_force_that_is_set(self):
        self.start(GROUND)
        self.press((760, 400))
        list(self.watcher.samples(1))
        felt = self.felt_during(self.window.stroke, (760, 400), (900, 440), 3)
        share = sum(sample.object != 0 for sample in felt) / len(felt)
        normal_N = statistics.mean(sample.force.contact.z for sample in felt)
        print(f"\ncontact {100 * share:.1f} %, {normal_N:.3f} N, jumps up to {max(jumps_N(felt)):.4f} N", end="", flush=True)
        self.assertGreaterEqual(share, 0.95)
        self.assertAlmostEqual(normal_N, 1, delta=0.1)
        self.assertLess(max(jumps_N(felt)), MAX_JUMP_N)
        os.kill(self.window.process.pid, signal.SIGKILL)
        killed = time.monotonic_ns()
        felt = list(self.watcher.samples(1.5))
        free = next(sample for sample in felt if sample.time_ns > killed and force_N(sample) == 0)
        print(f"\nno force {1e-6 * (free.time_ns - killed):.0f} ms after the kill, jumps up to {max(jumps_N(felt)):.4f} N",
              end="", flush=True)
        self.assertLess(free.time_ns - killed, 600e6)
        self.assertLess(max(jumps_N(felt)), MAX_JUMP_N)


if __name__ == "__main__":
    unittest.main()
