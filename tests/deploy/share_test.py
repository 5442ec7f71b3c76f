"""deploy/share, as it is typed beside a server that runs.

usage: share_test.py PROGRAMS [-v]
"""
import json
import os
import random
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
PROGRAMS = Path(sys.argv.pop(1)).resolve()
PATIENCE_S = 300  # it builds what is missing


def three_free_ports():
    """The first of three that follow each other."""
    for first in random.sample(range(20000, 30000, 3), 100):
        held = []
        try:
            held = [socket.create_server(("127.0.0.1", first + i)) for i in range(3)]
            return first
        except OSError:
            continue
        finally:
            for each in held:
                each.close()
    raise AssertionError("no ports")


class Share(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.port = three_free_ports()

    def start(self, name, *command):
        log = (self.folder / f"{name}.log").open("w")
        process = subprocess.Popen([*map(str, command)], stdout=log, stderr=subprocess.STDOUT, cwd=self.folder,
                                   start_new_session=True)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)  # the watchdog of a server that is killed would write into the folder
        log.close()
        return process

    def wait_for(self, name, pattern, process):
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            text = (self.folder / f"{name}.log").read_text()
            if found := re.search(pattern, text, re.MULTILINE):
                return found
            if process.poll() is not None:
                break
            time.sleep(0.1)
        self.fail(f"{pattern}: {text}")

    def start_share(self, *options):
        return self.start("share", PROJECT / "deploy/share", "--port", self.port, "--out", self.folder / "out", *options)

    def test_a_running_server_is_shown_until_an_interrupt(self):
        server = self.start("server", PROGRAMS / "haptic_server", "--scene", PROJECT / "deploy/scenes/demo.scene", "--assets",
                            "/usr/share/inventor/data", "--listen", "127.0.0.1:0")
        address = self.wait_for("server", r"^listening on (\S+)", server)[1]
        share = self.start_share("--connect", address, "--session", "lecture")
        shown = self.wait_for("share", r"^viewer  \S+/graphics_client --nats (\S+) --session (\S+)$", share)
        watcher = self.start("watcher", PROGRAMS / "watch_session", *shown.groups(), self.folder / "watched.json")
        self.wait_for("watcher", r"^scene revision 1 root \w{64} equal$", watcher)
        if (PROJECT / "build/web/node_modules/fetched-by").exists():
            page = self.wait_for("share", r"^page    (http://\S+)$", share)[1]
            self.assertIn(b"<title>", urllib.request.urlopen(page).read())
            config = json.load(urllib.request.urlopen(page + "haptics.json"))
            self.assertEqual(config, {"nats": f"ws://127.0.0.1:{self.port + 1}", "session": "lecture"})
        for origin, answer in (("http://evil.example", b"403"), (f"http://127.0.0.1:{self.port}", b"403"),
                               (f"http://127.0.0.1:{self.port + 2}", b"101")):
            with socket.create_connection(("127.0.0.1", self.port + 1), 10) as page:
                page.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nOrigin: {origin}\r\n"
                             "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode())
                self.assertEqual(page.recv(4096).split()[1], answer, origin)
        os.kill(share.pid, signal.SIGINT)
        self.assertEqual(share.wait(20), 130)
        with self.assertRaises(OSError):
            socket.create_connection(("127.0.0.1", self.port), 1)
        self.assertIsNone(server.poll())

    def test_a_page_that_cannot_be_served_is_named(self):
        if not (PROJECT / "build/web/node_modules/fetched-by").exists():
            self.skipTest("the web page is not built")
        with socket.create_server(("127.0.0.1", self.port + 2)):
            share = self.start_share()
            self.assertEqual(share.wait(PATIENCE_S), 1)
        self.assertTrue((self.folder / "share.log").read_text().endswith("deploy/share: the web page did not start\n"))

    def test_a_taken_port_and_bad_options_are_named(self):
        with socket.create_server(("127.0.0.1", self.port)):
            share = self.start_share()
            self.assertEqual(share.wait(PATIENCE_S), 1)
        text = (self.folder / "share.log").read_text()
        self.assertIn("address already in use", text)
        self.assertTrue(text.endswith("deploy/share: NATS did not start\n"), text)
        for options, reason in ((["--port", "x"], "--port x: should be a number"), (["--session"], "--session needs a value"),
                                (["--who"], "unknown option --who")):
            refused = subprocess.run([PROJECT / "deploy/share", *options], capture_output=True, text=True)
            self.assertEqual(refused.returncode, 2)
            self.assertIn(reason, refused.stderr)


if __name__ == "__main__":
    unittest.main()
