#!/usr/bin/env python3
"""Makes peg.obj or hole.obj, which peg.scene shows: a hexagonal peg 11.6 mm wide with a handle, whose origin is 10 mm above
its lower end, and a block 25 mm high with a hole 12 mm wide, which stands on z = 0. Metres.

usage: make_peg.py peg|hole > FILE
"""
import sys
from math import cos, pi, sin, sqrt

SIDES, HOLE_M, CLEARANCE_M = 6, 0.012, 0.0002  # across the flats; on each side
CORNER = 2 / sqrt(3) / 2                       # of a width across the flats, from the axis


def peg():
    """(width across the flats, height) from below."""
    width = HOLE_M - 2 * CLEARANCE_M
    return [(width - 0.003, -0.010), (width, -0.0085), (width, 0.022), (0.022, 0.024), (0.022, 0.032)]


def hole():
    return [(HOLE_M + 0.003, 0.025), (HOLE_M, 0.0235), (HOLE_M, 0), (0.05, 0), (0.05, 0.0235), (0.047, 0.025)]


def main():
    if sys.argv[1:] not in (["peg"], ["hole"]):
        sys.exit(__doc__)
    is_peg = sys.argv[1] == "peg"
    line = peg() if is_peg else hole()
    print("# Made by make_peg.py.")
    for width, z in line:
        for i in range(SIDES):
            a = 2 * pi * i / SIDES
            print(f"v {width * CORNER * cos(a):.6f} {width * CORNER * sin(a):.6f} {z:.6f}")
    at = lambda ring, i: 1 + ring % len(line) * SIDES + i % SIDES
    for ring in range(len(line) - 1 if is_peg else len(line)):
        for i in range(SIDES):
            print(f"f {at(ring, i)} {at(ring, i + 1)} {at(ring + 1, i + 1)} {at(ring + 1, i)}")
    if is_peg:
        print("f", *(at(0, SIDES - 1 - i) for i in range(SIDES)))
        print("f", *(at(len(line) - 1, i) for i in range(SIDES)))


if __name__ == "__main__":
    main()
