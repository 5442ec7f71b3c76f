#!/usr/bin/env python3
"""Makes bowl.obj, on which marbles.scene stands: a bowl of 12 cm, open upwards, its foot at z = 0. Metres.

usage: make_bowl.py > bowl.obj
"""
from math import cos, pi, sin

INNER_M, WALL_M, HALF_ANGLE, TURNS, STEPS = 0.08, 0.005, 0.85, 64, 14


def profile():
    """(distance from the axis, height), from the inner side's middle over the rim to the outer side's middle."""
    angles = [HALF_ANGLE * i / STEPS for i in range(STEPS + 1)]
    rim, middle = HALF_ANGLE, INNER_M + WALL_M / 2
    inner = [(INNER_M, a) for a in angles]
    outer = [(INNER_M + WALL_M, a) for a in reversed(angles)]
    places = [(r * sin(a), -r * cos(a)) for r, a in inner]
    for k in range(1, 6):  # half round the rim
        turn = pi * k / 6
        r, up = middle - WALL_M / 2 * cos(turn), WALL_M / 2 * sin(turn)
        places.append((r * sin(rim) + up * cos(rim), -r * cos(rim) + up * sin(rim)))
    places += [(r * sin(a), -r * cos(a)) for r, a in outer]
    return [(x, z + INNER_M + WALL_M) for x, z in places]


def main():
    line = profile()
    rings = line[1:-1]
    print("# Made by make_bowl.py.")
    for x, z in (line[0], line[-1]):
        print(f"v {x:.6f} 0 {z:.6f}")
    for x, z in rings:
        for i in range(TURNS):
            a = 2 * pi * i / TURNS
            print(f"v {x * cos(a):.6f} {x * sin(a):.6f} {z:.6f}")
    at = lambda ring, i: 3 + ring * TURNS + i % TURNS
    for i in range(TURNS):
        print(f"f 1 {at(0, i)} {at(0, i + 1)}")
        for k in range(len(rings) - 1):
            print(f"f {at(k, i)} {at(k + 1, i)} {at(k + 1, i + 1)}")
            print(f"f {at(k, i)} {at(k + 1, i + 1)} {at(k, i + 1)}")
        print(f"f 2 {at(len(rings) - 1, i + 1)} {at(len(rings) - 1, i)}")


if __name__ == "__main__":
    main()
