"""A client of haptic_server for scripts, over the protocol at the top of envelope.proto.

    with Client("127.0.0.1:7654") as client:
        client.apply('operations { set_material { object { name: "torus" } material { stiffness_N_per_m: 900 } } }')

It mirrors the scene's records and checks every revision's root hash by a computation of its own (meshes it does not
fetch: records name them by hash). It reconnects for ever; an edit under way is sent again under its old number, and the
server applies it once. SI units, server's world frame. Every method may be called from any thread.
"""
import collections
import contextlib
import os
import random
import re
import select
import socket
import ssl
import struct
import threading
import time

from google.protobuf import text_format
from google.protobuf.message import DecodeError

from haptic_assets import UploadQueue, UploadRefused  # noqa: F401
from haptic_edits import Conflict, EditQueue, Rejected, StateLost  # noqa: F401  (callers catch them)
from haptic_scene import OutOfStep, Scene
from haptics.v1 import envelope_pb2, scene_pb2, telemetry_pb2

PROTOCOL_VERSION = 1
MAX_FRAME_BYTES = 1 << 20
MAX_KEPT_SAMPLES = 100_000
HEARTBEAT_S = 1.0
SILENCE_S = 3.0           # dead after this long without a byte
RECONNECT_S = (0.05, 0.6)
REFUSED_RECONNECT_S = 5.0  # a person has to change something first


class Refused(Exception):
    """The server turned this client away, or there is none: what to change."""


class ConnectionLost(Exception):
    pass


