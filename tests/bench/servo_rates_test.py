"""usage: servo_rates_test.py HAPTIC_SERVER: one short round at one rate gives both sides' figures."""

import json
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import servo_rates

SERVER = sys.argv.pop()
SCENE = 'operations { add { name: "ball" mesh { sphere { radius_m: 0.05 } } } }'


@unittest.skipUnless(shutil.which("cyclictest"), "cyclictest (rt-tests) is not installed")
class ServoRates(unittest.TestCase):
    def test_compares_the_server_with_cyclictest(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = Path(folder) / "ball.scene"
            scene.write_text(SCENE)
            run = subprocess.run(
                [sys.executable, "-B", Path(__file__).with_name("servo_rates.py"), SERVER, scene, "--assets", folder,
                 "--rates", "2000", "--rounds", "1", "--seconds", "1"],
                check=True, capture_output=True, text=True, timeout=60)
        (row,) = json.loads(run.stdout)["rates"]
        self.assertEqual(row["rate_hz"], 2000)
        # What was not missed was run: about a second of it on either side.
        self.assertAlmostEqual(row["server_ticks"] + row["server_missed"], 2000, delta=200)
        self.assertAlmostEqual(row["cyclictest_wake_ups"] + row["cyclictest_missed"], 2000, delta=200)
        self.assertGreaterEqual(row["server_misses_more_p"], 0.4)  # of one round: one of two signs, or both
        self.assertGreater(row["server_p50_us"], 0)
        self.assertGreater(row["cyclictest_p50_us"], 0)

    def test_tells_chance_from_missing_more(self):
        self.assertGreater(servo_rates.misses_more_p([90, 0, 60, 2], [0, 80, 1, 70]), 0.4)
        self.assertLess(servo_rates.misses_more_p([9, 8, 7, 9, 8, 7, 9, 9], [1, 0, 2, 1, 0, 2, 1, 1]), 0.01)
        self.assertEqual(servo_rates.misses_more_p([0, 0], [0, 0]), 1)


if __name__ == "__main__":
    unittest.main()
