"""Leads the simulated hand with a tool in it: presses a peg on the block beside a hole, slides it there tilted, sets it upright
and pushes it in, turns and tilts it in the hole, and pulls it out. A line for each part says how deep the peg is at its end,
and the largest force and torque on the hand.

    haptic_server --device-preset sigma.7 --scene deploy/scenes/peg.scene
    insert_peg.py                                   once
    insert_peg.py --times 3 --turn 20               three times, turned by 20 degrees to and fro

The device has to sense how it is turned; one that gives torque too is given the peg's.
"""
import argparse
import math
import sys

from haptic_client import Client, Closed, NotLeading, Refused
from haptic_hand import xyz
from haptic_text import printable

BESIDE_M, ABOVE_M = 0.014, 0.02   # the hole's middle; the block's top
TILT_DEG, TILT_IN_DEG = 8, 6      # on the way to the hole; in it
DOWN_SPEED = 0.03                 # m/s, into the hole and out of it
FORCE_N = 2


def turned(degrees, axis):
    half = math.radians(degrees) / 2
    return (math.cos(half), *(math.sin(half) * a for a in axis))


UPRIGHT, X, Y, Z = (1, 0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)


class Peg:
    """`top`: the middle of the hole at the block's top. `below_m`: the peg's lower end, below its origin."""

    def __init__(self, client, hand, name, top, below_m, in_m):
        self._client, self._hand, self._name = client, hand, name
        self._top, self._below_m, self._in_m = top, below_m, in_m

    def insert(self, turn_deg):
        """The parts in turn: (what, samples)."""
        hand = self._hand
        yield "above", [*hand.move_to(self._at(BESIDE_M, ABOVE_M)), *hand.turn(turned(TILT_DEG, Y), 0.6)]
        yield "beside the hole", hand.press(self._at(BESIDE_M, 0), Z, FORCE_N, 0.5)
        yield "to the hole", hand.stroke([self._at(BESIDE_M, 0), self._at(0, 0)], Z, FORCE_N, 0.02)
        yield "upright", hand.turn(UPRIGHT, 0.8)
        yield "in", [*hand.move_to(self._at(0, -self._in_m), DOWN_SPEED), *hand.turn(UPRIGHT, 0.3)]  # the peg comes after
        for angle in (turn_deg, -turn_deg):
            yield f"turned by {angle:g} degrees", hand.turn(turned(angle, Z), 1.2)
        yield "tilted", hand.turn(turned(TILT_IN_DEG, X), 1.2)
        yield "back", hand.turn(UPRIGHT, 0.8)
        yield "out", hand.move_to(self._at(0, ABOVE_M), DOWN_SPEED)

    def depth_m(self):
        """Of its lower end, below the block's top."""
        body = self._client.bodies().get(self._name)
        return self._top[2] - body.pose.position.z + self._below_m if body else math.nan

    def _at(self, aside, height):
        """Where the peg's origin is when its lower end is there."""
        x, y, z = self._top
        return x + aside, y, z + self._below_m + height


def largest(vectors):
    return max((math.hypot(*xyz(vector)) for vector in vectors), default=0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--connect", default="127.0.0.1:7654", metavar="HOST:PORT")
    parser.add_argument("--credentials", metavar="FILE")
    parser.add_argument("--times", type=int, default=1, metavar="N")
    parser.add_argument("--turn", type=float, default=12, metavar="DEG", help="in the hole, each way (12)")
    parser.add_argument("--hole", type=float, nargs=3, default=(0, 0, 0.025), metavar="M", help="its middle, at the top")
    parser.add_argument("--below", type=float, default=0.01, metavar="M", help="the peg's end, below its origin (0.01)")
    parser.add_argument("--depth", type=float, default=0.018, metavar="M", help="to which it is put in (0.018)")
    parser.add_argument("peg", nargs="?", default="peg", metavar="NAME")
    arguments = parser.parse_args()
    try:
        with Client(arguments.connect, "insert_peg", arguments.credentials, 200) as client, client.hand() as hand:
            client.wait_live()
            if arguments.peg not in client.objects():
                sys.exit(f'insert_peg: there is no object "{arguments.peg}"; '
                         f'there are: {printable(", ".join(sorted(client.objects())))}')
            peg = Peg(client, hand, arguments.peg, arguments.hole, arguments.below, arguments.depth)
            for _ in range(arguments.times):
                for what, felt in peg.insert(arguments.turn):
                    print(f"{what}: {1e3 * peg.depth_m():.1f} mm deep  force {largest(s.force.written for s in felt):.2f} N  "
                          f"torque {1e3 * largest(s.tool.written_Nm for s in felt):.1f} mNm", flush=True)
    except (Refused, NotLeading, Closed) as error:
        sys.exit(f"insert_peg: {error}")
    except KeyboardInterrupt:
        pass  # the hand is let go of


if __name__ == "__main__":
    main()
