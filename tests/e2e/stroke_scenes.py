"""A script strokes every scene of deploy/scenes through Client.hand(), and recordings of it replay to identical forces.

What the servo felt comes from the replay, every tick of it. HAPTICS_SCENES: names of scenes, else all.
HAPTICS_STROKE_S: length of the recording in which one scene follows another.
"""
import contextlib
import itertools
import math
import os
import re
import subprocess
import sys
import unittest

import harness
import haptic_recording
from haptic_client import Client

SCENES = harness.PROJECT / "deploy" / "scenes"
NAMES = os.environ.get("HAPTICS_SCENES", "").split() or sorted(file.stem for file in SCENES.glob("*.scene"))
STROKE_S = float(os.environ.get("HAPTICS_STROKE_S", "60"))
SCRIPT = harness.PROJECT / "graphics_client/script/python/examples/stroke_scene.py"
ASSETS = ["--assets", "/usr/share/inventor/data", "--assets", SCENES]
MAX_FORCE_N = 3.3      # of the device, an Omni
COUNT_M = 55e-6        # of its encoder
# Of the change of the force in a tick.
MAX_RIGID_N = 0.05     # on what is rigid and smooth: beyond what the hand's way and the turn of the surface explain
MAX_YIELDING_N = 0.6   # on what moves or yields: beyond what the turn explains
MAX_SLIP_N = 2         # on what sticks or is rough: the friction that a slip lets go, the slope of a texture
MIN_CONTACT = 0.8      # of the ticks of the strokes on an object
FORCE_N, MAX_ERROR = 1, 0.6  # the force that is set; how far from it the mean may be, friction included
UNREACHABLE = {"nodule"}  # the skin lies over it


def xyz(vector):
    return vector.x, vector.y, vector.z


def is_rough(state):
    return state.HasField("friction") or state.HasField("texture")


def yields(state):
    return state.HasField("motion") or state.deformation.HasField("softness")


def step_N(a, b):
    return math.dist(xyz(a.force.written), xyz(b.force.written))


def turned_N(a, b):
    """What the turn of the surface's normal makes of a force of that size: most where the hand slips over a ridge."""
    force_N = max(math.hypot(*xyz(sample.force.written)) for sample in (a, b))
    return force_N * math.dist(xyz(a.surface_normal), xyz(b.surface_normal))


def moved_m(a, b):
    """Of where the force is computed: the predicted hand."""
    return math.dist(*(xyz(sample.predicted_hip if sample.HasField("predicted_hip") else sample.hip)
                       for sample in (a, b)))


class StrokeScenes(harness.EndToEnd):
    def start(self, scene):
        self.file = self.folder / "strokes.haptics"
        self.server = self.start_server(scene=scene, options=["--record", self.file, *ASSETS])

    def stroke(self, *options):
        """The script's lines: {object: what it says}."""
        done = subprocess.run([sys.executable, "-B", SCRIPT, "--connect", self.server.address, "--force", str(FORCE_N),
                               *options], capture_output=True, text=True, timeout=1200)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        print(done.stdout, end="", flush=True)
        return dict(line.split(": ", 1) for line in done.stdout.splitlines())

    def stop_and_replay(self):
        """Every tick's sample, once each force has come out as recorded."""
        status = self.server.status()
        self.assertEqual((status["fault"], status["faults"]), ("FAULT_NONE", 0), self.server.text())
        summary = self.stop_and_check(self.server)
        samples = self.folder / "samples"
        done = subprocess.run([harness.BIN / "haptic_eval", "replay", self.file, "--out", self.folder / "out",
                               "--telemetry", samples], capture_output=True, text=True)
        print(done.stdout, end="", flush=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        record = harness.json.loads((self.folder / "out" / "replay.json").read_text())[0]
        self.assertEqual((record["differing_ticks"], record["ticks"]), (0, summary["ticks"]))
        self.assertLessEqual(summary["max_force_N"], MAX_FORCE_N + 1e-9)
        return haptic_recording.telemetry(samples)

    def test_a_script_strokes_every_object_and_the_force_does_not_jump(self):
        for name in NAMES:
            with self.subTest(scene=name), contextlib.ExitStack() as stack:
                print(f"\n{name}", flush=True)
                self.start((SCENES / f"{name}.scene").read_text())
                stack.callback(self.server.kill)
                with Client(self.server.address, "reader") as client:
                    objects = {state.id: state for state in client.objects().values()}
                lines = self.stroke()
                self.assertEqual(set(lines), {state.name for state in objects.values()})
                for found, said in lines.items():
                    if found in UNREACHABLE:
                        continue
                    match = re.match(r"contact ([\d.]+) %  force ([\d.]+) N", said)
                    self.assertTrue(match, f"{found}: {said}")
                    self.assertGreater(float(match[1]), 100 * MIN_CONTACT, f"{found}: {said}")
                    self.assertLess(abs(float(match[2]) - FORCE_N), MAX_ERROR * FORCE_N, f"{found}: {said}")
                self.check_steps(self.stop_and_replay(), objects)

    def check_steps(self, samples, objects):
        """Between ticks that follow each other on one object."""
        bounds = {"rigid": MAX_RIGID_N, "yielding": MAX_YIELDING_N, "rough": MAX_SLIP_N}
        largest = dict.fromkeys(bounds, (-math.inf, ""))
        for a, b in itertools.pairwise(samples):
            state = objects.get(a.object)
            if not state or b.tick != a.tick + 1 or a.object != b.object:
                continue
            kind, step = "rough", step_N(a, b)
            if not is_rough(state):
                kind, step = "yielding", step - turned_N(a, b)
                if not yields(state):
                    kind, step = "rigid", step - state.stiffness_N_per_m * (moved_m(a, b) + COUNT_M)
            largest[kind] = max(largest[kind], (step, f"{state.name}, tick {b.tick}"))
        print(*(f"{kind} {step:.3f} N ({where})" for kind, (step, where) in largest.items() if where), flush=True)
        for kind, bound in bounds.items():
            self.assertLess(largest[kind][0], bound, f"{kind}: {largest[kind]}")

    def test_a_recording_of_one_scene_after_another_replays_to_identical_forces(self):
        self.start((SCENES / f"{NAMES[0]}.scene").read_text())
        with Client(self.server.address, "producer") as client:
            for name in NAMES:
                if name != NAMES[0]:
                    gone = "".join(f"operations {{ remove {{ object {{ id: {state.id} }} }} }}\n"
                                   for state in client.objects().values())
                    client.apply(gone + (SCENES / f"{name}.scene").read_text())
                self.assertTrue(self.stroke("--seconds", str(STROKE_S / len(NAMES))), name)
        strokes = sum(1 for sample in self.stop_and_replay() if sample.object)
        self.assertGreater(strokes, 0.2 * 1000 * STROKE_S)


if __name__ == "__main__":
    unittest.main()
