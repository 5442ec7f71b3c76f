#!/usr/bin/env python3
"""Makes forceps.obj, which forceps.scene shows: two jaws 50 mm long, closed, 0.1 mm on each side of z = 0, that taper from the
hinge at the origin to their tips along x. Metres.

usage: make_forceps.py > FILE
"""
GAP_M = 1e-4
# x, half of the width, thickness; from the hinge to the tip.
SECTIONS = (0.002, 0.005, 0.006), (0.030, 0.004, 0.004), (0.048, 0.003, 0.002), (0.050, 0.0025, 0.0015)


def main():
    print("# Made by make_forceps.py.")
    for side in (1, -1):
        for x, half, thick in SECTIONS:
            for y, z in ((-half, GAP_M), (half, GAP_M), (half, GAP_M + thick), (-half, GAP_M + thick)):
                print(f"v {x:.4f} {side * y:.4f} {side * z:.4f}")
    for jaw in range(2):
        at = lambda section, corner: 1 + 4 * (jaw * len(SECTIONS) + section) + corner % 4
        for section in range(len(SECTIONS) - 1):
            for corner in range(4):
                print(f"f {at(section, corner)} {at(section, corner + 1)} {at(section + 1, corner + 1)} {at(section + 1, corner)}")
        print("f", *(at(0, 3 - corner) for corner in range(4)))
        print("f", *(at(len(SECTIONS) - 1, corner) for corner in range(4)))


if __name__ == "__main__":
    main()
