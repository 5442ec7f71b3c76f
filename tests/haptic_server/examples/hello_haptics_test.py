"""The example prints what its physics is: no force before the sphere is reached, then stiffness times depth.

usage: hello_haptics_test.py HELLO_HAPTICS [-v]
"""
import math
import re
import subprocess
import sys
import unittest

STIFFNESS_N_PER_MM, DAMPING_NS_PER_MM, RADIUS_MM, SPEED_MM_PER_S = 0.5, 0.5e-3, 50, 20
FACET_TILT = math.tan(math.radians(90 / 32 / 2))  # of the polygons around the pole: the sphere has 32 along 90 degrees
ROUNDED = 0.005
NUMBER = r"(-?\d+\.\d+)"
LINE = re.compile(rf"t = {NUMBER} s: hand at z = {NUMBER} mm, depth {NUMBER} mm, "
                  rf"force \({NUMBER}, {NUMBER}, {NUMBER}\) N")


class HelloHaptics(unittest.TestCase):
    def setUp(self):
        done = subprocess.run([PROGRAM], capture_output=True, text=True, check=True)
        self.rows = [tuple(map(float, LINE.fullmatch(line).groups())) for line in done.stdout.splitlines()]

    def test_the_hand_goes_into_the_sphere_and_rests_there(self):
        self.assertEqual([row[0] for row in self.rows], [round(0.1 * i, 1) for i in range(11)])
        self.assertEqual([row[1] for row in self.rows], [55, 53, 51, 49, 47] + 6 * [45])

    def test_depth_is_the_distance_to_the_surface(self):
        for _, z, depth, *_ in self.rows:
            self.assertAlmostEqual(depth, max(0, RADIUS_MM - z), delta=0.05)

    def test_force_is_stiffness_times_depth_and_damping_times_speed(self):
        for t, z, depth, x, y, force in self.rows:
            damping = DAMPING_NS_PER_MM * SPEED_MM_PER_S if 0 < depth < 5 else 0
            self.assertAlmostEqual(force, STIFFNESS_N_PER_MM * depth + damping, delta=0.01, msg=f"at {t} s")
            self.assertLessEqual(max(abs(x), abs(y)), FACET_TILT * force + ROUNDED, msg=f"at {t} s")
        self.assertGreater(self.rows[-1][5], 2)


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
