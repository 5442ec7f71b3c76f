"""The Python client against servers whose sequences of messages are damaged, out of order, torn, or of a newer version.

  PYTHONPATH=build/release/python /usr/bin/python3 tests/fuzz/python_client_fuzz.py [--minutes N] [--seed N] [--only SEED]

Each case has a seed, by which `--only` runs it again. Whatever the server says: no thread ends by an exception, every wait
ends, what exceptions say is fit for a terminal, the client is in step with an honest server afterwards, and its memory
stays bounded.
"""
import argparse
import gc
import os
import random
import resource
import struct
import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "graphics_client/script/python"))
import haptic_assets  # noqa: E402
import haptic_client  # noqa: E402
from haptic_text import UNSAFE  # noqa: E402
from haptics.v1 import envelope_pb2, scene_pb2, telemetry_pb2  # noqa: E402
from scripted_server import ScriptedServer, an_object, framed, greeting, root_of, say, snapshot, welcome  # noqa: E402

SOON_S = 30.0  # a wait that lasts longer has not ended
MOST_GROWTH_MB = 96
FLOOD = 30  # samples that are 4 MB each in memory
haptic_client.RECONNECT_S, haptic_client.REFUSED_RECONNECT_S = (0.001, 0.005), 0.005


class Finding(Exception):
    pass


def require(holds, what):
    if not holds:
        raise Finding(what)


# ---- what a server says ----

def some_object(draw, number):
    state = an_object(number)
    if draw.random() < 0.4:
        state.texture.law = draw.choice((1, 2, 77))
        field = draw.choice(("noise", "cellular", "grain", "mapped", "fourier", "layers"))
        getattr(state.texture.field, field).SetInParent()
        if field == "layers":
            state.texture.field.layers.layer.add(weight=2).field.grain.seed = 7
    if draw.random() < 0.4:
        state.motion.mass_kg = 0.1
    if draw.random() < 0.3:
        state.friction.mu_static = 0.5
        state.friction.per_vertex.asset = bytes(32)
        if draw.random() < 0.5:
            state.friction.dynamic_field.noise.octaves = 2
    if draw.random() < 0.3:
        state.stiffness_over.per_vertex.asset = bytes(32)
        state.softness_over.variation = 0.5
    if draw.random() < 0.3:
        state.deformation.softness.radius_m = 0.01
    if draw.random() < 0.2:
        state = newer(state)
    return state


def newer(state):
    return scene_pb2.ObjectState.FromString(state.SerializeToString() + b"\xa2\x06\x03new")


def some_sample(draw, tick):
    sample = telemetry_pb2.Telemetry(tick=tick, object=draw.randrange(4), fault=draw.choice((0, 5, 99)))
    for _ in range(draw.randrange(3)):
        sample.energy.add(object=draw.randrange(4), feature=draw.choice((1, 99)), energy_J=0.1)
        sample.body.add(object=draw.randrange(6)).pose.rotation.w = 1
        sample.dent.add(object=draw.randrange(4), centre=[0, 0, 1])
    return say(telemetry=sample)


def some_reply(draw):
    reply = envelope_pb2.EditReply(client_seq=draw.randrange(1, 5))
    outcome = draw.choice(("accepted", "conflict", "rejected", "put off", "none"))
    if outcome == "accepted":
        reply.accepted.revision = draw.randrange(5)
        reply.accepted.report.append("\x1b[31m")
    elif outcome == "conflict":
        reply.conflict.reason = "\x1b]0;x\x07"
        reply.conflict.current.add().name = "\u202e"
    elif outcome != "none":
        reply.rejected.field, reply.rejected.reason = "a\x9b", "b\n"
        reply.rejected.retry_after_ms = 20 if outcome == "put off" else 0
    return say(edit_reply=reply)


