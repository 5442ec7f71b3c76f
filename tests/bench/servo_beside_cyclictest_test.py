"""usage: servo_beside_cyclictest_test.py BIN DEMO_SCENE: two short blocks give both sides' figures and a verdict."""

import json
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

SCENE = sys.argv.pop()
BIN = Path(sys.argv.pop())

from servo_beside_cyclictest import poisson_p  # noqa: E402


class PoissonP(unittest.TestCase):
    def test_tells_rates_apart_that_differ_and_no_others(self):
        self.assertEqual(poisson_p(0, 1000, 0, 1000), 1)
        self.assertGreater(poisson_p(10, 1000, 12, 1000), 0.5)
        self.assertGreater(poisson_p(20, 2000, 10, 1000), 0.9)
        self.assertLess(poisson_p(30, 1000, 5, 1000), 0.001)
        self.assertLess(poisson_p(5, 1000, 30, 1000), 0.001)
        # of two coins that fall the same way n times: 2 / 2^n
        self.assertAlmostEqual(poisson_p(8, 1, 0, 1), 2 / 2 ** 8)


@unittest.skipUnless(shutil.which("cyclictest") and shutil.which("stress-ng"), "cyclictest or stress-ng is missing")
class ServoBesideCyclictest(unittest.TestCase):
    def compared(self, *options):
        run = subprocess.run([sys.executable, "-B", Path(__file__).with_name("servo_beside_cyclictest.py"), BIN, SCENE,
                              "--blocks", "2", "--seconds", "2", *options], capture_output=True, text=True, timeout=110)
        result = json.loads(run.stdout)
        self.assertEqual((result["server_faults"], result["server_allocations"]), (0, 0))
        self.assertGreater(result["server_contact_ticks"], 0)
        for side, ran in (("server", "ticks"), ("cyclictest", "wake_ups")):
            self.assertEqual(len(result[f"{side}_late_in_each_block"]), 2)
            self.assertAlmostEqual(result[f"{side}_{ran}"] + result[f"{side}_missed"], 4000, delta=400)
            self.assertLessEqual(result[f"{side}_late"], result[f"{side}_missed"])

    def test_while_both_are_attacked(self):
        self.compared()

    def test_in_a_soup(self):
        self.compared("--soup", "5000")


if __name__ == "__main__":
    unittest.main()
