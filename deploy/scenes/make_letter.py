#!/usr/bin/env python3
"""Makes trace_letter.scene: the letter S on a sheet of wood, with a guide along it. Metres.

usage: make_letter.py > trace_letter.scene
"""
from math import cos, pi, sin

RADIUS_M, POINTS = 0.015, 24  # of each of the two arcs
SHEET_M = 0.01                # thick; the letter is on its upper side


def letter():
    """From the upper end on: three quarters of a circle to the left, and three quarters of one to the right."""
    upper = [(cos(a), 1 + sin(a)) for a in (pi * (0.25 + 1.25 * i / POINTS) for i in range(POINTS))]
    lower = [(cos(a), -1 + sin(a)) for a in (pi * (0.5 - 1.25 * i / POINTS) for i in range(POINTS + 1))]
    return [(RADIUS_M * x, RADIUS_M * y, SHEET_M / 2) for x, y in upper + lower]


def main():
    numbers = [", ".join(f"{value:.5f}" for value in point) for point in letter()]
    lines = ",\n".join("        " + ", ".join(numbers[i:i + 4]) for i in range(0, len(numbers), 4))
    print(f"""\
# Trace the letter: a guide leads the hand along an S on a wooden sheet, from its upper end to its lower one, and not back. The
# sheet sounds like wood where it is tapped. Metres; z up; seen from -y. Made by make_letter.py. trace_letter.py
# (graphics_client/script/python/examples) lets the guidance fade as the hand gets better.

operations {{
  add {{
    name: "sheet"
    mesh {{ box {{ size_m {{ x: 0.12 y: 0.12 z: {SHEET_M} }} }} }}
    pose {{ position {{ z: {-SHEET_M / 2} }} }}
    material {{
      stiffness_N_per_m: 800
      color {{ red: 0.72 green: 0.53 blue: 0.33 }}
      friction {{ mu_static: 0.3 mu_dynamic: 0.2 }}
      tap_Ns_per_m: 7.5
      tap_Hz: 30
      tap_decay_per_s: 80
    }}
    effects {{
      kind: EFFECT_KIND_GUIDE
      path_m: [
{lines}
      ]
      stiffness_N_per_m: 200
      damping_Ns_per_m: 1
      limit_N: 1.5
      reach_m: 0.008
      release_m: 0.015
      fade_m: 0.004
    }}
  }}
}}""")


if __name__ == "__main__":
    main()
