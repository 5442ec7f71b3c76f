"""Two hands in one scene: each is led, felt and recorded by itself, and both together pinch a brick and lift it."""
import math
import subprocess
import sys
import unittest

import harness
from haptic_client import Client, NotLeading

TOP = harness.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(TOP / "graphics_client/script/python/examples"))
import lift_with_two_hands  # noqa: E402

SCENE = (TOP / "deploy/scenes/pinch.scene").read_text()
TWO = ["--hand", "nominal", "--hand", "nominal"]


class Arguments:
    half_width, press, above, lift, seconds = 0.025, 0.006, 0.003, 0.05, 3


class TwoHands(harness.EndToEnd):
    def replay(self, file):
        done = subprocess.run([harness.BIN / "haptic_eval", "replay", file, "--out", self.folder / "out"],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def lift(self, client):
        """In a round in which the hands were led all the time."""
        brick = client.objects()["brick"]
        for _ in range(5):
            try:
                return lift_with_two_hands.lift(client, brick, Arguments)
            except lift_with_two_hands.HeldUp as error:
                print(f"\n{error}", end="", flush=True)
        self.fail("no round could be judged")

    def test_pinch_and_lift_a_brick_and_replay_bit_for_bit(self):
        file = self.folder / "ticks.haptics"
        server = self.start_server(scene=SCENE, options=TWO + ["--record", file])
        viewer = self.start_viewer(server.address, self.start_display())
        with Client(server.address, "lifter", telemetry_hz=100) as client:
            client.wait_live()
            height, slid = self.lift(client)
        print(f"\nheld {1e3 * height:.1f} mm high, slid {1e3 * slid:.2f} mm", end="", flush=True)
        self.assertGreater(height, 0.04)
        self.assertLess(slid, 0.005)
        status = server.status()
        self.assertIn("Omni", status["second_hand"]["device"])
        self.assertGreater(int(status["second_hand"]["contact_ticks"]), 1000)
        viewer.wait_for(status["revision"], status["root"])
        self.assertEqual(viewer.stop(), 0, viewer.text())
        self.stop_and_check(server)
        self.assertIn("second_hand", server.summary())
        self.replay(file)
        played = self.start_server(device=f"replay:{file}")
        lines = played.ctl("watch", "--rate", "50", "--seconds", "1").output.splitlines()
        self.assertTrue(any("second_hand" in harness.json.loads(line) for line in lines))
        self.assertEqual(played.stop(), 0, played.text())

    def test_each_is_led_by_one_client(self):
        server = self.start_server(scene=SCENE, options=TWO)
        with Client(server.address, "left", telemetry_hz=100) as left, \
                Client(server.address, "right", telemetry_hz=100) as right:
            left.wait_live()
            right.wait_live()
            with left.hand(1), right.hand(2) as hand:
                with self.assertRaisesRegex(NotLeading, "led by right"):
                    left.hand(2).__enter__()
                felt = hand.press((0.08, 0.03, 0.03), (0, 0, 1), 1.0, 1.0)
                forces = [sample.second_hand.force.written for sample in felt]
                self.assertGreater(max(math.hypot(f.x, f.y, f.z) for f in forces), 0.5)
                self.assertEqual(server.status()["second_hand"]["hand_leader"], "right")
        with self.assertRaisesRegex(ValueError, "hands 1 and 2"):
            left.hand(3)
        self.stop_and_check(server)

    def test_where_there_is_one_the_second_is_refused(self):
        server = self.start_server(scene=SCENE)
        with Client(server.address, "one", telemetry_hz=100) as client:
            client.wait_live()
            with self.assertRaisesRegex(NotLeading, "this server has one"):
                client.hand(2).__enter__()
        self.assertNotIn("second_hand", server.status())
        self.stop_and_check(server)

    def test_options_of_two_that_do_not_go_together_are_named(self):
        for options, said in ((["--hand", "nominal"] * 3, "--hand"),
                              (["--device", "simulated", "--device", "replay:none"], "it is given alone"),
                              (["--hand", "nominal", "--hand", "iron"], "iron"),
                              (["--device", "simulated", "--device", "plugin:none.so"], "second hand")):
            with self.subTest(options=options):
                done = subprocess.run([harness.BIN / "haptic_server", "--listen", "127.0.0.1:0", *options],
                                      capture_output=True, text=True, timeout=harness.STOP_TIMEOUT_S)
                self.assertNotEqual(done.returncode, 0)
                self.assertIn(said, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
