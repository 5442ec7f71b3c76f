"""Bodies that MuJoCo moves, felt by the simulated hand: pressed, pushed and left, by the example mujoco_guests.

HAPTICS_LONG: at every rate, delay and mass, and at the extremes on every preset. usage: guests.py [-v]
"""
import json
import math
import os
import re
import signal
import statistics
import sys
import unittest

import harness
from haptic_client import Client

FOLDER = harness.PROJECT / "graphics_client" / "examples" / "mujoco_guests"
LONG = "HAPTICS_LONG" in os.environ
RATES_HZ, LATE_MS, MASSES_KG = (50, 100, 500), (0, 20), (0.01, 0.1, 1, 10)
SHORT = [(500, 0, 0.1), (50, 20, 0.01), (50, 20, 10)]
EXTREMES = [(hz, late_ms, mass_kg) for hz in RATES_HZ[::2] for late_ms in LATE_MS for mass_kg in MASSES_KG[::3]]
PRESETS = ["omni", "touch", "premium-1.5", "desktop", "falcon", "omega.3", "omega.6", "sigma.7"]
PRESS_N, ROUNDING_J = 1.0, 1e-9
UP = (0, 0, 1)


class Guests(harness.EndToEnd):
    def start_guests(self, seconds, *how):
        guests = harness.Process([harness.BIN / "mujoco_guests", self.server.address, FOLDER / "table.xml", seconds, *how])
        self.addCleanup(guests.kill)
        return guests

    def client(self):
        client = Client(self.server.address, "hand", telemetry_hz=1000)
        client.wait_live()
        self.addCleanup(client.close)
        return client

    def block(self, guests):
        self.assertEqual(guests.wait(), 0, guests.text())
        return next(body for body in map(json.loads, guests.lines) if body["body"] == "block")

    def press(self, hz, late_ms, mass_kg):
        client = self.client()
        with client.hand() as hand:
            hand.move_to((0.01, 0.005, 0.08))
            guests = self.start_guests(5, hz, late_ms, mass_kg)
            harness.wait_until(lambda: "block" in client.bodies(), 10, guests.text)
            felt = hand.press((0.01, 0.005, 0.04), UP, PRESS_N, 6)
            block = self.block(guests)
            hand.move_to((0.01, 0.005, 0.08))
        client.close()
        last = [s.force.written.z for s in felt if felt[-1].tick - 2500 < s.tick < felt[-1].tick - 1500]
        return block, statistics.mean(last), statistics.pstdev(last)

    def check_press(self, hz, late_ms, mass_kg):
        block, felt_N, shakes_N = self.press(hz, late_ms, mass_kg)
        pressed_N = block["table_N"] - block["weight_N"]
        print(f"\n{hz} Hz, {late_ms} ms late, {mass_kg} kg: felt {felt_N:.3f} N, shaking {shakes_N:.4f} N, told {-block['told_N']:.3f} N, "
              f"on the table {pressed_N:.3f} N, least energy {1e6 * block['lowest_J']:.1f} uJ, {1e3 * block['speed_m_per_s']:.3f} mm/s",
              end="", flush=True)
        self.assertGreaterEqual(block["lowest_J"], -ROUNDING_J)
        self.assertAlmostEqual(-block["told_N"], felt_N, delta=0.1 * PRESS_N)
        self.assertAlmostEqual(pressed_N, felt_N, delta=0.1 * PRESS_N)
        self.assertLess(shakes_N, 0.05)
        self.assertLess(block["speed_m_per_s"], 2e-3)

    def test_a_pressed_guest_rests_in_the_hand(self):
        self.server = self.start_server(scene=FOLDER / "table.scene")
        for hz, late_ms, mass_kg in [(a, b, c) for a in RATES_HZ for b in LATE_MS for c in MASSES_KG] if LONG else SHORT:
            with self.subTest(hz=hz, late_ms=late_ms, mass_kg=mass_kg):
                self.check_press(hz, late_ms, mass_kg)

    def test_a_pressed_guest_rests_in_a_light_hand_on_every_device(self):
        for preset in PRESETS if LONG else PRESETS[-1:]:
            self.server = self.start_server(scene=FOLDER / "table.scene", options=["--device-preset", preset, "--hand", "light"])
            print(f"\n{preset}:", end="", flush=True)
            for hz, late_ms, mass_kg in EXTREMES if LONG else SHORT[1:2]:
                with self.subTest(preset=preset, hz=hz, mass_kg=mass_kg):
                    self.check_press(hz, late_ms, mass_kg)
            self.server.stop()

    def test_a_guest_is_pushed_along_and_left_where_it_is(self):
        self.server = self.start_server(scene=FOLDER / "table.scene")
        for hz, late_ms in ((500, 0), (50, 20)):
            with self.subTest(hz=hz, late_ms=late_ms):
                client = self.client()
                with client.hand() as hand:
                    hand.move_to((-0.08, 0, 0.08))
                    hand.move_to((-0.08, 0, 0.02))
                    guests = self.start_guests(6, hz, late_ms, 0.1)
                    harness.wait_until(lambda c=client: "block" in c.bodies(), 10, guests.text)
                    felt = hand.move_to((0.0, 0, 0.02), 0.05)
                    hand.move_to((-0.08, 0, 0.02), 0.05)
                    block = self.block(guests)
                client.close()
                print(f"\n{hz} Hz, {late_ms} ms late: pushed to {block['at'][0]:.4f} m, least energy {1e6 * block['lowest_J']:.1f} uJ",
                      end="", flush=True)
                self.assertGreater(max(math.hypot(s.force.written.x, s.force.written.y) for s in felt), 0.2)
                self.assertGreater(block["at"][0], 0.02)
                self.assertLess(block["speed_m_per_s"], 2e-3)
                self.assertGreaterEqual(block["lowest_J"], -ROUNDING_J)

    def test_a_guest_of_python_is_pushed_along_and_left_where_it_is(self):
        self.server = self.start_server(scene=FOLDER / "table.scene")
        example = harness.PROJECT / "graphics_client" / "script" / "python" / "examples" / "slide_block.py"
        client = self.client()
        with client.hand() as hand:
            hand.move_to((-0.08, 0, 0.08))
            hand.move_to((-0.08, 0, 0.02))
            guest = harness.Process([sys.executable, example, "--connect", self.server.address, "--seconds", 6, "block"])
            self.addCleanup(guest.kill)
            harness.wait_until(lambda: "block" in client.bodies(), 10, guest.text)
            felt = hand.move_to((0.0, 0, 0.02), 0.05)
            hand.move_to((-0.08, 0, 0.02), 0.05)
            self.assertEqual(guest.wait(), 0, guest.text())
            left = client.bodies()["block"].pose.position.x
        forces_N = [math.hypot(s.force.written.x, s.force.written.y) for s in felt]
        self.assertGreater(max(forces_N), 0.2)
        self.assertGreater(left, 0.02)
        self.assertAlmostEqual(float(re.search(r"block is (\S+) mm", guest.text())[1]), 1e3 * left, delta=0.1)

    def test_a_guest_whose_engine_stops_stands_still(self):
        self.server = self.start_server(scene=FOLDER / "table.scene")
        client = self.client()
        with client.hand() as hand:
            hand.move_to((0.01, 0.005, 0.08))
            guests = self.start_guests(60, 500)
            harness.wait_until(lambda: "block" in client.bodies(), 10, guests.text)
            hand.press((0.01, 0.005, 0.04), UP, PRESS_N, 1)
            guests.send(signal.SIGSTOP)
            felt = hand.press((0.01, 0.005, 0.04), UP, PRESS_N, 2)
            jumps = [abs(b.force.written.z - a.force.written.z) for a, b in zip(felt, felt[1:]) if b.tick == a.tick + 1]
            self.assertLess(max(jumps), 0.05)
            self.assertAlmostEqual(felt[-1].force.written.z, PRESS_N, delta=0.1)
        guests.kill()
        self.assertEqual(self.server.status()["fault"], "FAULT_NONE")


if __name__ == "__main__":
    unittest.main()
