"""Twists an object about its z axis to and fro by free-form deformation: moves the control points of a lattice around it, and
takes the lattice away at the end.

    twist_bar.py --turns 0.5 --period 6 --seconds 20 bar     (deploy/scenes/ffd_bar.scene)

Lattices are absolute, so a slow server or network costs smoothness only: while too many are unanswered, the next ones are
left out.
"""
import argparse
import collections
import math
import sys
import time

from haptic_client import Client, Refused, Rejected
from haptic_text import printable
from haptics.v1 import scene_pb2

POINTS = (2, 2, 8)  # along x, y and z: the twist bends the edges most
MAX_UNANSWERED = 4


def lattice_edit(number, size=None, control=None):
    transaction = scene_pb2.Transaction()
    edit = transaction.operations.add().set_deformation
    edit.object.id = number
    edit.deformation.lattice.SetInParent()
    if control:
        lattice = edit.deformation.lattice
        lattice.low_m.x, lattice.low_m.y, lattice.low_m.z = (-side / 2 for side in size)
        lattice.size_m.x, lattice.size_m.y, lattice.size_m.z = size
        lattice.points_x, lattice.points_y, lattice.points_z = POINTS
        lattice.control_m.extend(control)
    return transaction


def twisted(size, angle):
    """Control points, x fastest; the top is turned by the angle (rad), the bottom stays."""
    control = []
    for k in range(POINTS[2]):
        part = k / (POINTS[2] - 1)
        c, s = math.cos(angle * part), math.sin(angle * part)
        for j in range(POINTS[1]):
            for i in range(POINTS[0]):
                x = size[0] * (i / (POINTS[0] - 1) - 0.5)
                y = size[1] * (j / (POINTS[1] - 1) - 0.5)
                control += [c * x - s * y, s * x + c * y, size[2] * (part - 0.5)]
    return control


def twist(client, state, arguments):
    """(lattices accepted, lattices left out)."""
    unanswered, accepted, left_out = collections.deque(), 0, 0
    began = time.monotonic()
    for frame in range(int(arguments.seconds * arguments.rate)):
        time.sleep(max(0.0, began + frame / arguments.rate - time.monotonic()))
        while unanswered and unanswered[0].reply.done():
            unanswered.popleft().result()
            accepted += 1
        if len(unanswered) >= MAX_UNANSWERED:
            left_out += 1
            continue
        angle = 2 * math.pi * arguments.turns * math.sin(2 * math.pi * frame / arguments.rate / arguments.period)
        unanswered.append(client.submit(lattice_edit(state.id, arguments.size, twisted(arguments.size, angle))))
    for edit in unanswered:
        edit.result(30)
        accepted += 1
    return accepted, left_out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--connect", default="127.0.0.1:7654", metavar="HOST:PORT")
    parser.add_argument("--credentials", metavar="FILE")
    parser.add_argument("--rate", type=float, default=30, metavar="HZ")
    parser.add_argument("--turns", type=float, default=0.5, metavar="N", help="of the top, each way")
    parser.add_argument("--period", type=float, default=6, metavar="S")
    parser.add_argument("--seconds", type=float, default=20, metavar="S")
    parser.add_argument("--size", type=float, nargs=3, default=(0.04, 0.04, 0.16), metavar="M",
                        help="of the object's box, which its origin is the middle of")
    parser.add_argument("--keep", action="store_true", help="leave it as it is at the end")
    parser.add_argument("object", metavar="NAME")
    arguments = parser.parse_args()
    try:
        with Client(arguments.connect, "twist_bar", arguments.credentials) as client:
            state = client.objects().get(arguments.object)
            if state is None:
                sys.exit(f'twist_bar: there is no object "{arguments.object}"; '
                         f'there are: {printable(", ".join(sorted(client.objects())))}')
            try:
                accepted, left_out = twist(client, state, arguments)
                print(f"{accepted} lattices in {arguments.seconds:g} s, {left_out} left out")
            finally:
                if not arguments.keep:
                    client.apply(lattice_edit(state.id))
    except (Refused, Rejected) as error:
        sys.exit(f"twist_bar: {error}")
    except KeyboardInterrupt:
        pass  # the lattice has been taken away


if __name__ == "__main__":
    main()
