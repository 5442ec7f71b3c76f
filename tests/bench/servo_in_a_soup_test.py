"""usage: servo_in_a_soup_test.py BIN DEMO_SCENE: two short blocks give both sides' figures; no fault comes up."""

import json
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

SCENE = sys.argv.pop()
BIN = Path(sys.argv.pop())


@unittest.skipUnless(shutil.which("cyclictest"), "cyclictest is missing")
class ServoInASoup(unittest.TestCase):
    def test_compares_the_server_with_cyclictest_and_has_no_fault(self):
        run = subprocess.run([sys.executable, "-B", Path(__file__).with_name("servo_in_a_soup.py"), BIN, SCENE, "--triangles",
                              "5000", "--blocks", "2", "--seconds", "3"], capture_output=True, text=True, timeout=110)
        result = json.loads(run.stdout)
        self.assertEqual((result["server_faults"], result["server_allocations"]), (0, 0))
        self.assertGreater(result["server_contact_ticks"], 0)
        self.assertAlmostEqual(result["server_ticks"] + result["server_missed"], 6000, delta=600)
        self.assertGreater(result["cyclictest_wake_ups"], 5000)


if __name__ == "__main__":
    unittest.main()
