"""A server that says only what a test has it say, and what it may say: whole messages of the protocol."""
import contextlib
import hashlib
import socket
import struct
import threading

from haptic_scene import Record
from haptics.v1 import envelope_pb2, scene_pb2

EPOCH = 5
NOTHING = hashlib.sha256(struct.pack("<Q", 0)).digest()  # root of an empty scene at revision 0


def framed(*envelopes):
    data = b""
    for envelope in envelopes:
        body = envelope.SerializeToString()
        data += struct.pack("<I", len(body)) + body
    return data


def say(**body):
    return envelope_pb2.Envelope(protocol_version=1, **body)


def welcome(revision=0, root=NOTHING, resumed=False, epoch=EPOCH):
    return say(welcome=envelope_pb2.Welcome(epoch=epoch, revision=revision, root=root, resumed=resumed, server_name="scripted"))


def snapshot(objects=(), revision=0, root=None):
    """`root`: to be claimed; that of the objects."""
    return [say(snapshot_begin=envelope_pb2.SnapshotBegin(revision=revision, object_count=len(objects))),
            *(say(snapshot_objects=envelope_pb2.SnapshotObjects(object=[state])) for state in objects),
            say(snapshot_end=envelope_pb2.SnapshotEnd(revision=revision, root=root or root_of(revision, objects)))]


def greeting(objects=(), revision=0):
    """What a client needs to be live."""
    return [welcome(revision, root_of(revision, objects)), *snapshot(objects, revision)]


def an_object(number, **more):
    state = scene_pb2.ObjectState(id=number, name=f"object_{number}", revision=1, mesh=bytes([number % 256]) * 32,
                                  stiffness_N_per_m=500, **more)
    state.pose.rotation.w = 1
    state.pose.position.SetInParent()
    state.color.SetInParent()
    return state


def root_of(revision, objects):
    """Of what an object holds that nobody knows, bytes of it stand for its hash."""
    digest = hashlib.sha256(struct.pack("<Q", revision))
    for state in sorted(objects, key=lambda state: state.id):
        own = Record.of(state).hash or hashlib.sha256(state.SerializeToString()).digest()
        digest.update(struct.pack("<QQ", state.id, state.revision) + own)
    return digest.digest()


class ScriptedServer:
    """Each client that comes gets `script` (bytes); to what it says, `answer(envelope)` may give bytes back."""

    def __init__(self, script=b"", answer=lambda envelope: b""):
        self.script, self.answer = script, answer
        self.connections, self.heard = 0, []
        self._client = None
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self.hang_up()

    def hang_up(self):
        if self._client:
            with contextlib.suppress(OSError):
                self._client.shutdown(socket.SHUT_RDWR)

    def send(self, data):
        """To the client that came last."""
        with contextlib.suppress(OSError):
            self._client.sendall(data)

    def _accept(self):
        while True:
            try:
                client = self._listener.accept()[0]
            except OSError:
                return
            self.connections += 1
            self._client = client
            threading.Thread(target=self._serve, args=(client,), daemon=True).start()

    def _serve(self, client):
        buffer = b""
        with client, contextlib.suppress(OSError):
            client.sendall(self.script)
            while data := client.recv(1 << 16):
                buffer += data
                while len(buffer) >= 4 and len(buffer) >= 4 + (size := struct.unpack_from("<I", buffer)[0]):
                    envelope = envelope_pb2.Envelope.FromString(buffer[4:4 + size])
                    buffer = buffer[4 + size:]
                    self.heard.append(envelope)
                    client.sendall(self.answer(envelope))