def story(draw):
    """Envelopes of a server that a client could meet, whole."""
    objects = [some_object(draw, number) for number in range(1, draw.randrange(1, 5))]
    revision = draw.randrange(3)
    said = [*greeting(objects, revision)]
    for _ in range(draw.randrange(12)):
        kind = draw.randrange(10)
        if kind < 3:
            before = root_of(revision, objects)
            revision += 1
            removed = [objects.pop(draw.randrange(len(objects))).id] if objects and kind == 0 else []
            put = [some_object(draw, draw.randrange(1, 6))]
            objects = [state for state in objects if state.id != put[0].id] + put
            said.append(say(commit=scene_pb2.Commit(revision=revision, prev_root=before, put=put, removed=removed,
                                                    root=root_of(revision, objects))))
        elif kind == 3:
            said.append(say(heartbeat=envelope_pb2.Heartbeat(epoch=5, revision=revision, root=root_of(revision, objects),
                                                             adopted_revision=draw.randrange(5), adoption_tick=1)))
        elif kind < 6:
            said.append(some_sample(draw, len(said)))
        elif kind < 8:
            said.append(some_reply(draw))
        elif kind == 8:
            said.append(say(edit_live=envelope_pb2.EditLive(client_seq=draw.randrange(4), tick=1)))
        else:
            said.append(say(asset_upload_reply=envelope_pb2.AssetUploadReply(
                hash=draw.choice((ASSET_HASH, b"", b"x")), accepted=draw.random() < 0.5, reason="\x1b",
                retry_after_ms=draw.choice((0, 20)))))
    return said


def damaged_message(draw, envelope):
    """Bytes of the message, changed in place."""
    data = bytearray(envelope.SerializeToString())
    for _ in range(draw.choice((1, 1, 2, 8))):
        if data:
            data[draw.randrange(len(data))] ^= 1 << draw.randrange(8)
    return struct.pack("<I", len(data)) + data


def unknown_added(draw, envelope):
    data = envelope.SerializeToString() + draw.choice((b"\xa2\x06\x03new", b"\xa0\x06\x7f", b"\xf2\x07\x05other"))
    return struct.pack("<I", len(data)) + data


def hostile(draw):
    """Bytes of a story that something has happened to."""
    said = story(draw)
    for _ in range(draw.randrange(3)):
        at, other = draw.randrange(len(said)), draw.randrange(len(said))
        kind = draw.randrange(5)
        if kind == 0:
            del said[at]
            said = said or [say()]
        elif kind == 1:
            said.insert(other, said[at])
        elif kind == 2:
            said[at], said[other] = said[other], said[at]
        elif kind == 3:
            said.insert(at, draw.choice((
                say(), welcome(resumed=True), *snapshot(), say(hello=envelope_pb2.Hello()),
                say(refusal=envelope_pb2.Refusal(field="\x1b[2J", reason="\u202e\r\n")),
                say(snapshot_begin=envelope_pb2.SnapshotBegin(object_count=draw.choice((0, 3, 1 << 63)))))))
        else:
            said = said[at:] or said
    change = draw.randrange(6)
    data = b"".join(damaged_message(draw, one) if change == 0 and draw.random() < 0.3 else
                    unknown_added(draw, one) if change == 1 and draw.random() < 0.3 else framed(one) for one in said)
    if change == 2:
        data = data[:draw.randrange(len(data) + 1)]
    elif change == 3:
        at = draw.randrange(len(data))
        data = data[:at] + draw.randbytes(draw.randrange(9)) + data[at + draw.randrange(9):]
    return data


# ---- a case ----

ASSET = b"an asset"
ASSET_HASH = haptic_assets.Upload(haptic_assets.FIELD, ASSET).hash


class Waits:
    """Threads that wait without a timeout; each is to end with a result or an exception that a caller expects."""
    EXPECTED = (haptic_client.Closed, haptic_client.Refused, haptic_client.Rejected, haptic_client.Conflict,
                haptic_client.StateLost, haptic_client.UploadRefused)

    def __init__(self, *waits):
        self.unexpected = []
        self.threads = [threading.Thread(target=self.run, args=(wait,), daemon=True) for wait in waits]
        for thread in self.threads:
            thread.start()

    def run(self, wait):
        try:
            wait()
        except self.EXPECTED as error:
            if UNSAFE.search(str(error)):
                self.unexpected.append(f"raw text: {error!r}")
        except BaseException as error:
            self.unexpected.append(repr(error))

    def join(self):
        for thread in self.threads:
            thread.join(SOON_S)
            require(not thread.is_alive(), "a wait does not end")
        require(not self.unexpected, f"a wait ends with {self.unexpected}")


