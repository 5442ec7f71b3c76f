"""proto/README.md says what a server does: the bytes, hashes and commands of its worked example, against one that runs."""
import hashlib
import re
import shlex
import struct
import subprocess
import unittest

import harness
from haptics.v1 import envelope_pb2

PAGE = (harness.Path(__file__).resolve().parents[2] / "proto/README.md").read_text()


def bytes_of(block):
    """Of lines of hexadecimal digits, each with a comment behind two spaces."""
    return b"".join(bytes.fromhex(line.split("  ")[0]) for line in block.splitlines())


def hashed_blocks():
    """(bytes, SHA-256 as the page has it), in the page's order."""
    found = re.findall(r"^```hex\n(.*?)^```\nSHA-256: `([0-9a-f]{64})`$", PAGE, re.MULTILINE | re.DOTALL)
    return [(bytes_of(block), digest) for block, digest in found]


def frame(name):
    return bytes_of(re.search(rf"^```frame {name}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)[1])


def commands(program):
    return [shlex.split(line, comments=True) for line in re.findall(rf"^\$ ({program} .*)$", PAGE, re.MULTILINE)]


class PageServer(harness.Process):
    """The page's server with the page's scene, at a free port."""
    host_and_port = harness.Server.host_and_port

    def __init__(self, folder):
        scene = re.search(r"^```protobuf\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)[1]
        (folder / "one_box.scene").write_text(scene)
        (command,) = commands("haptic_server")
        program, *options = (word.replace(":7654", ":0") for word in command)
        super().__init__([harness.BIN / program, *options], cwd=folder)
        harness.wait_until(lambda: self.find(r"^listening on ") or not self.alive(), harness.START_TIMEOUT_S, self.text)
        self.address = self.find(r"^listening on (\S+)")[1]


class ProtocolPage(harness.EndToEnd):
    def start(self):
        server = PageServer(self.folder)
        self.addCleanup(server.kill)
        return server

    def test_its_hashes_are_those_of_its_bytes(self):
        blocks = hashed_blocks()
        self.assertEqual([len(data) for data, _ in blocks], [264, 143, 56, 183, 56])  # as the text says of the first ones
        for data, digest in blocks:
            self.assertEqual(hashlib.sha256(data).hexdigest(), digest)
        (_, mesh), (first, first_hash), (first_root, _), (second, second_hash), (second_root, _) = blocks
        for whole, part in ((first, mesh), (second, mesh), (first_root, first_hash), (second_root, second_hash)):
            self.assertIn(bytes.fromhex(part), whole)
        self.assertIn(f"`{hashlib.sha256(bytes(8)).hexdigest()}`", PAGE)  # the empty scene's root

    def test_a_server_sends_its_frames_and_comes_to_its_roots(self):
        server = self.start()
        (mesh, mesh_hash), _, (_, first_root), _, (_, second_root) = hashed_blocks()
        client = harness.WireClient(server)
        self.addCleanup(client.close)
        client.send(frame("Hello"))
        for body in ("welcome", "snapshot_begin", "snapshot_objects"):
            self.assertEqual(client.receive_envelope().WhichOneof("body"), body)
        end = frame("SnapshotEnd")
        self.assertEqual(client.receive_exactly(len(end)), end)
        self.assertEqual(end[-32:].hex(), first_root)

        client.send_envelope(envelope_pb2.Envelope(protocol_version=1, asset_request=envelope_pb2.AssetRequest(
            hash=bytes.fromhex(mesh_hash))))
        self.assertEqual(self.next_of(client, "asset_chunk").data, mesh)
        client.send(frame("EditRequest"))
        self.assertEqual(self.next_of(client, "commit").root.hex(), second_root)

    def next_of(self, client, body):
        while True:
            envelope = client.receive_envelope()
            self.assertIsNotNone(envelope, f"the server closed before its {body}")
            self.assertNotEqual(envelope.WhichOneof("body"), "refusal", envelope)
            if envelope.WhichOneof("body") == body:
                return getattr(envelope, body)

    def test_its_commands_run(self):
        server = self.start()
        root = hashed_blocks()[2][1]
        for program, *options in commands("hapticctl"):
            options = [word.replace("127.0.0.1:7654", server.address) for word in options]
            done = subprocess.run([harness.BIN / program, *options], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(root, done.stdout)

    def test_frames_before_welcome_are_as_short_as_it_says(self):
        server = self.start()
        for length, field in ((0, "frame.length"), (1024, "frame"), (1025, "frame.length")):
            with self.subTest(length=length):
                client = harness.WireClient(server)
                self.addCleanup(client.close)
                client.send(struct.pack("<I", length) + b"\xff" * length)
                self.assertEqual(client.receive_envelope().refusal.field, field)


if __name__ == "__main__":
    unittest.main()
