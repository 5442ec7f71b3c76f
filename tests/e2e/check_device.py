"""check-device on an arm with one of many defects, behind a plug-in and in real time: it says which; and passes a sound one.

HAPTICS_DEFECTIVE_PLUGIN: the plug-in. HAPTICS_ROUNDS: how often each defect is drawn anew; without it some of them once.
"""
import concurrent.futures
import os
import re
import subprocess
import unittest

import harness

ROUNDS = int(os.environ.get("HAPTICS_ROUNDS", "0"))
READING = {"x_stands_still": "x never changed", "all_stand_still": "z never changed",
           "values_at_60_hz": r"y has a new value only with every \d+th position",
           "positions_at_60_hz": "(new positions are 1|within 30 s it is not ready: the device fell silent)",
           "positions_at_500_hz": "new positions are 2", "spikes": "(positions jump|a fault in)", "jump": "(positions jump|a fault in)",
           "noise": "z is noisy at rest", "old_positions": "positions are fresh enough"}
PUSHING = {"reversed_z": r"\+z pushes the other way", "x_for_y": r"\+x pushes along y", "no_force": r"\+x does not move the hand",
           "late_force": "forces are in time", "no_watchdog": "the force stays while this program stands still",
           "slow_watchdog": "the device takes its force away by itself", "stiffer_said_than_borne": "a spring is steady",
           "force_ends_slowly": "the force ends within 30 ms"}


class CheckDevice(harness.EndToEnd):
    def check(self, defect, seed):
        """What it says, and its exit status."""
        report = self.folder / f"{defect}_{seed}.txt"
        force = [] if defect in READING else ["--force", "1"]
        done = subprocess.run([harness.BIN / "haptic_server", "check-device",
                               f"plugin:{os.environ['HAPTICS_DEFECTIVE_PLUGIN']}:{defect},{seed},1.3", "--seconds", "1.8",
                               "--report", report, *force], input="\n", capture_output=True, text=True, timeout=harness.STOP_TIMEOUT_S)
        for line in done.stdout.splitlines()[:-1]:
            self.assertIn(line.split("press Enter: ")[-1], report.read_text())
        self.assertNotIn(str(harness.Path(os.environ["HAPTICS_DEFECTIVE_PLUGIN"]).parent), report.read_text())
        return done.stdout, done.returncode

    def judge(self, defects, seeds):
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            runs = {(defect, seed): pool.submit(self.check, defect, seed) for seed in seeds for defect in defects}
        for (defect, seed), run in runs.items():
            said, code = run.result()
            with self.subTest(defect=defect, seed=seed):
                if defect == "none":
                    self.assertEqual(code, 0, said)
                else:
                    self.assertEqual(code, 1, said)
                    self.assertRegex(said, "BAD   " + {**READING, **PUSHING}[defect])

    @unittest.skipIf(ROUNDS, "all of them are drawn")
    def test_it_passes_a_sound_device_and_measures_the_watchdog_of_the_device_alone(self):
        self.judge(["none", "no_watchdog", "spikes"], [1])

    @unittest.skipUnless(ROUNDS, "takes minutes")
    def test_it_passes_a_sound_device_and_fails_each_defect(self):
        self.judge(["none", *READING, *PUSHING], range(1, ROUNDS + 1))

    def test_a_report_that_cannot_be_written_is_refused(self):
        done = subprocess.run([harness.BIN / "haptic_server", "check-device",
                               f"plugin:{os.environ['HAPTICS_DEFECTIVE_PLUGIN']}:none", "--report", "/nowhere/report"],
                              capture_output=True, text=True, timeout=harness.STOP_TIMEOUT_S)
        self.assertEqual(done.returncode, 1)
        self.assertIn("--report /nowhere/report: cannot be written", done.stderr)


if __name__ == "__main__":
    unittest.main()