def until(condition, what):
    end = time.monotonic() + SOON_S
    while not condition():
        require(time.monotonic() < end, what())
        time.sleep(0.001)


def run_case(seed):
    draw = random.Random(seed)
    with ScriptedServer(hostile(draw)) as server:
        client = haptic_client.Client(server.address, telemetry_hz=100)
        try:
            edits = [client.submit(scene_pb2.Transaction()) for _ in range(3)]
            waits = Waits(*(edit.live_since_tick for edit in edits), lambda: client.wait_live(None),
                          lambda: client.upload(haptic_assets.FIELD, ASSET, None),
                          lambda: [client.gave_most(sample) for sample in client.samples()])
            until(lambda: server.connections > draw.randrange(1, 3) or client._live,
                  lambda: "the client neither reconnects nor is live")
            client.objects(), client.bodies(), client.revision_and_root(), client.unknown_objects()
            require(not UNSAFE.search(client._trouble), f"raw text: {client._trouble!r}")
            objects = [an_object(number) for number in range(1, 3)] + [newer(an_object(3))]
            server.script = framed(*greeting(objects, 7))
            server.hang_up()
            until(lambda: client.revision_and_root() == (7, root_of(7, objects).hex()) and client._live,
                  lambda: f"the client is not in step with an honest server: {client._trouble}")
            require(list(client.objects().values()) == objects, "the client holds other objects than the server")
            require(client.unknown_objects() == ["object_3"], "the client does not say what it does not know")
        finally:
            closing = Waits(client.close)
            closing.join()
        waits.join()
        require(not client._thread.is_alive(), "the client's thread lives on")


def varint(number):
    return bytes([number & 0x7f | 0x80]) + varint(number >> 7) if number > 0x7f else bytes([number])


def flood():
    """More telemetry than anybody takes, in samples that are large in memory."""
    dents = telemetry_pb2.Telemetry(dent=[telemetry_pb2.Dent()] * 60_000).SerializeToString()
    frame = say(telemetry=telemetry_pb2.Telemetry(tick=100)).SerializeToString()
    head = frame[:frame.index(b"\xa2\x01")]  # up to the field `telemetry`
    samples = []
    for tick in range(1, FLOOD + 1):
        body = telemetry_pb2.Telemetry(tick=tick).SerializeToString() + dents
        data = head + b"\xa2\x01" + varint(len(body)) + body
        samples.append(struct.pack("<I", len(data)) + data)
    with ScriptedServer(framed(*greeting()) + b"".join(samples)) as server:
        client = haptic_client.Client(server.address)
        until(lambda: client._tick == FLOOD, lambda: "the samples do not arrive")
        client.close()


def resident_MB():
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() >> 20


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=0.12)
    parser.add_argument("--seed", type=int, default=1, help="of the first case; those after it count up")
    parser.add_argument("--only", type=int, metavar="SEED", help="this case alone")
    arguments = parser.parse_args()
    died = []
    threading.excepthook = lambda given: died.append(given.exc_value)
    seed, end = arguments.seed, time.monotonic() + 60 * arguments.minutes
    before = resident_MB()
    try:
        if arguments.only is not None:
            seed, end = arguments.only, 0
        else:
            flood()
        haptic_client.SILENCE_S = 0.3  # a torn message is waited for no longer
        while True:
            run_case(seed)
            require(not died, f"a thread ended with {died and died[0]!r}")
            grown = resident_MB() - before
            require(grown < MOST_GROWTH_MB, f"the memory has grown by {grown} MB")
            if time.monotonic() >= end:
                break
            seed += 1
    except Finding as finding:
        print(f"case {seed}: {finding}")
        os._exit(1)  # whatever threads there still are
    print(f"{seed - arguments.seed + 1} cases, memory grew by {grown} MB")


if __name__ == "__main__":
    main()
