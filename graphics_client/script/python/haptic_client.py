"""A client of haptic_server for scripts, over the protocol at the top of envelope.proto.

    with Client("127.0.0.1:7654") as client:
        client.apply('operations { set_material { object { name: "torus" } material { stiffness_N_per_m: 900 } } }')

It mirrors the scene's records and checks every revision's root hash by a computation of its own (meshes it does not
fetch: records name them by hash). It reconnects for ever; an edit under way is sent again under its old number, and the
server applies it once. SI units, server's world frame. Every method may be called from any thread; what waits in one ends
with Closed when the client is closed.

Of a newer server it keeps what it does not know (unknown_objects()). A server that sends more than this client holds
(haptic_scene.MAX_OBJECTS, MAX_SCENE_BYTES) is left, and the limit named. Exceptions' texts are escaped for a terminal; for
other text of the server, such as names, there is haptic_text.printable().
"""
import collections
import contextlib
import os
import random
import select
import socket
import ssl
import threading
import time

import haptics.scene
from google.protobuf import text_format
from google.protobuf.message import DecodeError

from haptic_assets import UploadQueue, UploadRefused  # noqa: F401
from haptic_connection import (PROTOCOL_VERSION, ConnectionLost, TurnedAway, connect, endpoint, frames, in_words, send_frame,
                               token_in)
from haptic_edits import Closed, Conflict, EditQueue, Rejected, StateLost, awaited  # noqa: F401  (callers catch them)
from haptic_hand import REPEAT_S, Hand, HandLead, NotLeading, xyz  # noqa: F401
from haptic_scene import LimitExceeded, OutOfStep, Record, Scene, check_limits
from haptic_text import printable
from haptics.v1 import envelope_pb2, scene_pb2, telemetry_pb2

MAX_KEPT_SAMPLES, MAX_KEPT_BYTES = 10_000, 16 << 20  # 10 s at 1000 Hz; beyond, the oldest are dropped
HEARTBEAT_S = 1.0
SILENCE_S = 3.0           # dead after this long without a byte
RECONNECT_S = (0.05, 0.6)
REFUSED_RECONNECT_S = 5.0  # a person has to change something first


# After that tick so many were missed by the servo, which slept through them, and so many lost on the way here.
Gap = collections.namedtuple("Gap", "after missed lost")


class Refused(Exception):
    """The server turned this client away, or there is none: what to change."""


def _with_advice(rejected, transaction):
    if isinstance(transaction, haptics.scene.Scene):
        for reference in transaction.references():
            if reference.field == rejected.field and reference.below(transaction.folder) is not None:
                return Rejected(rejected.field, f'{rejected.reason}. "{reference.file}" lies beside the scene, but this client '
                                                "sends no file that has to be imported: apply the scene with hapticctl, or "
                                                "start the server with --assets of that folder")
    return rejected


