"""A server with --state that is killed at any moment: what it had accepted is there when it starts again, once."""
import os
import random
import resource
import signal
import threading
import time
import unittest

from google.protobuf import text_format

import harness
from haptics.v1 import envelope_pb2, scene_pb2
from imports import children_of

KILLS = int(os.environ.get("HAPTICS_KILLS", "10"))
WITHIN_S = float(os.environ.get("HAPTICS_KILL_WITHIN_S", "0.5"))  # of an accepted edit
SEED = int(os.environ.get("HAPTICS_SEED", "1"))
EDITORS = 3
PATIENCE_S = 60

SCENE = """
operations { add { name: "counter" mesh { box { size_m { x: 0.05 y: 0.05 z: 0.05 } } } } }
operations { add { name: "shape" mesh { sphere { radius_m: 0.03 segments: 4 } } } }
"""


class Client(harness.WireClient):
    """One connection of a session."""

    def __init__(self, server, session, name):
        super().__init__(server)
        self.objects = {}
        try:
            self.join(session, name)
        except BaseException:
            self.close()
            raise

    def join(self, session, name):
        hello = harness.hello_envelope(name)
        hello.hello.session = session
        self.send_envelope(hello)
        self.until("welcome")
        while (envelope := self.next()).WhichOneof("body") != "snapshot_end":
            for state in envelope.snapshot_objects.object:
                self.objects[state.name] = state

    def next(self):
        envelope = self.receive_envelope()
        if envelope is None:
            raise ConnectionError("closed")
        if envelope.HasField("refusal"):
            raise AssertionError(envelope.refusal)
        return envelope

    def until(self, kind):
        while True:
            envelope = self.next()
            if envelope.WhichOneof("body") == kind:
                return getattr(envelope, kind)

    def edit(self, request):
        """Sends an edit and returns the reply to it."""
        self.send_envelope(envelope_pb2.Envelope(protocol_version=1, edit_request=request))
        while True:
            reply = self.until("edit_reply")
            if reply.client_seq == request.client_seq:
                return reply


class Editor(threading.Thread):
    """Edits as fast as it is answered, over as many connections as it takes, each edit exactly once."""

    def __init__(self, number, server):
        super().__init__(daemon=True)
        self.number, self.server = number, server
        self.session = random.getrandbits(63) | 1
        self.seq = 0
        self.revisions = []  # of its accepted edits
        self.resent = 0
        self.client = None
        self.failure = None
        self.stopping = threading.Event()

    def run(self):
        try:
            while not self.stopping.is_set():
                self.one_edit()
        except BaseException as failure:  # told to the test by join_checked()
            self.failure = failure
        if self.client:
            self.client.close()

    def connect(self):
        deadline = time.monotonic() + PATIENCE_S
        while True:
            try:
                return Client(self.server, self.session, f"editor {self.number}")
            except OSError:
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.02)

    def one_edit(self):
        """Until it is accepted."""
        while True:
            self.client = self.client or self.connect()
            self.seq += 1
            reply = self.answered(envelope_pb2.EditRequest(client_seq=self.seq, transaction=self.transaction()))
            if reply.HasField("accepted"):
                self.revisions.append(reply.accepted.revision)
                self.saw(reply.accepted.object)
                return
            if "server died" in reply.rejected.reason:
                continue  # while it was at this one: to be tried under another number
            if not reply.HasField("conflict"):
                raise AssertionError(reply)
            self.saw(reply.conflict.current)

    def answered(self, request):
        while True:
            try:
                self.client = self.client or self.connect()
                return self.client.edit(request)
            except OSError:
                self.client.close()
                self.client = None
                self.resent += 1

    def saw(self, states):
        for state in states:
            self.client.objects[state.name] = state

    def join_checked(self):
        self.stopping.set()
        self.join(PATIENCE_S)
        if self.failure:
            raise self.failure
        if self.is_alive():
            raise AssertionError(f"editor {self.number} hangs")


class Counter(Editor):
    """Reads a number in the scene and writes it back one larger."""

    def transaction(self):
        time.sleep(0.008)  # a session may send 200 edits a second
        counter = self.client.objects["counter"]
        transaction = scene_pb2.Transaction()
        condition = transaction.preconditions.add(expected_revision=counter.revision)
        condition.object.name = "counter"
        move = transaction.operations.add().set_pose
        move.object.name = "counter"
        move.pose.position.CopyFrom(counter.pose.position)
        move.pose.position.x += 2.0 ** -10  # exact, and small enough for the scene
        return transaction


class Sculptor(Editor):
    """Gives an object one shape after the other: enough bytes that the log is often replaced."""

    def transaction(self):
        time.sleep(0.02)
        transaction = scene_pb2.Transaction()
        remesh = transaction.operations.add().remesh
        remesh.object.name = "shape"
        remesh.mesh.sphere.radius_m = 0.03 + 1e-6 * self.seq
        remesh.mesh.sphere.segments = 40
        return transaction


