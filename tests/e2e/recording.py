"""Recordings of a running server replay to the same forces, bit for bit: whole ones, ones that a kill cut off, and those of
the last seconds that are written on request. Damaged ones are refused.

HAPTICS_RECORD_S: length of the recording with edits. HAPTICS_KILLS: how often a server is killed. HAPTICS_OTHER_EVAL: the haptic_eval of another build, which must
come to the same forces.
"""
import os
import random
import statistics
import subprocess
import time
import unittest

import harness
from haptic_client import Client

SECONDS = float(os.environ.get("HAPTICS_RECORD_S", "6"))
EVALS = [harness.BIN / "haptic_eval", *filter(None, [os.environ.get("HAPTICS_OTHER_EVAL")])]
KILLS = int(os.environ.get("HAPTICS_KILLS", "4"))
LOST_MS = 100  # at most, when the server is killed

SCENE = """
operations { add { name: "torus" mesh { torus { major_radius_m: 0.042 minor_radius_m: 0.018 } }
                   pose { position { x: -0.06 z: 0.018 } }
                   material { shading { crease_rad: 0.6 }
                              friction { mu_static: 0.6 mu_dynamic: 0.4 variation: 0.3 field { grain { grain_m: 0.001 } } } } } }
operations { add { name: "box" mesh { box { size_m { x: 0.07 y: 0.07 z: 0.05 } segments: 4 } }
                   pose { position { x: 0.06 z: 0.025 } }
                   material { texture { amplitude_m: 0.0004 field { mapped { spot_noise { cells: 6 }
                                        mapping { shape: MAPPING_SHAPE_CUBE tile_m: 0.02 } } } } } } }
operations { add { name: "block" mesh { box { size_m { x: 0.03 y: 0.03 z: 0.03 } } } pose { position { y: 0.05 z: 0.015 } }
                   motion { mass_kg: 0.1 planes { normal { z: 1 } friction: 0.4 } } } }
operations { add { name: "cushion" mesh { sphere { radius_m: 0.03 segments: 24 } } pose { position { y: -0.07 z: 0.03 } }
                   deformation { softness { stiffness_N_per_m: 300 radius_m: 0.015 return_s: 0.5 } } } }
"""


