"""deploy/run, as a newcomer types it, in its headless form."""
import contextlib
import json
import os
import re
import signal
import socket
import struct
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

USUAL = "127.0.0.1:7654"
RUN = Path(__file__).resolve().parents[2] / "deploy" / "run"


def picture_size(png):
    head = png.read_bytes()[:24]
    return struct.unpack(">II", head[16:24]) if head[:8] == b"\x89PNG\r\n\x1a\n" else None


class Run(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out = Path(folder.name) / "out"

    def start(self, *options):
        return subprocess.Popen([RUN, "--headless", "--out", self.out, *options], stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True, start_new_session=True)

    def summary(self):
        return json.loads((self.out / "summary.json").read_text())

    def test_twenty_seconds_of_the_demo_are_felt_and_seen(self):
        run = self.start("--seconds", "20")
        said, _ = run.communicate(timeout=900)
        self.assertEqual(run.returncode, 0, said)
        # Another server may run on this machine.
        self.assertTrue(f"listens at {USUAL};" in said or f"{USUAL} is taken by another program" in said, said)
        summary = self.summary()
        self.assertGreaterEqual(summary["contact_ticks"], 0.3 * summary["ticks"])
        self.assertGreaterEqual(summary["max_force_N"], 0.5)
        self.assertEqual(summary["allocations_in_servo"], 0)
        self.assertTrue(summary["hashes_equal"])
        self.assertEqual(summary["scene_hash"], summary["client_scene_hash"])
        # More than 500 on two idle cores. How many a busy machine draws is its own matter, that they go on is the viewer's.
        self.assertGreaterEqual(summary["viewer_frames"], 10)
        self.assertEqual(picture_size(self.out / "view.png"), (1280, 1024))

    def test_where_the_usual_port_is_taken_it_says_so_and_what_to_connect_to(self):
        with contextlib.suppress(OSError):  # it is taken already
            self.addCleanup(socket.create_server(("127.0.0.1", 7654)).close)
        run = self.start("--seconds", "3")
        said, _ = run.communicate(timeout=900)
        self.assertEqual(run.returncode, 0, said)
        self.assertIn(f"{USUAL} is taken by another program", said)
        address = re.search(r"give every client --connect (127\.0\.0\.1:\d+)$", said, re.MULTILINE)
        self.assertIsNotNone(address, said)
        self.assertIn(f"haptic_server listens at {address[1]};", said)
        self.assertIn(f"hapticctl --connect {address[1]} status", said)

    def test_an_interrupt_ends_both_and_still_writes_the_summary(self):
        run = self.start("--seconds", "300")
        log = self.out / "viewer.log"
        deadline = time.monotonic() + 300
        holds_all = re.compile(r"^scene revision \d+ root \w+ equal$", re.M)
        while not (log.exists() and holds_all.search(log.read_text())) and time.monotonic() < deadline:
            time.sleep(0.1)
        os.killpg(run.pid, signal.SIGINT)
        said, _ = run.communicate(timeout=900)
        self.assertEqual(run.returncode, 0, said)
        self.assertTrue(self.summary()["hashes_equal"])

    def test_a_scene_that_is_refused_is_the_reason_shown(self):
        scene = Path(self.out.parent) / "bad.scene"
        scene.write_text('operations { add { name: "a" mesh { file: "absent.ply" } } }')
        run = self.start("--seconds", "5", "--scene", scene)
        said, _ = run.communicate(timeout=900)
        self.assertNotEqual(run.returncode, 0)
        self.assertIn("absent.ply", said)


if __name__ == "__main__":
    unittest.main()
