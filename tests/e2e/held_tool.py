"""A tool in the hand: the server feels with all of it, clients see how it is held, and recordings of it replay bit for bit."""
import math
import re
import subprocess
import sys
import unittest

import harness
from haptic_client import Client

SCENES = harness.PROJECT / "deploy/scenes"
SCENE = (SCENES / "bar.scene").read_text()
INSERT_PEG = harness.PROJECT / "graphics_client/script/python/examples/insert_peg.py"

FLOOR = """
operations { add { name: "floor" mesh { box { size_m { x: 0.4 y: 0.4 z: 0.04 } segments: 4 } } pose { position { z: -0.02 } } } }
operations { add { name: "bar" mesh { box { size_m { x: 0.06 y: 0.04 z: 0.01 } } }
                   motion { tool { spacing_m: 0.004 torsion_Nm_per_rad: 1 } } } }
"""


class HeldTool(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.file = self.folder / "ticks.haptics"
        self.server = self.start_server(scene=SCENE, options=["--record", self.file])
        self.bar = next(int(item["id"]) for item in self.server.ctl("get").json()["object"] if item["name"] == "bar")

    def heard(self, seconds="0.3"):
        lines = self.server.ctl("watch", "--rate", "100", "--seconds", seconds).output.splitlines()
        return [harness.json.loads(line) for line in lines]

    def wait_until_held(self):
        def held():
            return next((s for s in self.heard() if len(s.get("tool", {}).get("point", [])) > 1), None)
        return harness.wait_until(held, 60, "surfaces hold the bar")

    def apply(self, text):
        return self.server.ctl("apply", "-", text=text).json()

    def take_next_tool(self, name):
        with Client(self.server.address, "changer", telemetry_hz=100) as client, client.hand() as hand:
            client.wait_live()
            client.move_workspace(next_tool_buttons=0b1)
            hand.hold_buttons(0)
            felt = hand.hold_buttons(0b1, 0.5)[-1]
            self.assertEqual(felt.tool.object, client.objects()[name].id)

    def test_clients_see_how_it_is_held_and_its_recording_replays(self):
        viewer = self.start_viewer(self.server.address, self.start_display())
        sample = self.wait_until_held()
        self.assertEqual(int(sample["tool"]["object"]), self.bar)
        self.assertIn(self.bar, [int(body["object"]) for body in sample["body"]])
        self.assertNotEqual(int(sample["object"]), self.bar, "it does not touch itself")
        for edit in ('set_material { object { name: "bar" } material { stiffness_N_per_m: 400 } }',
                     'set_pose { object { name: "bar" } pose { rotation { w: 0.9238795 z: 0.3826834 } } }',
                     'set_motion { object { name: "bar" } motion { tool { spacing_m: 0.003 } } }',
                     'set_motion { object { name: "bar" } motion {} }'):
            self.apply("operations { %s }" % edit)
            harness.time.sleep(0.5)
        self.assertTrue(all("tool" not in sample for sample in self.heard()[-3:]), "the point feels again")
        self.apply('operations { set_motion { object { name: "bar" } motion { tool { spacing_m: 0.002 } } } }')
        self.wait_until_held()
        self.apply('operations { set_motion { object { name: "ring" } motion { tool { spacing_m: 0.004 } } } }')
        self.take_next_tool("ring")
        self.take_next_tool("bar")
        status = self.server.status()
        viewer.wait_for(status["revision"], status["root"])
        self.assertEqual(viewer.stop(), 0, viewer.text())
        self.stop_and_check(self.server)
        done = subprocess.run([harness.BIN / "haptic_eval", "replay", self.file, "--out", self.folder / "out"],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_device_that_turns_turns_it_and_feels_its_torque(self):
        self.stop_and_check(self.server)
        file = self.folder / "turned.haptics"
        server = self.start_server(scene=FLOOR, options=["--record", file, "--device-preset", "sigma.7"])
        with Client(server.address, "turner", telemetry_hz=200) as client, client.hand() as hand:
            client.wait_live()
            hand.move_to((0, 0, 0.03))
            free = hand.turn((math.cos(0.2), 0, 0, math.sin(0.2)), 1.5)[-1].tool
            self.assertAlmostEqual(free.device_rotation.z, math.sin(0.2), delta=0.01)
            hand.turn((1, 0, 0, 0), 1.5)
            hand.press((0, 0, 0.005), (0, 0, 1), 2, 1.0)
            tilt = 0.02
            tilted = hand.turn((math.cos(tilt / 2), 0, math.sin(tilt / 2), 0), 1.0)
            torque = tilted[-1].tool.written_Nm
            print(f"\ntorque {torque.y:.4f} Nm of {-tilt * 1.0} Nm/rad x rad", end="", flush=True)
            self.assertLess(torque.y, -0.002, "the floor turns the bar back, and that the hand")
            self.assertGreaterEqual(torque.y, -tilt)
            largest = max(math.hypot(s.tool.written_Nm.x, s.tool.written_Nm.y, s.tool.written_Nm.z) for s in tilted)
            self.assertLessEqual(largest, 0.2 + 1e-9)
        self.stop_and_check(server)
        done = subprocess.run([harness.BIN / "haptic_eval", "replay", file, "--out", self.folder / "out"],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_forceps_close_on_a_ball_and_open_the_gripper(self):
        self.stop_and_check(self.server)
        file = self.folder / "gripped.haptics"
        server = self.start_server(scene=(SCENES / "forceps.scene").read_text(),
                                   options=["--assets", SCENES, "--record", file, "--device-preset", "sigma.7"])
        server.ctl("verify")
        with Client(server.address, "surgeon", telemetry_hz=200) as client, client.hand() as hand:
            client.wait_live()
            hand.move_to((-0.08, 0, 0.03))
            opened = hand.open_gripper(0.5, 1)[-1]
            self.assertAlmostEqual(opened.tool.grip.opening_rad, 0.5, delta=0.01)
            self.assertAlmostEqual(opened.tool.grip.moment_Nm, 0, delta=1e-3)
            hand.move_to((-0.04, 0, 0.03))
            closed = hand.open_gripper(0.1, 1)
            grip, gripper = closed[-1].tool.grip, closed[-1].device_gripper_rad
            print(f"\njaws {grip.opening_rad:.3f} rad, gripper {gripper:.3f}, {grip.written_Nm:.4f} Nm", end="", flush=True)
            self.assertGreater(grip.opening_rad, 0.25, "the ball is 12 mm wide")
            self.assertGreater(gripper, 0.1, "the fingers give way")
            self.assertAlmostEqual(grip.written_Nm, 0.5 * (grip.opening_rad - gripper), delta=5e-3)
            self.assertLessEqual(max(abs(s.tool.grip.written_Nm) for s in closed), 0.4)
            self.assertGreater(len(closed[-1].tool.point), 1)
            hand.open_gripper(0.5, 1)
        self.stop_and_check(server)
        done = subprocess.run([harness.BIN / "haptic_eval", "replay", file, "--out", self.folder / "out"],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_script_puts_a_peg_into_its_hole_turns_it_and_pulls_it_out(self):
        self.stop_and_check(self.server)
        server = self.start_server(scene=(SCENES / "peg.scene").read_text(),
                                   options=["--assets", SCENES, "--device-preset", "sigma.7"])
        done = subprocess.run([sys.executable, INSERT_PEG, "--connect", server.address], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        print("\n" + done.stdout, end="", flush=True)
        said = re.findall(r"^(.*): (-?[\d.]+) mm deep  force ([\d.]+) N  torque ([\d.]+) mNm$", done.stdout, re.M)
        parts = {what: tuple(map(float, numbers)) for what, *numbers in said}
        depth, force, torque = range(3)
        self.assertAlmostEqual(parts["beside the hole"][depth], 0, delta=1, msg="it lies on the block")
        self.assertGreater(parts["beside the hole"][force], 1)
        self.assertGreater(parts["in"][depth], 15)
        for turned in ("turned by 12 degrees", "turned by -12 degrees"):
            self.assertGreater(parts[turned][depth], 15, "the hole holds it")
            self.assertGreater(parts[turned][torque], 50, "flats turn it back: 1 Nm/rad")
        self.assertLessEqual(max(numbers[torque] for numbers in parts.values()), 200.1, "what the device bears")
        self.assertLess(parts["out"][depth], -10)
        self.stop_and_check(server)
        unknown = subprocess.run([sys.executable, INSERT_PEG, "--help"], capture_output=True, text=True)
        self.assertIn("the largest force and torque", unknown.stdout)


if __name__ == "__main__":
    unittest.main()
