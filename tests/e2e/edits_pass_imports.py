"""Imports that take long: another client's edits pass them, their sender sees how far they are, and may leave."""
import os
import signal
import statistics
import threading
import time
import unittest
from pathlib import Path

import harness
from cancelled_upload import Terminal
from haptic_client import Client
from imports import ADD_SOUP, children_of, write_soup

SPHERE = ('operations { add { name: "sphere" mesh { sphere { radius_m: 0.05 segments: 1024 } } '
          'pose { position { z: -0.5 } } motion { mass_kg: 1 } } }')  # 12.6 million triangles
P99_S = 0.050
CANCELLED_S = 0.100
FREED_S = 0.200  # and its memory given back, and that seen
STOPPED_S = 2
# How long edits are made beside one import, and beside its end.
BESIDE_S = float(os.environ.get("HAPTICS_SECONDS", "8"))
EXIT_INTERRUPTED = 130
# Of a machine that is busy with other things nothing can be asked.
BUSY = "HAPTICS_INSTRUMENTED" in os.environ


def stiffness(value):
    return (f'operations {{ set_material {{ object {{ name: "box" }} material {{ stiffness_N_per_m: {value} }} }} }}')


def work_of(pid):
    """Ticks of the clock, usually 10 ms each, that each thread of a process has worked."""
    def of(task):
        fields = (task / "stat").read_text().rpartition(")")[2].split()
        return int(fields[11]) + int(fields[12])
    return {task.name: of(task) for task in Path(f"/proc/{pid}/task").iterdir()}


def is_at_work(pid, seconds=0.02):
    """Whether some thread works for at least half of this time."""
    before = work_of(pid)
    time.sleep(seconds)
    least = 0.5 * seconds * os.sysconf("SC_CLK_TCK")
    return any(ticks - before.get(thread, 0) >= least for thread, ticks in work_of(pid).items())


def read_all(screen):
    """Else a program that writes to its terminal waits for whoever reads it."""
    try:
        while os.read(screen, 4096):
            pass
    except OSError:
        pass


class EditsPassImports(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.assets = self.folder / "assets"
        self.assets.mkdir()
        write_soup(self.assets / "soup.obj")
        self.server = harness.Server(self.folder, options=["--assets", self.assets])
        self.addCleanup(self.server.kill)

    def begin(self, text):
        """A client that asks for it; its standard error is a terminal."""
        terminal = Terminal([harness.BIN / "hapticctl", "--connect", self.server.address, "apply", "-"], text)
        self.addCleanup(terminal.close)
        return terminal

    def latencies(self, client, goes_on):
        """Seconds from each stiffness edit to its reply."""
        seconds = []
        while goes_on() or len(seconds) < 100:
            began = time.monotonic()
            client.submit(stiffness(500 + len(seconds) % 100)).result(60)
            seconds.append(time.monotonic() - began)
            time.sleep(0.01)
        return seconds

    def check(self, what, seconds):
        seconds = sorted(seconds)
        p99 = seconds[int(0.99 * len(seconds))]
        print(f"{what}: {len(seconds)} edits, p50 {1e3 * statistics.median(seconds):.1f} ms, p99 {1e3 * p99:.1f} ms, "
              f"most {1e3 * seconds[-1]:.1f} ms")
        if not BUSY:
            self.assertLessEqual(p99, P99_S, what)

    def test_edits_pass_imports(self):
        with Client(self.server.address) as client:
            client.wait_live(30)
            self.check("alone", self.latencies(client, lambda: False))
            for what, text in (("soup", ADD_SOUP), ("sphere", SPHERE)):
                importer = self.begin(text)
                importer.read_until("making [")
                threading.Thread(target=read_all, args=[importer.screen], daemon=True).start()
                until = time.monotonic() + BESIDE_S
                self.check(f"beside the {what}'s import",
                           self.latencies(client, lambda: importer.process.poll() is None and time.monotonic() < until))
                if importer.process.poll() is None and what == "sphere":
                    self.check("beside the end of the sphere's import",
                               self.latencies(client, lambda: importer.process.poll() is None))
                    self.assertEqual(importer.process.returncode, 0)
                    self.check("beside the large sphere", self.latencies(client, lambda: False))

    def test_the_sender_sees_how_far_it_is(self):
        sphere = self.begin(SPHERE)
        sphere.read_until("making [")
        sphere.read_until("building [")
        sphere.read_until("45 %")

    def test_it_ends_with_its_sender(self):
        for ends in ("leaves", "interrupts"):
            sender = self.begin(ADD_SOUP)
            pid = harness.wait_until(lambda: children_of(self.server.process.pid, "asset_importer"), 30, "none")[0]
            time.sleep(0.3)
            sender.process.send_signal(signal.SIGKILL if ends == "leaves" else signal.SIGINT)
            if ends == "interrupts":
                self.assertEqual(sender.process.wait(10), EXIT_INTERRUPTED)
            began = time.monotonic()
            harness.wait_until(lambda: not Path(f"/proc/{pid}").exists(), 30, "it goes on", pause_s=0.002)
            took_s = time.monotonic() - began
            print(f"its sender {ends}: the importer is gone after {1e3 * took_s:.0f} ms")
            if not BUSY:
                self.assertLessEqual(took_s, CANCELLED_S)

    def test_the_server_ends_its_part_with_the_sender(self):
        for wait_s in (0.2, 1, 2, 3):
            sender = self.begin(SPHERE)
            sender.read_until("building [")
            time.sleep(wait_s)
            self.assertTrue(is_at_work(self.server.process.pid), "nothing is built")
            sender.process.kill()
            began = time.monotonic()
            while is_at_work(self.server.process.pid):
                self.assertLess(time.monotonic() - began, 30, "it goes on")
            took_s = time.monotonic() - began
            print(f"its sender leaves {wait_s} s after the building began: the server is idle after {1e3 * took_s:.0f} ms")
            if not BUSY:
                self.assertLessEqual(took_s, FREED_S)

    def test_the_server_stops_whatever_is_made(self):
        for text, where in ((ADD_SOUP, "making ["), (SPHERE, "making ["), (SPHERE, "building [")):
            sender = self.begin(text)
            sender.read_until(where)
            time.sleep(0.5)
            began = time.monotonic()
            self.server.process.send_signal(signal.SIGTERM)
            self.assertEqual(self.server.process.wait(30), 0)
            took_s = time.monotonic() - began
            print(f"asked to stop while it is {where[:-2]}: the server has ended after {1e3 * took_s:.0f} ms")
            if not BUSY:
                self.assertLessEqual(took_s, STOPPED_S)
            self.server = harness.Server(self.folder, options=["--assets", self.assets])
            self.addCleanup(self.server.kill)

    def test_its_successor_is_carried_out(self):
        sender = self.begin(ADD_SOUP)
        harness.wait_until(lambda: children_of(self.server.process.pid, "asset_importer"), 30, "none")
        self.assertEqual(self.server.ctl("apply", "-", text=stiffness(700)).json()["revision"], 2)
        sender.process.kill()
        self.assertEqual(self.server.ctl("apply", "-", text=stiffness(701)).json()["revision"], 3)


if __name__ == "__main__":
    unittest.main()
