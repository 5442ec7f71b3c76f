"""Methods of rendering in Python for haptic_eval --method 'python3 FILE.py'. README.md has the protocol."""

import os
import struct
import sys
import time

MOVING_BODIES, OPEN_MESHES, EDITS, FRICTION, SHADING = 1, 2, 4, 8, 16
TOUCHING, SLIDING, PUT_OUTSIDE = 1, 2, 4

HELLO, LOAD, PLACE, TICK, REFUSAL = range(1, 6)


class Refused(Exception):
    """load() raises it, with a word, where the scene cannot be rendered."""


class Body:
    """vertices: [(x, y, z)] in m; triangles: [(a, b, c)]; closed; stiffness_N_per_m; static_friction, dynamic_friction; crease_rad;
    pose: ((w, x, y, z), (x, y, z))."""


def _pose(numbers):
    return tuple(numbers[:4]), tuple(numbers[4:7])


def _scene(message):
    count, _, *hip = struct.unpack_from("<II3d", message)
    bodies, at = [], 32 + 104 * count
    for i in range(count):
        body = Body()
        vertices, triangles, closed, _, *numbers = struct.unpack_from("<4I11d", message, 32 + 104 * i)
        body.closed = closed == 1
        body.stiffness_N_per_m, body.static_friction, body.dynamic_friction, body.crease_rad = numbers[:4]
        body.pose = _pose(numbers[4:])
        body.vertices = list(struct.iter_unpack("<3f", message[at:at + 12 * vertices]))
        at += 12 * vertices
        body.triangles = list(struct.iter_unpack("<3I", message[at:at + 12 * triangles]))
        at += 12 * triangles
        bodies.append(body)
    return bodies, tuple(hip)


def serve(method, name, version, abilities):
    """Until haptic_eval ends. `method` has
    load(bodies, hip),
    place(hip), and
    tick(poses, hip), which returns (flags, force, ihip), each of the last two three floats.
    """
    source, sink = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what is printed

    def answer(kind, message=b""):
        sink.write(struct.pack("<II", kind, len(message)) + message)
        sink.flush()

    while head := source.read(8):
        kind, size = struct.unpack("<II", head)
        message = source.read(size)
        if kind == HELLO:
            answer(HELLO, struct.pack("<II", 1, abilities) + f"{name}\n{version}".encode())
        elif kind == LOAD:
            try:
                method.load(*_scene(message))
                answer(LOAD)
            except Refused as why:
                answer(REFUSAL, str(why).encode()[:4096])
        elif kind == PLACE:
            method.place(struct.unpack("<3d", message))
            answer(PLACE)
        elif kind == TICK:
            hip, *rest = struct.unpack("<3d", message[:24]), *struct.iter_unpack("<7d", message[24:])
            begin = time.perf_counter_ns()
            flags, force, ihip = method.tick([_pose(numbers) for numbers in rest], hip)
            taken = time.perf_counter_ns() - begin
            answer(TICK, struct.pack("<10d2I", *force, *ihip, 0, 0, 0, taken, flags, 0))