class DurableState(harness.EndToEnd):
    def start(self, listen="127.0.0.1:0"):
        return self.start_server(scene=SCENE, listen=listen, options=["--state", self.folder / "state"])

    def connect(self, server, session):
        client = Client(server, session, "editor")
        self.addCleanup(client.close)
        return client

    def test_an_edit_at_which_the_server_died_is_not_tried_again(self):
        large = ('operations { add { name: "large" mesh { sphere { radius_m: 0.05 segments: 700 } } '
                 'motion { mass_kg: 1 } } }')
        request = envelope_pb2.EditRequest(transaction=text_format.Parse(large, scene_pb2.Transaction()))
        small = envelope_pb2.EditRequest(transaction=text_format.Parse(SCENE, scene_pb2.Transaction()))
        for client_seq, number, works_s in ((1, signal.SIGSEGV, 0.5), (3, signal.SIGKILL, 3)):
            server = self.start()
            client = self.connect(server, 99)
            request.client_seq = client_seq
            client.send_envelope(envelope_pb2.Envelope(protocol_version=1, edit_request=request))
            harness.wait_until(lambda: children_of(server.process.pid, "asset_importer"), 30, server.text)
            until = time.monotonic() + works_s
            while time.monotonic() < until:
                time.sleep(0.1)
                client.send_envelope(envelope_pb2.Envelope(protocol_version=1, heartbeat=envelope_pb2.Heartbeat()))
            server.send(number)
            server.process.wait(PATIENCE_S)
            server = self.start()
            self.assertIn("died while it was at 1 edit", server.text())
            client = self.connect(server, 99)
            self.assertIn('died, about the object "large"', client.edit(request).rejected.reason)
            small.client_seq = client_seq + 1
            for operation in small.transaction.operations:
                operation.add.name += f"-{client_seq}"
            reply = client.edit(small)
            self.assertTrue(reply.HasField("accepted"), reply)
            server.kill()

    def test_nothing_accepted_is_lost_or_doubled_by_kills_at_any_moment(self):
        moments = random.Random(SEED)
        server = self.start()
        epoch = server.status()["epoch"]
        editors = [Counter(i, server) for i in range(EDITORS)] + [Sculptor(EDITORS, server)]
        for editor in editors:
            editor.start()
        cut_off = 0
        for kill in range(KILLS):
            accepted = sum(len(editor.revisions) for editor in editors)
            harness.wait_until(lambda: sum(len(editor.revisions) for editor in editors) > accepted
                               or any(editor.failure for editor in editors), PATIENCE_S, "an accepted edit")
            time.sleep(moments.uniform(0, WITHIN_S))
            server.kill()
            server = self.start(server.address)
            harness.wait_until(lambda: "going on at revision" in server.text(), PATIENCE_S, server.text)
            cut_off += "incomplete" in server.text()
            self.assertNotIn("may have been answered", server.text())
        for editor in editors:
            editor.join_checked()

        status, scene = server.status(), server.ctl("get").json()
        revisions = [revision for editor in editors for revision in editor.revisions]
        counted = sum(len(editor.revisions) for editor in editors if isinstance(editor, Counter))
        held = {o["name"]: o for o in scene["object"]}["counter"]["pose"]["position"]["x"] * 2 ** 10
        print(f"\n{KILLS} kills, {len(revisions)} edits accepted, {sum(editor.resent for editor in editors)} sent again, "
              f"{counted} increments, {held:.0f} held, {cut_off} logs cut off", flush=True)
        self.assertEqual(held, counted, "increments lost or doubled")
        self.assertEqual(len(set(revisions)), len(revisions), "two edits were given one revision")
        self.assertEqual(sorted(revisions), list(range(2, int(status["revision"]) + 1)), "revisions lost or doubled")
        self.assertEqual(status["epoch"], epoch, "nothing was lost, so clients may resume")
        self.assertEqual(server.ctl("verify").code, 0, "a client that computes the root anew has another one")
        self.stop_and_check(server)

    def test_a_full_disk_rejects_edits_and_nothing_else(self):
        server = self.start()
        client = self.connect(server, 7)
        request = envelope_pb2.EditRequest(client_seq=1)
        move = request.transaction.operations.add().set_pose
        move.object.name = "counter"
        move.pose.position.x = 0.1
        self.assertTrue(client.edit(request).HasField("accepted"))

        pid, full = server.process.pid, (self.folder / "state" / "log").stat().st_size
        limits = resource.prlimit(pid, resource.RLIMIT_FSIZE)
        resource.prlimit(pid, resource.RLIMIT_FSIZE, (full, limits[1]))
        request.client_seq = 2
        ticks = int(server.status()["ticks"])
        for _ in range(20):
            reply = client.edit(request)
            self.assertEqual(reply.rejected.field, "state", reply)
        harness.wait_until(lambda: int(server.status()["ticks"]) > ticks + 100, PATIENCE_S, "the servo going on")
        self.assertTrue(server.status()["durable"])

        resource.prlimit(pid, resource.RLIMIT_FSIZE, limits)
        self.assertEqual(client.edit(request).accepted.revision, 3)
        server.kill()
        self.assertEqual(int(self.start().status()["revision"]), 3)

    def test_an_edit_that_is_sent_again_is_answered_and_felt_again(self):
        server = self.start()
        request = envelope_pb2.EditRequest(client_seq=1)
        request.transaction.operations.add().remove.object.name = "shape"
        first = self.connect(server, 7).edit(request)
        server.kill()
        server = self.start()
        again = self.connect(server, 7)
        self.assertEqual(again.edit(request).accepted, first.accepted)
        self.assertEqual(again.until("edit_live").revision, first.accepted.revision)
        self.assertEqual(int(server.status()["revision"]), first.accepted.revision)

    def test_a_folder_serves_one_server(self):
        self.start()
        with self.assertRaises(harness.NotStarted) as refusal:
            self.start()
        self.assertEqual(refusal.exception.code, 1)
        self.assertIn("another server", str(refusal.exception))


if __name__ == "__main__":
    unittest.main()
