"""usage: servo_of_bodies_test.py BIN SCENES: one short round gives the server's figures; the servo stays off the heap."""

import json
import subprocess
import sys
import unittest
from pathlib import Path

SCENES = sys.argv.pop()
BIN = sys.argv.pop()


class ServoOfBodies(unittest.TestCase):
    def test_measures_the_ticks_of_bodies_that_meet(self):
        run = subprocess.run([sys.executable, "-B", Path(__file__).with_name("servo_of_bodies.py"), BIN, SCENES, "--bodies",
                              "32", "--seconds", "2", "--rounds", "1"], capture_output=True, text=True, timeout=60)
        (only,) = json.loads(run.stdout)["rounds"]
        self.assertEqual(only["allocations"], 0)
        self.assertEqual(sum(only["bodies_at_the_end"].values()), 32)
        self.assertNotIn("not finite", only["bodies_at_the_end"])
        self.assertAlmostEqual(only["ticks"] + only["missed"], 2000, delta=200)
        self.assertGreaterEqual(only["tick_p99_us"], only["tick_p50_us"])


if __name__ == "__main__":
    unittest.main()