class Client:
    def __init__(self, address="127.0.0.1:7654", name="python", credentials=None, telemetry_hz=0.0, every_tick=False):
        """`address`: HOST:PORT; raises Refused where it is none. `credentials`: the file that `hapticctl credentials` made for
        clients. `telemetry_hz`: for samples(), of the newest ones; `every_tick`: samples() are of every tick, and gaps says what
        is missing."""
        try:
            self._server = endpoint(address)
        except ValueError as error:
            raise Refused(printable(str(error))) from None
        self._credentials = credentials
        self._session = int.from_bytes(os.urandom(8), "little") or 1
        self._hello = envelope_pb2.Hello(session=self._session, client_name=name)
        self._subscribe = envelope_pb2.Subscribe(rate_hz=0 if every_tick else telemetry_hz, every_tick=every_tick)
        self._changed = threading.Condition()  # guards everything below that callers see
        self._edits = EditQueue(lambda: self._trouble)
        self._uploads = UploadQueue()
        self._samples, self._sample_bytes = collections.deque(), 0  # serialised: their memory is then their size
        self.gaps = []  # of every tick: Gap(after, missed, lost), as samples() came upon them
        self._last = None  # (tick, missed_ticks) of the sample before, of every tick
        self._bodies = {}  # by object id
        self._changed_at = {}  # likewise: revision of the object when its pose came
        self._welcome = None
        self._hands = [HandLead(self._changed, self._wake, lambda: (self._live, self._end, self._trouble), hand,
                                lambda: bool(self._welcome and self._welcome.second_device))
                       for hand in range(2)]
        self._scene = Scene()
        self._epoch = 0  # of the server that was live last
        self._live = self._closing = False
        self._end = None  # why there is no more to wait for
        self._trouble = f"nothing has come from {address}"  # since it was live
        self._refused = False
        self.connections = self.resyncs = self._tick = 0
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
        """Until the scene is mirrored. Raises Refused, which says why it is not."""
        with self._changed:
            self._changed.wait_for(lambda: self._live or self._refused or self._end, timeout_s)
            if not self._live:
                raise Refused(self._end or self._trouble)

    @property
    def device(self):
        """What the server drives, as it says: "Phantom Omni (simulated)"; empty before it was live."""
        with self._changed:
            return self._welcome.device if self._welcome else ""

    def objects(self):
        """{name: ObjectState} as of the newest revision here."""
        with self._changed:
            return {state.name: state for state in self._scene.states()}

    def unknown_objects(self):
        """Names of those that hold what this client does not know: the server is newer. They are kept as they came; while
        there are any, the root is not computed here but the server's word."""
        with self._changed:
            return self._scene.unknown()

    def bodies(self):
        """{name: BodyPose} of the objects that move or are driven, as far as their poses have come: a sample has some."""
        with self._changed:
            return {state.name: self._bodies[state.id] for state in self._scene.states() if state.id in self._bodies}

    def gave_most(self, sample):
        """Of the objects that the hand touched, (name, feature, joules) of what gave it most energy; None where nothing
        gave any. The feature is "contact", "shading", "friction", "texture", "motion" or "edit"; "feature 9" of a newer
        server."""
        source = next((energy for energy in sample.energy if energy.object), None)
        if source is None:
            return None
        names = {state.id: name for name, state in self.objects().items()}
        known = telemetry_pb2.Feature.DESCRIPTOR.values_by_number.get(source.feature)
        feature = known.name.removeprefix("FEATURE_").lower() if known else f"feature {source.feature}"
        return names.get(source.object, f"object {source.object}"), feature, source.energy_J

    def revision_and_root(self):
        """Root in hexadecimal digits, computed here."""
        with self._changed:
            return self._scene.revision, self._scene.root.hex()

    def submit(self, transaction):
        """Queues a Transaction, its text format, or a haptics.scene.Scene; sent when connected. One that is larger than a
        frame, 1 MiB, is answered at once with Rejected."""
        if isinstance(transaction, haptics.scene.Scene):
            transaction = transaction.transaction
        if isinstance(transaction, str):
            transaction = text_format.Parse(transaction, scene_pb2.Transaction())
        with self._changed:
            edit = self._edits.add(transaction, self._scene.epoch)
        self._wake()
        return edit

    def apply(self, transaction, timeout_s=30.0):
        """Waits until it is felt: (Accepted, first tick). Of a Scene, assets in its folder (.mesh, .field and so on) are sent
        before; other files, which have to be imported, are the server's to find: hapticctl apply sends those, too. Raises Conflict, Rejected, StateLost, UploadRefused, Closed,
        TimeoutError, and ValueError for a file's name that leaves the folder."""
        if isinstance(transaction, haptics.scene.Scene):
            transaction = self._with_assets_sent(transaction, timeout_s)
        edit = self.submit(transaction)
        try:
            return edit.result(timeout_s), edit.live_since_tick(timeout_s)
        except Rejected as rejected:
            raise _with_advice(rejected, transaction) from None

    def _with_assets_sent(self, scene, timeout_s):
        sent = haptics.scene.Scene(scene.transaction, scene.folder)
        for reference in list(sent.references()):
            data = reference.asset_below(sent.folder)
            if data is not None:
                reference.message.asset = self.upload(reference.kind, data, timeout_s)
                if isinstance(reference.message, haptics.scene.MeshSource):
                    reference.message.ClearField("keep_crossings")  # which the server takes beside files alone
        return sent

    def upload(self, kind, data, timeout_s=60.0):
        """Sends an asset, as upload(haptic_assets.FIELD, haptic_assets.field(rows)), and waits until the server holds it,
        for edits of this client: its hash. Raises UploadRefused, Closed, TimeoutError."""
        with self._changed:
            upload = self._uploads.add(kind, data)
        self._wake()
        return awaited(upload.held, timeout_s, lambda: self._trouble)

    def samples(self, seconds=None):
        """Telemetry as it comes, oldest first, until the client is closed or the time is over; of 0 s what has come already.
        Ticks that the server did not send, or that nobody took here for some seconds, are missing: latest wins. Of a client with
        every_tick, each that is missing is in gaps."""
        end = None if seconds is None else time.monotonic() + seconds
        left = seconds
        while left is None or left >= 0:
            with self._changed:
                self._changed.wait_for(lambda: self._samples or self._closing or self._end, left)
                ready = list(self._samples)
                self._samples.clear()
                self._sample_bytes = 0
                if self._closing:
                    return
                if self._end:
                    raise Closed(self._end)
            for sample in map(telemetry_pb2.Telemetry.FromString, ready):
                if self._subscribe.every_tick:
                    self._note_gap(sample)
                yield sample
            if end is not None:
                left = end - time.monotonic()

    def _note_gap(self, sample):
        if self._last and sample.tick > self._last[0] + 1:
            between = sample.tick - self._last[0] - 1
            missed = min(between, max(0, sample.missed_ticks - self._last[1]))
            self.gaps.append(Gap(self._last[0], missed, between - missed))
        self._last = sample.tick, sample.missed_ticks

    def hand(self, which=1):
        """The simulated hand 1 or, where the server has two, 2, to be led in a `with` block, with move_to(), press() and
        stroke(): see haptic_hand. Needs telemetry. Raises NotLeading, which says who leads or that there is no hand to lead;
        Closed, TimeoutError."""
        if which not in (1, 2):
            raise ValueError(f"there are hands 1 and 2, no hand {which}")
        if not (self._subscribe.rate_hz or self._subscribe.every_tick):
            raise ValueError("a hand feels by telemetry; give the client telemetry_hz=100 or more")
        return Hand(lambda seconds: list(self.samples(seconds)), self._hands[which - 1])

    def move_workspace(self, which=1, **changes):
        """Moves the workspace of the device of hand 1 or 2 (SetWorkspace in envelope.proto), a real device's or a simulated one's:
        `offset` (x, y, z; m), to which it glides, `scale` (0.1 to 10), `rotation` (w, x, y, z), both about where the hand is, and
        `clutch_buttons` (bits as in device_buttons; 0: none), while one of which is pressed the workspace moves with the hand;
        likewise `grasp_buttons`, by which the hand holds the body that it touches, and `mark_buttons`, which mark the recording;
        at each press of one of `next_tool_buttons` the first hand takes the scene's next tool.
        `bubble` ((x, y, z), radius) is the sphere of the device beyond which the workspace moves outward by itself; radius 0: none.
        What is left out stays as it is. Not answered: samples show what it does, device_clutched, grasped, device_marks. A
        number that is refused ends the connection, and the server says why."""
        if which not in (1, 2):
            raise ValueError(f"there are hands 1 and 2, no hand {which}")
        parts = {"offset": (scene_pb2.Vector3, "xyz"), "rotation": (scene_pb2.Quaternion, "wxyz")}
        if "bubble" in changes:
            centre, radius = changes.pop("bubble")
            changes["bubble"] = envelope_pb2.Bubble(centre=scene_pb2.Vector3(**dict(zip("xyz", centre, strict=True))),
                                                    radius_m=radius)
        values = {name: parts[name][0](**dict(zip(parts[name][1], value, strict=True))) if name in parts else value
                  for name, value in changes.items()}
        self._hands[which - 1].move_workspace(envelope_pb2.SetWorkspace(hand=which - 1, **values))

    def add_wrench(self, force_N, torque_Nm=(0, 0, 0), which=1):
        """Adds a force, and to a device that gives torques a torque (x, y, z; world frame), to what the scene gives hand 1 or 2
        (AddWrench in envelope.proto), a real device's or a simulated one's, from now on: sent again and again until another one
        is given; zero takes it away, as the end of the connection does. It comes and goes at 30 N/s. Not answered: a sample's
        force.added shows it. A number that is refused ends the connection."""
        if which not in (1, 2):
            raise ValueError(f"there are hands 1 and 2, no hand {which}")
        self._hands[which - 1].add_wrench(force_N, torque_Nm)

    # ---- the client's thread ----

    def _run(self):
        end = "the client's thread has failed"
        try:
            while not self._closing:
                try:
                    with contextlib.closing(connect(self._server, self._credentials, SILENCE_S)) as connection:
                        self._speak(connection)
                except Exception as error:  # whatever it is, waits go on and the next connection may do better
                    self._lost(error)
                pause_s = REFUSED_RECONNECT_S if self._refused else random.uniform(*RECONNECT_S)
                with self._changed:
                    self._changed.wait_for(lambda: self._closing, pause_s)
            end = "the client is closed"
        finally:
            self._finish(end)

    def _finish(self, why):
        with self._changed:
            self._live, self._end = False, why
            self._edits.end(Closed(why))
            self._uploads.end(Closed(why))
            self._changed.notify_all()

    def _lost(self, error):
        with self._changed:
            self._live = False
            for hand in self._hands:
                hand.connection_lost()
            if not isinstance(error, (OSError, ConnectionLost, DecodeError)):
                self._scene = Scene()
            self._refused = self._refused or isinstance(error, (LimitExceeded, TurnedAway))
            if not self._refused or isinstance(error, (LimitExceeded, TurnedAway)):
                self._trouble = printable(in_words(error))
            if isinstance(error, DecodeError):
                self._edits.answer_unreadable()
            self._edits.connection_lost()
            self._uploads.connection_lost()
            self._changed.notify_all()

    def _speak(self, connection):
        self._messages, self._snapshot, self._phase, self._tick = 0, None, "hello", 0
        hello = envelope_pb2.Hello(token=token_in(self._credentials))
        hello.MergeFrom(self._hello)
        if self._scene.epoch:
            hello.epoch, hello.revision, hello.root = self._scene.epoch, self._scene.revision, self._scene.root
        self._send(connection, hello=hello)
        buffer = bytearray()
        heard = beaten = time.monotonic()
        while not self._closing:
            pending = isinstance(connection, ssl.SSLSocket) and connection.pending()
            wait_s = 0 if pending else REPEAT_S if any(hand.leader for hand in self._hands) else 0.1
            with self._changed:
                uploads = self._phase != "hello" and self._uploads.sends()
            ready, writable, _ = select.select([connection, self._wake_receiver], [connection] if uploads else [], [], wait_s)
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
            if writable:
                self._send_chunk(connection)

    def _take(self, connection, envelope):
        body = envelope.WhichOneof("body")  # None: of a kind that only a newer server knows
        if self._phase == "hello" and body not in ("welcome", "refusal"):
            raise ConnectionLost("the server spoke before its welcome")
        if body == "welcome" and envelope.protocol_version != PROTOCOL_VERSION:
            raise TurnedAway(f"the server speaks version {envelope.protocol_version}, this client version {PROTOCOL_VERSION}")
        handler = getattr(self, f"_take_{body}", None)
        if not handler:
            return
        with self._changed:
            try:
                handler(getattr(envelope, body))
            except OutOfStep:
                self.resyncs += 1
                raise
            self._changed.notify_all()
        if self._phase == "syncing" and self._live:
            self._phase = "live"
            self._send(connection, subscribe=self._subscribe)

    def _take_refusal(self, refusal):
        why = f"refused by the server: {Rejected(refusal.field, refusal.reason)}"
        if self._phase != "hello":
            raise ConnectionLost(why)
        raise TurnedAway(why)

    def _take_welcome(self, welcome):
        if self._phase != "hello":
            raise ConnectionLost("the server sent a second welcome")
        if not welcome.epoch:
            raise ConnectionLost("the server's epoch is 0")
        if welcome.resumed and welcome.epoch != self._scene.epoch:
            raise ConnectionLost("the server resumes what this client lacks")
        self._phase, self._refused, self._welcome = "syncing", False, welcome
        self._whole = welcome.resumed  # the scene can take commits
        self.connections += 1
        if welcome.epoch != self._epoch:
            self._epoch = welcome.epoch
            self._bodies.clear()
            self._changed_at.clear()
            self._edits.state_lost()
        self._scene_changed()

    def _take_snapshot_begin(self, begin):
        check_limits(begin.object_count, 0)
        self._snapshot = begin, []

    def _take_snapshot_objects(self, objects):
        if not self._snapshot:
            raise ConnectionLost("a snapshot's objects came without its beginning")
        begin, records = self._snapshot
        if len(records) + len(objects.object) > begin.object_count:
            raise OutOfStep("the snapshot has more objects than said")
        records += map(Record.of, objects.object)
        check_limits(len(records), sum(record.size for record in records))

    def _take_snapshot_end(self, end):
        if not self._snapshot:
            raise ConnectionLost("a snapshot ended without its beginning")
        (begin, records), self._snapshot = self._snapshot, None
        if (end.revision, len(records)) != (begin.revision, begin.object_count):
            raise OutOfStep("the snapshot is not the one that was begun")
        self._scene = Scene.from_snapshot(self._welcome.epoch, end, records)
        self._whole = True
        self._scene_changed()

    def _take_commit(self, commit):
        if not self._whole:
            raise ConnectionLost("a commit came before the snapshot that it changes")
        self._scene = self._scene.after(commit)
        self._uploads.committed(commit)
        self._scene_changed()

    def _scene_changed(self):
        """Live once the scene stands at the welcome's revision or beyond."""
        # The pose of a driven object that was edited comes again where it still is driven.
        self._bodies = {number: body for number, body in self._bodies.items()
                        if self._scene.moves(number) or self._scene.changed_at(number) == self._changed_at.get(number)}
        if self._live or not self._whole or self._scene.revision < self._welcome.revision:
            return
        if self._scene.revision == self._welcome.revision and self._scene.root != self._welcome.root:
            raise OutOfStep(f"the welcome's root at revision {self._scene.revision}")
        self._live, self._trouble = True, ""

    def _take_heartbeat(self, heartbeat):
        self._edits.adopted(heartbeat.adopted_revision, heartbeat.adoption_tick)
        if self._live and heartbeat.revision == self._scene.revision and heartbeat.root != self._scene.root:
            raise OutOfStep(f"heartbeat's root at revision {heartbeat.revision}")

    def _take_telemetry(self, sample):
        if sample.tick > self._tick:
            self._tick = sample.tick
            self._hands[0].position = xyz(sample.hip)
            if sample.HasField("second_hand"):
                self._hands[1].position = xyz(sample.second_hand.hip)
            self._keep(sample.SerializeToString())
            for body in sample.body:
                changed_at = self._scene.changed_at(body.object)
                if self._scene.moves(body.object) or (changed_at is not None and sample.scene_revision >= changed_at):
                    self._changed_at[body.object] = changed_at
                    self._bodies[body.object] = own = telemetry_pb2.BodyPose()
                    own.CopyFrom(body)  # without the sample around it

    def _take_telemetry_batch(self, batch):
        if batch.sample and not self._last:  # from here on each is there, or named
            self._last = batch.sample[0].tick - 1, batch.sample[0].missed_ticks
        for sample in batch.sample:
            self._take_telemetry(sample)

    def _keep(self, sample):
        self._samples.append(sample)
        self._sample_bytes += len(sample)
        while len(self._samples) > MAX_KEPT_SAMPLES or self._sample_bytes > MAX_KEPT_BYTES:
            self._sample_bytes -= len(self._samples.popleft())

    def _take_edit_reply(self, reply):
        self._edits.replied(reply)

    def _take_asset_upload_reply(self, reply):
        self._uploads.replied(reply)

    def _take_edit_live(self, live):
        self._edits.live(live)

    def _take_hand_leader(self, leader):
        if leader.hand < len(self._hands):
            self._hands[leader.hand].answered(leader)

    def _send_edits(self, connection):
        if self._phase == "hello":
            return
        with self._changed:
            bodies = [body for hand in self._hands for body in hand.take_unsent()]
            requests = [] if self._uploads.sends_again() else self._edits.take_unsent()
        for body in bodies:
            self._send(connection, **body)
        for request in requests:
            self._send(connection, edit_request=request)

    def _send_chunk(self, connection):
        """One, so that what comes meanwhile is read."""
        with self._changed:
            chunk = self._uploads.take_chunk()
        if chunk:
            self._send(connection, asset_upload=chunk)

    def _send(self, connection, **body):
        self._messages += 1
        send_frame(connection, self._messages, **body)

    def _wake(self):
        with contextlib.suppress(OSError):  # enough wake-ups are waiting, or the client is closed
            self._wake_sender.send(b"\0")
