"""A session by OpenIGTLink: haptic_igtl beside OpenIGTLink's own library (igtl_peer), as 3D Slicer or PLUS would use it.

usage: openigtlink.py [-v]
"""
import json
import math
import re
import socket
import struct
import threading
import time
import unittest

import harness
from haptic_client import Client

HEAD = ">H12s20sQQQ"  # version, type, name, time, size of the body, its CRC


class OpenIgtLink(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.server = self.start_server()

    def start_bridge(self, *options):
        bridge = harness.Process([harness.BIN / "haptic_igtl", "--connect", self.server.address, "--listen", "127.0.0.1:0", *options])
        self.addCleanup(bridge.kill)
        harness.wait_until(lambda: "connected to" in bridge.text(), harness.START_TIMEOUT_S, bridge.text)
        self.port = int(re.search(r"OpenIGTLink at 127.0.0.1:(\d+)", bridge.text())[1])
        return bridge

    def peer(self, verb, *arguments):
        peer = harness.Process([harness.BIN / "igtl_peer", verb, self.port, *arguments])
        self.addCleanup(peer.kill)
        return peer

    def read(self, seconds):
        peer = self.peer("read", seconds)
        self.assertEqual(peer.wait(seconds + harness.STOP_TIMEOUT_S), 0, peer.text())
        return [json.loads(line) for line in peer.lines]

    def test_the_session_is_what_the_library_reads(self):
        self.start_bridge("--rate", "500")
        with Client(self.server.address, every_tick=True) as client:
            said = self.read(3)
            felt = list(client.samples(0))
        self.assertEqual({(line["type"], line["name"]) for line in said},
                         {("TRANSFORM", "HIP"), ("TRANSFORM", "IHIP"), ("TRANSFORM", "torus"), ("TRANSFORM", "box"),
                          ("POSITION", "Stylus"), ("SENSOR", "Force")})
        hips = {as_floats(1e3 * x for x in (s.hip.x, s.hip.y, s.hip.z)) for s in felt}
        forces = {(s.force.written.x, s.force.written.y, s.force.written.z) for s in felt}
        for kind, name, key, known in (("TRANSFORM", "HIP", "at", hips), ("POSITION", "Stylus", "at", hips),
                                       ("SENSOR", "Force", "values", forces)):
            with self.subTest(name):
                told = [line[key] for line in said if (line["type"], line["name"]) == (kind, name)]
                told = [tuple(values) if key == "values" else as_floats(values) for values in told]
                self.assertGreater(len(told), 60)
                self.assertGreater(sum(value in known for value in told), 0.9 * len(told))
        self.assertTrue(all(line["newtons"] for line in said if line["type"] == "SENSOR"))
        boxes = [line for line in said if line["name"] == "box"]
        self.assertEqual((boxes[0]["at"], boxes[0]["x"], boxes[0]["y"]), ([60, 0, 25], [1, 0, 0], [0, 1, 0]))
        self.assertLess(len(boxes), 10, "it stands still")
        self.assertLess(abs(said[-1]["time_s"] - time.time()), 2)

    def test_transforms_move_an_object(self):
        self.start_bridge()
        for rate_hz in (50, 10_000):
            with self.subTest(rate_hz=rate_hz):
                mover = self.peer("move", "box", rate_hz, 2, "circle")
                with Client(self.server.address, telemetry_hz=100) as client:
                    poses = []
                    for _ in client.samples(2.5):
                        if "box" in client.bodies():
                            poses.append(client.bodies()["box"].pose)
                self.assertEqual(mover.wait(), 0, mover.text())
                late = poses[len(poses) // 2:]
                self.assertTrue(late and all(abs(math.hypot(p.position.x, p.position.y) - 0.05) < 0.002 for p in late), late[-3:])
                self.assertGreater(max(p.position.y for p in late) - min(p.position.y for p in late), 0.03)
                self.assertAlmostEqual(2 * math.atan2(late[-1].rotation.z, late[-1].rotation.w), 2, delta=0.05)
        self.assertEqual(self.server.status()["fault"], "FAULT_NONE")
        box = [line for line in self.read(2) if line["name"] == "box"][-1]
        self.assertAlmostEqual(math.hypot(*box["at"][:2]), 50, delta=2)
        self.assertAlmostEqual(math.atan2(box["x"][1], box["x"][0]), 2, delta=0.05)

    def test_a_pose_that_the_server_refuses_holds_up_no_other(self):
        bridge = self.start_bridge()
        made, over = self.connection(), threading.Event()
        body = struct.pack(">12f", 1, 0, 0, 0, 1, 0, 0, 0, 1, 1e30, 0, 0)
        far = struct.pack(HEAD, 1, b"TRANSFORM", b"torus", 0, len(body), crc(body)) + body

        def flood():
            while not over.is_set():
                made.sendall(100 * far)
        thread = threading.Thread(target=flood)
        thread.start()
        harness.wait_until(lambda: "pose was refused" in bridge.text(), 10, bridge.text)
        mover = self.peer("move", "box", 50, 2, "circle")
        with Client(self.server.address, telemetry_hz=100) as client:
            places = [client.bodies()["box"].pose.position for _ in client.samples(2.5) if "box" in client.bodies()]
        over.set()
        thread.join()
        self.assertEqual(mover.wait(), 0, mover.text())
        self.assertGreater(len(set(round(p.y, 4) for p in places)), 20)

    def test_what_is_no_pose_is_refused_and_said(self):
        bridge = self.start_bridge()
        for thing, motion, word in (("box", "nan", "finite"), ("box", "skewed", "a rotation"), ("nobody", "circle", "no such object")):
            with self.subTest(motion=motion, thing=thing):
                self.assertEqual(self.peer("move", thing, 1000, 1.5, motion).wait(), 0)
                harness.wait_until(lambda word=word: word in bridge.text(), 5, bridge.text)
        self.assertLess(len(bridge.text().splitlines()), 30, "a flood is not a flood of words")
        with Client(self.server.address, telemetry_hz=100) as client:
            next(client.samples())
            self.assertNotIn("box", client.bodies())

    def connection(self):
        made = socket.create_connection(("127.0.0.1", self.port))
        self.addCleanup(made.close)
        return made

    def test_what_is_no_message_ends_its_connection_alone(self):
        bridge = self.start_bridge()
        wrong = {"its version": struct.pack(HEAD, 9, b"TRANSFORM", b"box", 0, 48, 0),
                 "its checksum": struct.pack(HEAD, 1, b"TRANSFORM", b"box", 0, 48, 1) + bytes(48),
                 "shorter than": struct.pack(HEAD, 2, b"TRANSFORM", b"box", 0, 3, 0) + bytes(3)}
        for word, message in wrong.items():
            with self.subTest(word):
                made = self.connection()
                made.sendall(message)
                harness.wait_until(lambda word=word: word in bridge.text(), 10, bridge.text)
                made.settimeout(10)
                try:
                    while made.recv(65536):
                        pass
                except ConnectionResetError:
                    pass
        made = self.connection()  # other messages, and long ones, are read over
        made.sendall(struct.pack(HEAD, 1, b"IMAGE", b"picture", 0, 10_000_000, 0))
        for _ in range(100):
            made.sendall(bytes(100_000))
        made.sendall(struct.pack(HEAD, 1, b"GET_TRANS", b"", 0, 0, 0))
        # The second version has its content between two parts more.
        identity = struct.pack(">12f", 1, 0, 0, 0, 1, 0, 0, 0, 1, 10, 20, 30)
        body = struct.pack(">HHII", 12, 2, 3, 0) + identity + bytes(5)
        made.sendall(struct.pack(HEAD, 2, b"TRANSFORM", b"box", 0, len(body), crc(body)) + body)
        with Client(self.server.address, telemetry_hz=100) as client:
            box = None
            for _ in client.samples(1):
                box = client.bodies().get("box", box)
        at = box.pose.position
        self.assertEqual([round(x, 6) for x in (at.x, at.y, at.z)], [0.01, 0.02, 0.03])
        self.assertTrue(bridge.alive(), bridge.text())

    def test_who_does_not_read_holds_up_nobody(self):
        bridge = self.start_bridge("--rate", "1000")
        held = [self.connection() for _ in range(15)]
        time.sleep(5)
        self.assertGreater(len(self.read(2)), 100)
        made = [self.connection() for _ in range(2)]
        harness.wait_until(lambda: "is turned away" in bridge.text(), 10, bridge.text)
        for each in held + made:
            each.close()
        harness.wait_until(lambda: bridge.text().count(" left: ") >= 16, 10, bridge.text)

    def test_it_goes_on_with_a_server_that_comes_back_and_ends_when_told(self):
        bridge = self.start_bridge()
        address = self.server.address
        self.server.stop()
        harness.wait_until(lambda: len(bridge.errors) > 2, 10, bridge.text)
        self.server = self.start_server(listen=address)
        harness.wait_until(lambda: any(line["name"] == "HIP" for line in self.read(2)), 20, bridge.text)
        self.assertEqual(bridge.stop(), 0, bridge.text())


def as_floats(values):
    """Rounded to 32 bits."""
    return struct.unpack("3f", struct.pack("3f", *values))


def crc(data):
    """ECMA-182, bit by bit."""
    remainder = 0
    for byte in data:
        remainder ^= byte << 56
        for _ in range(8):
            remainder = (remainder << 1 ^ (0x42F0E1EBA9EA3693 if remainder >> 63 else 0)) & (1 << 64) - 1
    return remainder


if __name__ == "__main__":
    unittest.main()
