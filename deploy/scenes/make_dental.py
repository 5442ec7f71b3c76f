#!/usr/bin/env python3
"""Makes molar.obj, gum.obj or explorer.obj, which dental.scene shows: the model of a molar with four cusps and fissures between
them, its neck at z = 0, twice as large as life, 22 mm wide; its gum; and a bent probe with a ball of 1 mm at its tip,
12 mm below its origin. Formulas, no scans. Metres.

usage: make_dental.py molar|gum|explorer > FILE
"""
import sys
from math import cos, exp, hypot, pi, sin

MODEL = 2  # times life; below, all but the explorer is in life's millimetres
HALF_X_MM, HALF_Y_MM, ROOT_MM, TURNS = 5.5, 5.1, 4, 80
# Of the crown's side from below: (part of the way up, part of the width). Nothing overhangs, under which the probe could hook.
SIDE = ((0, 0.90), (0.2, 1), (0.35, 1.02), (0.47, 1.025), (0.58, 1.02), (0.68, 1.005), (0.78, 0.985), (0.86, 0.95),
        (0.92, 0.90), (0.96, 0.84), (0.985, 0.79))
RIM, RINGS = 0.74, 30
# Of the gum, from the inside of the molar over the top down to its foot: (height in mm, part of the molar's width).
GUM = ((-2, 0.4), (0.9, 0.7), (1.1, 0.95), (0.8, 1.06), (0.3, 1.18), (-0.3, 1.33), (-0.9, 1.48), (-1.6, 1.62), (-2.4, 1.72),
       (-ROOT_MM, 1.75), (-ROOT_MM, 0.4))
CUSPS = ((0.42, 0.40, 1.9), (-0.40, 0.42, 1.7), (0.40, -0.42, 1.6), (-0.42, -0.40, 1.5))  # x, y, height in mm
GROOVE, GROOVE_MM = 0.055, 0.75


def outline(a):
    """Of the widest place, seen from above: a rounded rectangle."""
    power = 2.7
    r = (abs(cos(a)) ** power + abs(sin(a)) ** power) ** (-1 / power)
    return r * cos(a), r * sin(a)


def chewing_surface_mm(x, y):
    """Its height above the neck; x and y in half widths."""
    bell = lambda distance, width: exp(-distance * distance / (2 * width * width))
    z = 5.6 - 1.0 * bell(hypot(x, y), 0.30)
    for cx, cy, height in CUSPS:
        z += height * bell(hypot(x - cx, y - cy), 0.19)
    reach = bell(max(0.0, hypot(x, y) - 0.45), 0.10)  # the fissures end before the rim
    along_x = bell(y - 0.06 * sin(7 * x), GROOVE)
    along_y = bell(x - 0.10 - 0.12 * y, GROOVE) if y > 0 else bell(x + 0.12 + 0.10 * y, GROOVE)
    return z - GROOVE_MM * reach * max(along_x, along_y)


def molar():
    rings = []
    for up, width in SIDE:
        ring = []
        for i in range(TURNS):
            x, y = outline(2 * pi * i / TURNS)
            top = chewing_surface_mm(RIM * x, RIM * y)
            ring.append((HALF_X_MM * width * x, HALF_Y_MM * width * y, -ROOT_MM + (top + ROOT_MM) * up))
        rings.append(ring)
    for k in range(RINGS):
        part = RIM * (1 - k / RINGS)
        ring = []
        for i in range(TURNS):
            x, y = (part * c for c in outline(2 * pi * i / TURNS))
            ring.append((HALF_X_MM * x, HALF_Y_MM * y, chewing_surface_mm(x, y)))
        rings.append(ring)
    return model(rings), (0, 0, -MODEL * ROOT_MM), (0, 0, MODEL * chewing_surface_mm(0, 0))


def model(rings):
    return [[tuple(MODEL * c for c in place) for place in ring] for ring in rings]


def gum():
    """A closed ring."""
    rings = []
    for z, width in reversed(GUM):
        rings.append([(HALF_X_MM * width * x, HALF_Y_MM * width * y, z)
                      for x, y in (outline(2 * pi * i / TURNS) for i in range(TURNS))])
    return model(rings), None, None


def explorer():
    """Rings about the middle line, from the tip's ball up to the end of the handle."""
    sides, ball_mm, tip_mm = 14, 0.5, -12 + 0.5
    p = ((0, tip_mm), (8.5, -6.5), (0.5, 2), (0, 12))  # Bezier, x and z in mm
    line = []
    for k in range(6):  # up to where the ball meets the stem
        a = -pi / 2 + (k + 1) * 2.35 / 6
        line.append((ball_mm * cos(a), 0, tip_mm + ball_mm * sin(a), 0))
    for k in range(1, 27):
        t = k / 26
        b = ((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t ** 3)
        d = (-3 * (1 - t) ** 2, 3 * (1 - t) * (1 - 3 * t), 3 * t * (2 - 3 * t), 3 * t * t)
        x, z = (sum(w * c[j] for w, c in zip(b, p)) for j in (0, 1))
        dx, dz = (sum(w * c[j] for w, c in zip(d, p)) for j in (0, 1))
        line.append((0.3 + 0.8 * t ** 1.3, x, z, dx / hypot(dx, dz)))
    line += [(1.15, 0, 18, 0), (1.2, 0, 22, 0), (1.9, 0, 24, 0), (1.9, 0, 30, 0), (1.9, 0, 36, 0), (1.4, 0, 37.5, 0)]
    rings = []
    for radius, x, z, lean in line:
        up = (1 - lean * lean) ** 0.5
        turn = [2 * pi * i / sides for i in range(sides)]
        rings.append([(x + radius * cos(a) * up, radius * sin(a), z - radius * cos(a) * lean) for a in turn])
    return rings, (0, 0, tip_mm - ball_mm), (0, 0, 37.5)


def main():
    makers = {"molar": molar, "gum": gum, "explorer": explorer}
    if len(sys.argv) != 2 or sys.argv[1] not in makers:
        sys.exit(__doc__)
    rings, below, above = makers[sys.argv[1]]()
    is_ring = below is None
    ends = [] if is_ring else [below, above]
    count = len(rings[0])
    print("# Made by make_dental.py.")
    for x, y, z in (*ends, *(place for ring in rings for place in ring)):
        print(f"v {x / 1000:.6f} {y / 1000:.6f} {z / 1000:.6f}")
    at = lambda ring, i: 1 + len(ends) + ring % len(rings) * count + i % count
    for i in range(count):
        for k in range(len(rings) if is_ring else len(rings) - 1):
            print(f"f {at(k, i)} {at(k, i + 1)} {at(k + 1, i + 1)} {at(k + 1, i)}")
        if not is_ring:
            print(f"f 1 {at(0, i + 1)} {at(0, i)}")
            print(f"f 2 {at(len(rings) - 1, i)} {at(len(rings) - 1, i + 1)}")


if __name__ == "__main__":
    main()
