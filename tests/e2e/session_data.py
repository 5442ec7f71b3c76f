"""Sessions as data: every tick of a running server in a stream, and what export makes of a recording, read by h5py, a table
reader and, where there is node with @mcap/core, in JavaScript: the same forces, bit for bit.

HAPTICS_SESSION_S: length of the session (5).
"""
import csv
import json
import os
import shutil
import signal
import struct
import subprocess
import time
import unittest

import h5py
import numpy

import harness
from haptic_client import Client

SECONDS = float(os.environ.get("HAPTICS_SESSION_S", "5"))
SCENES = harness.PROJECT / "deploy/scenes"
EXPORT_S = 10 * max(1, SECONDS / 600)  # at most

SCENE = """
operations { add { name: "torus" mesh { torus { major_radius_m: 0.042 minor_radius_m: 0.018 } }
                   pose { position { x: -0.06 z: 0.018 } } material { friction { mu_static: 0.6 mu_dynamic: 0.4 } } } }
operations { add { name: "block" mesh { box { size_m { x: 0.07 y: 0.07 z: 0.05 } } } pose { position { x: 0.06 z: 0.025 } }
                   motion { mass_kg: 0.1 planes { normal { z: 1 } friction: 0.4 } } } }
operations { add { name: "cushion" mesh { sphere { radius_m: 0.03 segments: 24 } } pose { position { y: -0.07 z: 0.03 } }
                   deformation { softness { stiffness_N_per_m: 300 radius_m: 0.015 return_s: 0.5 } } } }
"""


