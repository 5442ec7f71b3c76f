"""usage: servo_under_attack_test.py BIN: two short blocks give both sides' figures and a verdict."""

import json
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

BIN = Path(sys.argv.pop())
SCENE = 'operations { add { name: "ball" mesh { sphere { radius_m: 0.05 } } } }'
sys.path.insert(0, str(Path(__file__).parent))

import servo_under_attack  # noqa: E402


class PoissonP(unittest.TestCase):
    def test_tells_rates_apart_that_differ_and_no_others(self):
        self.assertEqual(servo_under_attack.poisson_p(0, 1000, 0, 1000), 1)
        self.assertGreater(servo_under_attack.poisson_p(10, 1000, 12, 1000), 0.5)
        self.assertGreater(servo_under_attack.poisson_p(20, 2000, 10, 1000), 0.9)
        self.assertLess(servo_under_attack.poisson_p(30, 1000, 5, 1000), 0.001)
        self.assertLess(servo_under_attack.poisson_p(5, 1000, 30, 1000), 0.001)
        # of two coins that fall the same way n times: 2 / 2^n
        self.assertAlmostEqual(servo_under_attack.poisson_p(8, 1, 0, 1), 2 / 2 ** 8)


@unittest.skipUnless(shutil.which("cyclictest") and shutil.which("stress-ng"), "cyclictest or stress-ng is missing")
class ServoUnderAttack(unittest.TestCase):
    def test_compares_the_server_with_cyclictest_while_both_are_attacked(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = Path(folder) / "ball.scene"
            scene.write_text(SCENE)
            run = subprocess.run(
                [sys.executable, "-B", Path(__file__).with_name("servo_under_attack.py"), BIN, scene, "--assets", folder,
                 "--blocks", "2", "--seconds", "2"],
                capture_output=True, text=True, timeout=110)
        result = json.loads(run.stdout)
        self.assertEqual(result["server_allocations"], 0)
        for side in ("server", "cyclictest"):
            self.assertEqual(len(result[f"{side}_late_in_each_block"]), 2)
            ran = result["server_ticks"] if side == "server" else result["cyclictest_wake_ups"]
            self.assertAlmostEqual(ran + result[f"{side}_missed"], 4000, delta=400)
            self.assertLessEqual(result[f"{side}_late"], result[f"{side}_missed"])


if __name__ == "__main__":
    unittest.main()
