"""Moves an object on a circle, a new pose 60 times a second, which pushes the hand, and puts it back where it was.

    animate_object.py --radius 0.02 --period 4 --seconds 10 torus

Poses are absolute, so a slow server or network costs smoothness only: while too many poses are unanswered, the next ones
are left out.
"""
import argparse
import collections
import math
import sys
import time

from haptic_client import Client, Refused, Rejected
from haptic_text import printable
from haptics.v1 import scene_pb2

MAX_UNANSWERED = 8


def pose_edit(number, x, y, z, kinematic=True):
    transaction = scene_pb2.Transaction()
    set_pose = transaction.operations.add().set_pose
    set_pose.object.id = number
    set_pose.kinematic = kinematic  # a motion, not an edit of the scene
    set_pose.pose.position.x, set_pose.pose.position.y, set_pose.pose.position.z = x, y, z
    return transaction


def animate(client, state, arguments):
    """(poses accepted, poses left out)."""
    start = state.pose.position
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
        angle = 2 * math.pi * frame / arguments.rate / arguments.period
        unanswered.append(client.submit(pose_edit(state.id, start.x + arguments.radius * (math.cos(angle) - 1),
                                                  start.y + arguments.radius * math.sin(angle), start.z)))
    for edit in unanswered:
        edit.result(30)
        accepted += 1
    return accepted, left_out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--connect", default="127.0.0.1:7654", metavar="HOST:PORT")
    parser.add_argument("--credentials", metavar="FILE")
    parser.add_argument("--rate", type=float, default=60, metavar="HZ")
    parser.add_argument("--radius", type=float, default=0.02, metavar="M")
    parser.add_argument("--period", type=float, default=4, metavar="S", help="of one turn")
    parser.add_argument("--seconds", type=float, default=10, metavar="S")
    parser.add_argument("object", metavar="NAME")
    arguments = parser.parse_args()
    try:
        with Client(arguments.connect, "animate_object", arguments.credentials) as client:
            state = client.objects().get(arguments.object)
            if state is None:
                sys.exit(f'animate_object: there is no object "{arguments.object}"; '
                         f'there are: {printable(", ".join(sorted(client.objects())))}')
            try:
                accepted, left_out = animate(client, state, arguments)
                print(f"{accepted} poses in {arguments.seconds:g} s, {left_out} left out")
            finally:
                position = state.pose.position
                client.apply(pose_edit(state.id, position.x, position.y, position.z, kinematic=False))
    except (Refused, Rejected) as error:
        sys.exit(f"animate_object: {error}")
    except KeyboardInterrupt:
        pass  # the object is back in its place


if __name__ == "__main__":
    main()
