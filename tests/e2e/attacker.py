"""What attacks have in common: a client that says what it likes, and a server that must be unharmed afterwards."""
import contextlib
import os
import select
import ssl
import time
from pathlib import Path

import harness
from haptics.v1 import envelope_pb2

INSTRUMENTED = "HAPTICS_INSTRUMENTED" in os.environ  # such a program keeps what it has freed: its size says nothing
HEARTBEAT_S = 1.0  # the server leaves a client that says nothing for 3 s


class Client(harness.WireClient):
    """Welcomed, with answers found by their kind. It and its `fellows`, the clients of one test, stay connected while one of them
    speaks or waits."""

    def __init__(self, server, fellows, tls=None, token=b""):
        super().__init__(server, tls)
        self.fellows = fellows
        self.send_envelope(harness.hello_envelope("attacker", token=token))
        self.welcome = self.answer("welcome").welcome
        fellows.append(self)

    def send(self, data):
        super().send(data)
        self.sent = time.monotonic()

    def keep_connected(self):
        for one in self.fellows:
            if time.monotonic() - one.sent > HEARTBEAT_S:
                one.sent = time.monotonic()
                with contextlib.suppress(OSError):  # some are refused, and closed
                    one.send_envelope(envelope_pb2.Envelope(protocol_version=1, heartbeat=envelope_pb2.Heartbeat()))

    def say(self, fill):
        envelope = envelope_pb2.Envelope(protocol_version=1)
        fill(envelope)
        self.send_envelope(envelope)
        self.keep_connected()

    def edit(self, fill, seq=1):
        """The reply to a transaction of one operation that `fill` fills in."""
        def request(envelope):
            envelope.edit_request.client_seq = seq
            fill(envelope.edit_request.transaction.operations.add())
        self.say(request)
        return self.answer("edit_reply").edit_reply

    def upload(self, data, digest, kind=1):
        def request(envelope):
            chunk = envelope.asset_upload.chunk
            chunk.hash, chunk.kind, chunk.total_size, chunk.data = digest, kind, len(data), data
        self.say(request)
        return self.answer("asset_upload_reply").asset_upload_reply

    def answer(self, kind):
        deadline = time.monotonic() + harness.START_TIMEOUT_S
        while True:
            self.keep_connected()
            is_there = isinstance(self.socket, ssl.SSLSocket) and self.socket.pending()
            while not is_there and not select.select([self.socket], [], [], HEARTBEAT_S)[0]:
                self.keep_connected()
                if time.monotonic() > deadline:
                    raise AssertionError(f"no {kind} came")
            envelope = self.receive_envelope()
            if envelope is None:
                raise AssertionError(f"closed before a {kind} came")
            if envelope.WhichOneof("body") == kind:
                return envelope


def move(name="box", x=0.0):
    def fill(operation):
        operation.set_pose.object.name = name
        operation.set_pose.pose.position.x = x
    return fill


class Attacks(harness.EndToEnd):
    secured = False

    def setUp(self):
        super().setUp()
        self.credentials = harness.make_credentials(self.folder / "credentials") if self.secured else None
        self.server = self.start_server(credentials=self.credentials)
        self.before = self.server.status()
        self.edits = 0
        self.clients = []

    def tearDown(self):
        """Unharmed: nothing that was not allowed has changed, the servo ticks, another client's edit is felt."""
        after = self.server.status()
        if self.edits == 0:
            self.assertEqual((after["revision"], after["root"]), (self.before["revision"], self.before["root"]))
        self.assertEqual(after["allocations_in_servo"], 0)
        harness.wait_until(lambda: self.server.status()["ticks"] > after["ticks"], 10, "the servo ticks on")
        reply = self.server.ctl("apply", "-", text='operations { remove { object { name: "box" } } }').json()
        self.assertGreater(reply["live_since_tick"], 0)
        self.stop_and_check(self.server)
        super().tearDown()

    def connect(self, **options):
        client = Client(self.server, self.clients, **options)
        self.addCleanup(client.close)
        return client

    def raw(self, tls=None):
        client = harness.WireClient(self.server, tls)
        self.addCleanup(client.close)
        return client

    def refusal(self, client):
        refusals = [said.refusal for said in client.until_closed() if said.WhichOneof("body") == "refusal"]
        self.assertEqual(len(refusals), 1)
        return refusals[0]

    def memory_kB(self):
        if INSTRUMENTED:
            return 0
        status = Path(f"/proc/{self.server.process.pid}/status").read_text()
        return int(next(line.split()[1] for line in status.splitlines() if line.startswith("VmRSS:")))

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.server.process.pid}/fd"))
