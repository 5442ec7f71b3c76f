"""The viewer's window, used as a person does: pointer and keys of an X server of its own."""
import math
import os
import signal
import statistics
import threading
import time
import unittest

import harness
from haptic_client import Client
from haptic_hand import xyz
from led_hand import GROUND, MAX_JUMP_N, force_N, jumps_N
from slow_link import SlowLink
from viewer_window import Window

BAD_LINK = {"rtt_s": 0.2, "jitter_s": 0.025, "loss": 0.05}
FOREHEAD, CHEEK = ((763, 250), (830, 252)), ((711, 397), (716, 450))  # strokes on the head, in pixels


class TouchWithMouse(harness.EndToEnd):
    def start(self, scene, slow=None, options=()):
        self.server = self.start_server(scene=scene, options=options)
        address = self.server.address
        if slow:
            link = SlowLink(self.server, **slow)
            self.addCleanup(link.close)
            address = link.address
        self.window = Window(address, self.start_display())
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

    def newest(self):
        return list(self.watcher.samples(0.3))[-1]

    def press(self, place):
        self.window.move_to(*place)
        self.window.do("mousedown", 1)
        self.addCleanup(self.window.do, "mouseup", 1)
        for _ in range(40):
            forces = [force_N(sample) for sample in self.watcher.samples(0.3)]
            leads = '"hand_leader":"graphics_client"' in self.server.ctl("status").output
            if leads and 0.9 < min(forces) and max(forces) < 1.1:  # the exploring hand presses with 2 N
                return
        self.fail("the hand does not press")

    def stroke(self, begin, end):
        """What was felt in 3 s with 1 N set, and the mean force of the contact."""
        self.press(begin)
        felt = self.felt_during(self.window.stroke, begin, end, 3)
        share = sum(sample.object != 0 for sample in felt) / len(felt)
        contact_N = statistics.mean(math.hypot(*xyz(sample.force.contact)) for sample in felt)
        speed = max(math.dist(xyz(a.hip), xyz(b.hip)) * 1e9 / (b.time_ns - a.time_ns)
                    for a, b in zip(felt, felt[1:]) if b.tick == a.tick + 1)
        print(f"\ncontact {100 * share:.1f} %, {contact_N:.3f} N, jumps up to {max(jumps_N(felt)):.4f} N, {speed:.2f} m/s",
              end="", flush=True)
        self.assertGreaterEqual(share, 0.95)
        self.assertLess(max(jumps_N(felt)), MAX_JUMP_N)
        self.assertLess(speed, 1)
        return contact_N

    def stroke_ground(self):
        self.assertAlmostEqual(self.stroke((736, 352), (938, 407)), 1, delta=0.1)

    def start_with_head(self, slow=None):
        # A device with fine encoders: one count of the Omni's (55 um) at the head's 800 N/m is 0.044 N.
        demo = (harness.PROJECT / "deploy/scenes/demo.scene").read_text()
        head, _ = demo.split('operations {\n  add {\n    name: "torus"')
        self.start(head, slow, options=["--device-preset", "omega.3", "--assets", "/usr/share/inventor/data"])

    def test_strokes_the_head(self):
        self.start_with_head()
        for begin, end in (FOREHEAD, CHEEK):
            self.stroke(begin, end)
            self.window.do("mouseup", 1)
            time.sleep(1)

    def test_strokes_the_head_over_a_bad_link(self):
        self.start_with_head(BAD_LINK)
        self.stroke(*FOREHEAD)

    def test_strokes_flat_ground_and_lets_go_when_it_is_killed(self):
        self.start(GROUND)
        self.stroke_ground()
        os.kill(self.window.process.pid, signal.SIGKILL)
        killed = time.monotonic_ns()
        felt = list(self.watcher.samples(1.5))
        free = next(sample for sample in felt if sample.time_ns > killed and force_N(sample) == 0)
        print(f"\nno force {1e-6 * (free.time_ns - killed):.0f} ms after the kill, jumps up to {max(jumps_N(felt)):.4f} N",
              end="", flush=True)
        self.assertLess(free.time_ns - killed, 600e6)
        self.assertLess(max(jumps_N(felt)), MAX_JUMP_N)

    def test_strokes_it_over_a_bad_link(self):
        self.start(GROUND, BAD_LINK)
        self.stroke_ground()

    def test_opens_and_closes_the_gripper_by_ctrl_and_the_wheel(self):
        self.start(GROUND, options=["--device-preset", "sigma.7"])
        self.press((736, 352))
        self.window.do("keydown", "ctrl")
        self.addCleanup(self.window.do, "keyup", "ctrl")
        for clicks, button, degrees in ((5, 4, 10), (20, 4, 30), (4, 5, 22)):  # at most 30
            self.window.do("click", "--repeat", clicks, "--delay", 20, button)
            harness.wait_until(lambda: abs(math.degrees(self.newest().device_gripper_rad) - degrees) < 1e-6, 60,
                               f"the gripper is not open by {degrees} degrees")
        self.assertAlmostEqual(force_N(self.newest()), 1, delta=0.1)


if __name__ == "__main__":
    unittest.main()