def cushion_of(step):
    """Its lattice, one corner farther out each time."""
    corners = [(0.03 * x, 0.03 * y, 0.03 * z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    corners[-1] = tuple(c + 0.002 * (step % 4) for c in corners[-1])
    points = " ".join(f"control_m: {value}" for corner in corners for value in corner)
    return f"lattice {{ points_x: 2 points_y: 2 points_z: 2 {points} }}"


class Recording(harness.EndToEnd):
    def start(self, *options):
        self.file = self.folder / "ticks.haptics"
        self.server = self.start_server(scene=SCENE, options=["--record", self.file, "--recordings", self.folder / "last",
                                                              *options])

    def replay(self, file, code=0):
        """What the replay of each build said, as records."""
        records = []
        for program in EVALS:
            done = subprocess.run([program, "replay", file, "--out", self.folder / "out"], capture_output=True, text=True)
            print(done.stdout, done.stderr, sep="")
            self.assertEqual(done.returncode, code, done.stdout + done.stderr)
            records.append(harness.json.loads((self.folder / "out" / "replay.json").read_text())[0])
        return records

    def edit(self, step):
        """Something else each time: stiffness, place, mesh, coming and going."""
        z = 0.025 + 0.001 * (step % 3)
        edits = [
            f'set_material {{ object {{ name: "torus" }} material {{ stiffness_N_per_m: {600 + 200 * (step % 4)} }} }}',
            f'set_pose {{ object {{ name: "box" }} pose {{ position {{ x: 0.06 z: {z} }} }} }}',
            'remesh { object { name: "torus" } mesh { torus { major_radius_m: 0.042 minor_radius_m: 0.018 '
            f'major_segments: {96 + 16 * (step % 3)} }} }} }}',
            f'set_deformation {{ object {{ name: "cushion" }} deformation {{ {cushion_of(step)} }} }}',
            'add { name: "ball" mesh { sphere { radius_m: 0.02 segments: 8 } } pose { position { z: 0.02 } } }',
            'set_material { object { name: "ball" } material { texture { amplitude_m: 0.0003 field { fourier { terms { '
            'direction { x: 1 } wavelength_m: 0.003 } } } } } }',
            'remove { object { name: "ball" } }',
        ]
        self.server.ctl("apply", "-", text=f"operations {{ {edits[step % len(edits)]} }}").json()

    def test_every_force_of_a_recording_with_edits_is_made_again(self):
        self.start("--check-replay")
        step, end = 0, time.monotonic() + SECONDS
        while time.monotonic() < end or step < 12:
            self.edit(step)
            step += 1
            time.sleep(min(0.5, SECONDS / 30))
        summary = self.stop_and_check(self.server)
        check = summary["replay_check"]
        self.assertEqual((check["differences"], check["ticks"] + check["skipped_ticks"]), (0, summary["ticks"]), check)
        self.assertGreater(check["ticks"], 0)
        for record in self.replay(self.file):
            self.assertEqual(record["differing_ticks"], 0)
            self.assertTrue(record["same_step"])
            self.assertEqual(record["ticks"], summary["ticks"])
            self.assertEqual(record["contact_ticks"], summary["contact_ticks"])
            self.assertGreater(record["scenes"], step)
            self.assertFalse(record["cut_off"])

    def test_a_killed_server_loses_no_more_than_a_tenth_of_a_second(self):
        import haptic_recording
        lost_ms, chance = [], random.Random(KILLS)
        for _ in range(KILLS):
            self.start()
            time.sleep(0.6 + 0.3 * chance.random())
            killed_ns = time.monotonic_ns()  # the clock of the ticks
            self.server.kill()
            last = list(haptic_recording.ticks(self.file))[-1]
            lost_ms.append((killed_ns - last.time_ns) / 1e6)
            for record in self.replay(self.file):
                self.assertEqual(record["differing_ticks"], 0)
                self.assertGreater(record["ticks"], 300)
        print(f"{KILLS} kills lost {statistics.median(lost_ms):.1f} ms, at most {max(lost_ms):.1f}")
        self.assertLess(max(lost_ms), LOST_MS)

    def test_the_last_seconds_are_recorded_when_asked_for_with_the_state_that_they_begin_with(self):
        import haptic_recording
        self.start()
        time.sleep(12)
        self.edit(0)
        reply = self.server.ctl("dump").json()
        self.assertTrue(reply["file"].startswith(str(self.folder / "last")), reply)
        self.stop_and_check(self.server)
        self.assertGreater(next(iter(haptic_recording.ticks(reply["file"]))).tick, 500, "not from the server's start on")
        for record in self.replay(reply["file"]):
            self.assertEqual(record["differing_ticks"], 0)
            self.assertGreater(record["ticks"], 9000)

    def test_a_damaged_recording_is_refused_at_its_byte(self):
        self.start()
        time.sleep(1)
        self.stop_and_check(self.server)
        data = bytearray(self.file.read_bytes())
        data[len(data) // 2] ^= 1
        self.file.write_bytes(data)
        for record in self.replay(self.file, code=1):
            self.assertIn("damaged", record["refusal"])
            self.assertEqual(record["differing_ticks"], 0)

    def played(self, file, *options):
        """A server that plays the recording, from its start on, and the client's address."""
        server = harness.Process([harness.BIN / "haptic_server", "--device", f"replay:{file}", "--listen", "127.0.0.1:0",
                                  "--summary", self.folder / "played.json", *options])
        self.addCleanup(server.kill)
        harness.wait_until(lambda: server.find(r"^listening on ") or not server.alive(), harness.START_TIMEOUT_S, server.text)
        return server

    def test_a_server_plays_it_again_with_its_scene_its_edits_and_every_force(self):
        self.start()
        for step in range(7):
            self.edit(step)
            time.sleep(0.5)
        dump = self.server.ctl("dump").json()["file"]
        time.sleep(1)
        recorded = self.stop_and_check(self.server)
        last = (recorded["scene_revision"], recorded["scene_hash"])
        for file in (self.file, dump):
            server = self.played(file)
            address = server.find(r"^listening on (\S+)").group(1)
            with Client(address, "watcher", telemetry_hz=200) as client:
                if file == self.file:
                    refusal = harness.ctl(address, "apply", "-", text='operations { remove { object { name: "box" } } }')
                    self.assertIn("recording", refusal.errors + refusal.output)
                    self.assertIn("recording", harness.ctl(address, "dump").errors)
                self.assertTrue(any(sample.object for sample in client.samples(2)), "what is felt is seen")
                harness.wait_until(lambda: client.revision_and_root() == last, 30, client.revision_and_root)
            self.assertEqual(server.wait(), 0, server.text())
            self.assertIn("every force was the recorded one, bit for bit", server.text())
            summary = harness.json.loads((self.folder / "played.json").read_text())
            self.assertEqual(summary["scene_hash"], recorded["scene_hash"])
            if file == self.file:
                for key in ("ticks", "contact_ticks", "bodies", "max_force_N"):
                    self.assertEqual(summary[key], recorded[key], key)

    def test_what_cannot_be_played_is_refused_with_the_reason(self):
        self.start()
        time.sleep(0.5)
        self.stop_and_check(self.server)
        scene = self.folder / "test.scene"
        for options, reason in (([f"replay:{self.folder}/none"], "none: No such file"),
                                (["replay"], "--device: replay:FILE names the recording"),
                                ([f"replay:{scene}"], "it is no recording of this version"),
                                ([f"replay:{self.file}", "--rate", "4000"], "was recorded at 1000 Hz"),
                                ([f"replay:{self.file}", "--state", self.folder / "state"], "--state: "),
                                ([f"replay:{self.file}", "--record", self.folder / "again"], "--record: ")):
            done = subprocess.run([harness.BIN / "haptic_server", "--device", *options], capture_output=True, text=True)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn(reason, done.stderr)

    def test_a_recording_that_cannot_be_written_is_said_at_the_start(self):
        with self.assertRaises(harness.NotStarted) as refused:
            self.start_server(options=["--record", self.folder / "none" / "ticks"])
        self.assertIn("--record", str(refused.exception))


if __name__ == "__main__":
    unittest.main()