def exported(*arguments, code=0):
    """hapticctl export, without a server."""
    done = subprocess.run([harness.BIN / "hapticctl", "export", *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


class Session(harness.EndToEnd):
    @classmethod
    def setUpClass(cls):
        """One session for all: recorded, watched and exported while it runs, with two edits."""
        super().setUpClass()
        cls.made = None

    def setUp(self):
        super().setUp()
        if Session.made is None:
            Session.made = self.make()
        self.recording, self.recorded_tool, self.live_file, self.streamed, self.gaps = Session.made

    def make(self):
        folder = harness.Path(harness.tempfile.mkdtemp(prefix="haptics-session-"))
        self.addClassCleanup(shutil.rmtree, folder)
        recording, live = folder / "session.recording", folder / "live.h5"
        tool_folder = folder / "tool"  # of the demo scene whose ticks take longest
        tool_folder.mkdir()
        recorded_tool = tool_folder / "tool.recording"
        tool_server = harness.Server(tool_folder, scene=(SCENES / "bar.scene").read_text(),
                                     options=["--assets", SCENES, "--record", recorded_tool])
        self.addCleanup(tool_server.kill)
        server = self.start_server(scene=SCENE, options=["--record", recording])
        exporter = subprocess.Popen([harness.BIN / "hapticctl", "--connect", server.address, "export", "--live", "--seconds",
                                     str(SECONDS), "--out", str(live)], stdout=subprocess.PIPE, text=True)
        streamed = []
        with Client(server.address, "stream", every_tick=True) as client:
            streamed += client.samples(SECONDS / 3)
            for part in range(2):
                client.apply(f'operations {{ set_material {{ object {{ name: "torus" }} material {{ '
                             f'stiffness_N_per_m: {500 + 100 * part} }} }} }}')
                streamed += client.samples(SECONDS / 3)
            gaps = list(client.gaps)
        self.assertEqual(exporter.wait(30), 0)
        print(exporter.stdout.read())
        exporter.stdout.close()
        for ended in (server, tool_server):
            self.stop_and_check(ended)
        return recording, recorded_tool, live, streamed, gaps

    def h5(self, file):
        session = h5py.File(file)
        self.addCleanup(session.close)
        return session

    def whole(self):
        out = self.folder / "session.h5"
        exported(self.recording, "--out", out)
        return self.h5(out)

    def test_every_tick_is_in_the_stream_or_named_as_missing(self):
        ticks = [sample.tick for sample in self.streamed]
        missing = sum(later - tick - 1 for tick, later in zip(ticks, ticks[1:]))
        self.assertEqual(missing, sum(gap.missed + gap.lost for gap in self.gaps))
        self.assertEqual(sum(gap.lost for gap in self.gaps), 0)
        self.assertGreater(len(ticks), 0.8 * 1000 * SECONDS)

    def test_the_stream_has_the_recorded_forces(self):
        session = self.whole()
        at = {tick: i for i, tick in enumerate(session["ticks/tick"][:].tolist())}
        force, hip = session["ticks/force/written"][:], session["ticks/hip"][:]
        for sample in self.streamed:
            i = at[sample.tick]
            written = sample.force.written
            self.assertEqual((written.x, written.y, written.z), tuple(force[i]), sample.tick)
            self.assertEqual((sample.hip.x, sample.hip.y, sample.hip.z), tuple(hip[i]), sample.tick)

    def test_a_live_export_is_that_of_the_recording(self):
        live, whole = self.h5(self.live_file), self.whole()
        self.assertEqual(live.attrs["ticks_lost"], 0)
        common = numpy.intersect1d(live["ticks/tick"][:], whole["ticks/tick"][:])
        self.assertEqual(len(common), len(live["ticks/tick"]))
        rows = numpy.searchsorted(whole["ticks/tick"][:], common)

        def compare(name, data):
            if isinstance(data, h5py.Dataset) and name not in ("allowance_spent", "missed_ticks"):
                self.assertEqual(data[:].tobytes(), whole["ticks/" + name][:][rows].tobytes(), name)
        live["ticks"].visititems(compare)
        self.assertEqual(list(live["edits/revision"][:]), [1, 2, 3])

    def test_units_scenes_and_meshes(self):
        session = self.whole()
        force = session["ticks/force/written"]
        self.assertEqual((force.attrs["units"], force.attrs["frame"], force.shape[1]), ("N", "world", 3))
        self.assertEqual(session.attrs["note"], "")
        self.assertEqual(list(session["edits/revision"][:]), [1, 2, 3])
        last = session["scenes/00000003"]
        torus = next(o for o in last.values() if o.attrs["name"] == "torus")
        self.assertEqual(torus.attrs["stiffness_N_per_m"], 600)
        self.assertIn('name: "cushion"', last.attrs["text"])
        mesh = session[torus.attrs["mesh"]]
        self.assertLess(mesh["triangles"][:].max(), len(mesh["vertices"]))
        self.assertGreater(len(numpy.unique(session["ticks/object"][:])), 1, "something was touched")

    def test_h5dump_reads_it(self):
        out = self.folder / "session.h5"
        exported(self.recording, "--out", out)
        dumped = subprocess.run(["h5dump", "-d", "/ticks/tick", str(out)], capture_output=True, text=True, check=True)
        self.assertIn("H5T_STD_U64LE", dumped.stdout)

    def test_csv_has_the_same_numbers(self):
        out = self.folder / "session.csv"
        exported(self.recording, "--out", out)
        whole = self.whole()
        with open(out) as stream:
            rows = list(csv.DictReader(stream))
        self.assertEqual(len(rows), len(whole["ticks/tick"]))
        for axis, column in enumerate("xyz"):
            read = numpy.array([float(row[f"force.written.{column} [N]"]) for row in rows])
            self.assertEqual(read.tobytes(), numpy.ascontiguousarray(whole["ticks/force/written"][:, axis]).tobytes())

    def test_mcap_has_the_same_forces(self):
        if not shutil.which("node") or subprocess.run(["node", "-e", "require('@mcap/core')"], capture_output=True).returncode:
            self.skipTest("node has no @mcap/core")
        out = self.folder / "session.mcap"
        exported(self.recording, "--out", out)
        reader = harness.Path(__file__).with_name("mcap_reader.js")
        read = json.loads(subprocess.run(["node", reader, out], capture_output=True, text=True, check=True).stdout)
        whole = self.whole()
        forces = [struct.pack("<3d", *force).hex() for force in whole["ticks/force/written"][:]]
        self.assertEqual(read["ticks"], [list(pair) for pair in zip(whole["ticks/tick"][:].tolist(), forces)])
        self.assertEqual(read["topics"]["/scene"], 3)
        self.assertGreater(read["topics"]["/hand"], 10)

    def test_a_plot_is_drawn(self):
        for name, head in (("plot.png", b"\x89PNG"), ("plot.svg", b"<?xml")):
            session = self.folder / "plotted.h5"
            exported(self.recording, "--out", session)
            done = subprocess.run([harness.BIN / "hapticctl", "plot", session, "--out", self.folder / name],
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue((self.folder / name).read_bytes().startswith(head))

    def test_speed(self):
        for recording in (self.recording, self.recorded_tool):
            for ending in ("h5", "csv", "mcap"):
                began = time.monotonic()
                said = exported(recording, "--out", self.folder / ("speed." + ending))
                took_s = time.monotonic() - began
                print(f"{recording.stem} in {took_s:.2f} s: {said.splitlines()[-1]}")
                self.assertLess(took_s, EXPORT_S)
                self.assertNotIn("note:", said)

    def test_a_damaged_recording_is_exported_up_to_the_damage(self):
        bytes_ = bytearray(self.recording.read_bytes())
        damaged = self.folder / "damaged.recording"
        bytes_[len(bytes_) * 2 // 3] ^= 1
        damaged.write_bytes(bytes_)
        said = exported(damaged, "--out", self.folder / "damaged.h5")
        self.assertRegex(said, "note: the recording is read up to here: .*damaged")
        session = self.h5(self.folder / "damaged.h5")
        self.assertIn("read up to here", session.attrs["note"])
        self.assertGreater(len(session["ticks/tick"]), 100)

    def test_what_cannot_be_exported_is_refused_and_leaves_nothing(self):
        text = self.folder / "no.recording"
        text.write_text("not a recording")
        self.assertIn("no recording", exported(text, "--out", self.folder / "a.h5", code=1))
        self.assertIn("a.xlsx: ends with none of .h5, .csv, .mcap", exported(self.recording, "--out", "a.xlsx", code=2))
        self.assertIn("a.csv: ends otherwise than", exported(self.recording, "--out", "a.csv", "--format", "hdf5", code=2))
        self.assertIn("a recording, or --live", exported("--out", "a.h5", code=2))
        nowhere = self.folder / "no-folder"
        for name in ("a.h5", "a.CSV", "a.mcap"):
            self.assertIn("cannot be written", exported(self.recording, "--out", nowhere / name, code=1))
            self.assertIn("is a folder", exported(self.recording, "--out", self.folder, "--format",
                                                  name[2:].lower().replace("h5", "hdf5"), code=1))
        self.assertEqual([p.name for p in self.folder.iterdir() if p.name.startswith("a.")], [])

    def test_a_full_disk_is_told_of(self):
        for ending in ("csv", "mcap"):
            full = self.folder / f"full.{ending}"
            full.with_name(full.name + ".part").symlink_to("/dev/full")
            self.assertIn("No space left on device", exported(self.recording, "--out", full, code=1))
            self.assertFalse(full.exists())

    def test_ctrl_c_leaves_a_whole_file_of_a_live_session(self):
        server = self.start_server(scene=SCENE)
        out = self.folder / "short.h5"
        exporter = subprocess.Popen([harness.BIN / "hapticctl", "--connect", server.address, "export", "--live", "--seconds",
                                     "60", "--out", out], stdout=subprocess.PIPE, text=True)
        time.sleep(2)
        exporter.send_signal(signal.SIGINT)
        said = exporter.communicate(timeout=harness.STOP_TIMEOUT_S)[0]
        self.assertRegex(said, "short.h5: [0-9]+ ticks")
        self.assertGreater(len(self.h5(out)["ticks/tick"]), 100)

    def test_a_server_that_goes_away_is_told_of_and_what_came_is_kept(self):
        server = self.start_server(scene=SCENE)
        out = self.folder / "cut.h5"
        exporter = subprocess.Popen([harness.BIN / "hapticctl", "--connect", server.address, "--timeout", "1", "export", "--live",
                                     "--seconds", "60", "--out", out], stdout=subprocess.PIPE, text=True)
        harness.wait_until(lambda: any(part.stat().st_size > 0 for part in self.folder.glob("cut.h5*")), 60, "ticks come")
        time.sleep(2)
        server.kill()
        said = exporter.communicate(timeout=30)[0]
        self.assertEqual(exporter.returncode, 3, said)
        self.assertRegex(said, "note: .*no connection.*it ends after tick [1-9]")
        self.assertGreater(len(self.h5(out)["ticks/tick"]), 100)

    def test_without_a_server(self):
        done = subprocess.run([harness.BIN / "hapticctl", "--connect", "127.0.0.1:1", "--timeout", "0.5", "export", "--live",
                               "--out", self.folder / "none.h5"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertFalse((self.folder / "none.h5").exists())


if __name__ == "__main__":
    unittest.main()
