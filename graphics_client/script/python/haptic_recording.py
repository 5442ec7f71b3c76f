"""Reads recordings of haptic_server (--record FILE, hapticctl dump, faults): what the servo was given and the force that it
gave back, tick by tick. What it felt in between (contact, penetration, components of the force) is made again by
haptic_eval replay FILE --telemetry OUT, and read by telemetry() here.
"""
import hashlib
import struct
from collections import namedtuple

from google.protobuf.message import DecodeError
from haptics.v1 import recording_pb2, telemetry_pb2

HEAD = b"haptics recording 1\n"
# recording.proto
TICK = struct.Struct("<3Q7Bx2I6d")
HANDLE = struct.Struct("<7dQ")

# Lengths in m, forces in N, the server's world frame and monotonic clock. Velocity (m/s), applied force and gripper (rad) are None
# where the device does not measure them.
Tick = namedtuple("Tick", "tick time_ns scene device_state fault device_fault homed homed_axes buttons age_us position force "
                  "clutched velocity applied_force gripper grasps marks")


class Damaged(Exception):
    """The file is not what was written, from some byte on."""


def parsed(kind, payload, file, end):
    try:
        return kind.FromString(payload)
    except DecodeError:
        raise Damaged(f"{file} holds no {kind.DESCRIPTOR.name} before byte {end}") from None


def parts(file):
    """The recording's parts (recording.proto), as far as the file goes: one that was cut off ends with its last whole
    part."""
    with open(file, "rb") as stream:
        if stream.read(len(HEAD)) != HEAD:
            raise Damaged(f"{file} is no recording of this version")
        chain = hashlib.sha256(HEAD).digest()
        while True:
            head = stream.read(8)
            payload = stream.read(struct.unpack("<I", head[:4])[0]) if len(head) == 8 else b""
            link = stream.read(32)
            if len(link) < 32:
                return
            chain = hashlib.sha256(chain + head + payload).digest()
            if chain != link:
                raise Damaged(f"{file} is damaged before byte {stream.tell()}")
            yield parsed(recording_pb2.RecordingPart, payload, file, stream.tell())


def ticks(file):
    """A Tick for each tick of the recording."""
    for part in parts(file):
        if len(part.ticks.ticks) % TICK.size:
            raise Damaged(f"{file} holds a part of a tick: {len(part.ticks.ticks)} bytes, of {TICK.size} each")
        count = len(part.ticks.ticks) // TICK.size
        if len(part.ticks.handles) not in (0, count * HANDLE.size):
            raise Damaged(f"{file} holds handles of another number of ticks: {len(part.ticks.handles)} bytes, of {count} ticks")
        handles = HANDLE.iter_unpack(part.ticks.handles or bytes(count * HANDLE.size))
        for values, handle in zip(TICK.iter_unpack(part.ticks.ticks), handles):
            *front, buttons, actions, age_us, more_buttons = values[:12]
            measured = handle[7]
            yield Tick(*front, more_buttons << 8 | buttons, age_us, values[12:15], values[15:18], actions & 1,
                       handle[:3] if measured & 1 else None, handle[3:6] if measured & 2 else None,
                       handle[6] if measured & 4 else None, bool(actions & 2), bool(actions & 4))


def telemetry(file):
    """The haptics.v1.Telemetry messages of a file that haptic_eval replay --telemetry wrote."""
    with open(file, "rb") as stream:
        data = stream.read()
    at = 0
    while at < len(data):
        length = shift = 0
        while True:
            if at == len(data) or shift > 28:
                raise Damaged(f"{file} holds no length of a message before byte {at}")
            byte = data[at]
            at += 1
            length |= (byte & 0x7f) << shift
            shift += 7
            if byte < 0x80:
                break
        if length > len(data) - at:
            raise Damaged(f"{file} ends within a message, at byte {len(data)}")
        at += length
        yield parsed(telemetry_pb2.Telemetry, data[at - length:at], file, at)
