"""What attacks have in common: a client that says what it likes, and a server that must be unharmed afterwards."""
import os
from pathlib import Path

import harness

INSTRUMENTED = "HAPTICS_INSTRUMENTED" in os.environ  # such a program keeps what it has freed: its size says nothing


class Client(harness.WireClient):
    """Welcomed, with answers found by their kind."""

    def __init__(self, server, tls=None, token=b""):
        super().__init__(server, tls)
        self.send_envelope(harness.hello_envelope("attacker", token=token))
        self.welcome = self.answer("welcome").welcome

    def say(self, fill):
        from haptics.v1 import envelope_pb2
        envelope = envelope_pb2.Envelope(protocol_version=1)
        fill(envelope)
        self.send_envelope(envelope)

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
        while True:
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
        client = Client(self.server, **options)
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