class Client:
    def __init__(self, address="127.0.0.1:7654", name="python", credentials=None, telemetry_hz=0.0):
        """`credentials`: the file that `hapticctl credentials` made for clients. `telemetry_hz`: for samples()."""
        host, port = address.rsplit(":", 1)
        self._server = host.strip("[]"), int(port)
        self._name, self._telemetry_hz, self._credentials = name, telemetry_hz, credentials
        self._session = int.from_bytes(os.urandom(8), "little") or 1
        self._changed = threading.Condition()  # guards everything below that callers see
        self._edits = EditQueue()
        self._uploads = UploadQueue()
        self._samples = collections.deque(maxlen=MAX_KEPT_SAMPLES)
        self._bodies = {}  # by object id
        self._scene = Scene()
        self._live = self._closing = False
        self._trouble = "not connected yet"
        self._refused = False
        self.connections = self.resyncs = 0
        self._wake_receiver, self._wake_sender = socket.socketpair()
        self._wake_sender.setblocking(False)
        self._thread = threading.Thread(target=self._run, name="haptic client", daemon=True)
        self._thread.start()

    def __enter__(self):
        try:
            self.wait_live()
        except Refused:
            self.close()
            raise
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        self._wake()
        self._thread.join()
        self._wake_receiver.close()
        self._wake_sender.close()

    def wait_live(self, timeout_s=10.0):
        """Until the scene is mirrored."""
        with self._changed:
            if not self._changed.wait_for(lambda: self._live or self._refused, timeout_s) or self._refused:
                raise Refused(self._trouble)

    def objects(self):
        """{name: ObjectState} as of the newest revision here."""
        with self._changed:
            return {state.name: state for state in self._scene.states()}

    def bodies(self):
        """{name: BodyPose} of the objects that move, as far as samples have told of them: each tells of some."""
        with self._changed:
            return {state.name: self._bodies[state.id] for state in self._scene.states()
                    if state.HasField("motion") and state.id in self._bodies}

    def gave_most(self, sample):
        """Of the objects that the hand touched, (name, feature, joules) of what gave it most energy; None where nothing
        gave any. The feature is "contact", "shading", "friction", "texture", "motion" or "edit"."""
        source = next((energy for energy in sample.energy if energy.object), None)
        if source is None:
            return None
        names = {state.id: name for name, state in self.objects().items()}
        feature = telemetry_pb2.Feature.Name(source.feature).removeprefix("FEATURE_").lower()
        return names.get(source.object, f"object {source.object}"), feature, source.energy_J

    def revision_and_root(self):
        """Root in hexadecimal digits, computed here."""
        with self._changed:
            return self._scene.revision, self._scene.root.hex()

    def submit(self, transaction):
        """Queues a Transaction, or its text format; sent when connected."""
        if isinstance(transaction, str):
            transaction = text_format.Parse(transaction, scene_pb2.Transaction())
        with self._changed:
            edit = self._edits.add(transaction, self._scene.epoch)
        self._wake()
        return edit

    def apply(self, transaction, timeout_s=30.0):
        """Waits until it is felt: (Accepted, first tick). Raises Conflict, Rejected, TimeoutError."""
        edit = self.submit(transaction)
        return edit.result(timeout_s), edit.live_since_tick(timeout_s)

    def upload(self, kind, data, timeout_s=60.0):
        """Sends an asset, as upload(haptic_assets.FIELD, haptic_assets.field(rows)), and waits until the server holds it,
        for edits of this client: its hash. Raises UploadRefused, TimeoutError."""
        with self._changed:
            upload = self._uploads.add(kind, data)
        self._wake()
        return upload.held.result(timeout_s)

    def samples(self, seconds=None):
        """Telemetry as it comes, oldest first. Ticks that the server did not send are missing: latest wins."""
        end = None if seconds is None else time.monotonic() + seconds
        while True:
            with self._changed:
                left = None if end is None else end - time.monotonic()
                if left is not None and left <= 0:
                    return
                self._changed.wait_for(lambda: self._samples or self._closing, left)
                ready = list(self._samples)
                self._samples.clear()
                if self._closing:
                    return
            yield from ready

    # ---- the client's thread ----

    def _run(self):
        while not self._closing:
            try:
                with contextlib.closing(self._connect()) as connection:
                    self._speak(connection)
            except (OSError, ConnectionLost, DecodeError) as error:
                self._lost(str(error) or type(error).__name__)
            pause_s = REFUSED_RECONNECT_S if self._refused else random.uniform(*RECONNECT_S)
            with self._changed:
                self._changed.wait_for(lambda: self._closing, pause_s)

    def _connect(self):
        connection = socket.create_connection(self._server, timeout=SILENCE_S)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if not self._credentials:
            return connection
        context = ssl.create_default_context(cafile=self._credentials)
        return context.wrap_socket(connection, server_hostname="haptic_server")

    def _lost(self, why):
        with self._changed:
            self._live = False
            if not self._refused:
                self._trouble = why
            self._edits.connection_lost()
            self._uploads.connection_lost()
            self._changed.notify_all()

    def _token(self):
        if not self._credentials:
            return b""
        with open(self._credentials, encoding="ascii") as file:
            return bytes.fromhex(re.search(r"^token: ([0-9a-f]{64})$", file.read(), re.MULTILINE)[1])

    def _speak(self, connection):
        self._messages, self._snapshot, self._phase, self._tick = 0, None, "hello", 0
        hello = envelope_pb2.Hello(session=self._session, client_name=self._name, token=self._token())
        if self._scene.epoch:
            hello.epoch, hello.revision, hello.root = self._scene.epoch, self._scene.revision, self._scene.root
        self._send(connection, hello=hello)
        buffer = bytearray()
        heard = beaten = time.monotonic()
        while not self._closing:
            pending = isinstance(connection, ssl.SSLSocket) and connection.pending()
            ready = select.select([connection, self._wake_receiver], [], [], 0 if pending else 0.1)[0]
            if self._wake_receiver in ready:
                self._wake_receiver.recv(4096)
            now = time.monotonic()
            if pending or connection in ready:
                data = connection.recv(1 << 16)
                if not data:
                    raise ConnectionLost("the server closed the connection")
                heard = now
                buffer += data
                for envelope in frames(buffer):
                    self._take(connection, envelope)
            elif now - heard > SILENCE_S:
                raise ConnectionLost("the server has been silent for 3 s")
            if self._phase != "hello" and now - beaten >= HEARTBEAT_S:
                beaten = now
                self._send(connection, heartbeat=envelope_pb2.Heartbeat(
                    epoch=self._scene.epoch, revision=self._scene.revision, root=self._scene.root))
            self._send_edits(connection)

    def _take(self, connection, envelope):
        body = envelope.WhichOneof("body")
        if self._phase == "hello" and body not in ("welcome", "refusal"):
            raise ConnectionLost("the server spoke before its welcome")
        handler = getattr(self, f"_take_{body}", None)
        if not handler:
            return
        with self._changed:
            try:
                handler(getattr(envelope, body))
            except OutOfStep as error:
                self.resyncs += 1
                self._scene = Scene()
                raise ConnectionLost(f"out of step, asking for a snapshot: {error}") from error
            self._changed.notify_all()
        if self._phase == "syncing" and self._live:
            self._phase = "live"
            self._send(connection, subscribe=envelope_pb2.Subscribe(rate_hz=self._telemetry_hz))

    def _take_refusal(self, refusal):
        self._refused = self._phase == "hello"
        self._trouble = f"refused by the server: {Rejected(refusal.field, refusal.reason)}"
        raise ConnectionLost(self._trouble)

    def _take_welcome(self, welcome):
        self._phase, self._refused = "syncing", False
        self.connections += 1
        if welcome.epoch != self._scene.epoch:
            self._bodies.clear()
            self._edits.state_lost()
        self._welcome = welcome
        self._live = welcome.resumed

    def _take_snapshot_begin(self, _):
        self._snapshot = []

    def _take_snapshot_objects(self, objects):
        self._snapshot += objects.object

    def _take_snapshot_end(self, end):
        self._scene = Scene.from_snapshot(self._welcome.epoch, end, self._snapshot)
        self._live = True

    def _take_commit(self, commit):
        self._scene.apply(commit)

    def _take_heartbeat(self, heartbeat):
        self._edits.adopted(heartbeat.adopted_revision, heartbeat.adoption_tick)
        if heartbeat.revision == self._scene.revision and heartbeat.root != self._scene.root:
            raise OutOfStep(f"heartbeat's root at revision {heartbeat.revision}")

    def _take_telemetry(self, sample):
        if sample.tick > self._tick:
            self._tick = sample.tick
            self._samples.append(sample)
            self._bodies.update({body.object: body for body in sample.body})

    def _take_edit_reply(self, reply):
        self._edits.replied(reply)

    def _take_asset_upload_reply(self, reply):
        self._uploads.replied(reply)

    def _take_edit_live(self, live):
        self._edits.live(live)

    def _send_edits(self, connection):
        if self._phase == "hello":
            return
        with self._changed:
            requests = self._edits.take_unsent()
            chunks = self._uploads.take_unsent()
        for request in requests:
            self._send(connection, edit_request=request)
        for chunk in chunks:
            self._send(connection, asset_upload=chunk)

    def _send(self, connection, **body):
        self._messages += 1
        data = envelope_pb2.Envelope(protocol_version=PROTOCOL_VERSION, message_id=self._messages,
                                     **body).SerializeToString()
        connection.sendall(struct.pack("<I", len(data)) + data)

    def _wake(self):
        with contextlib.suppress(OSError):  # enough wake-ups are waiting, or the client is closed
            self._wake_sender.send(b"\0")


def frames(buffer):
    """The whole envelopes at the buffer's beginning, which are taken from it."""
    while len(buffer) >= 4:
        size = struct.unpack_from("<I", buffer)[0]
        if size > MAX_FRAME_BYTES:
            raise ConnectionLost(f"a frame of {size} bytes")
        if len(buffer) < 4 + size:
            return
        envelope = envelope_pb2.Envelope.FromString(bytes(buffer[4:4 + size]))
        del buffer[:4 + size]
        yield envelope
