"""A viewer that is stopped or killed costs the servo nothing, and another is in step within two seconds.

Blocks with the viewer stopped or killed are compared with quiet blocks between them, as Poisson rates: given the sum, the
count in the disturbed blocks is binomial with their share of the time (the conditional test of Przyborowski and Wilenski
1940). What is counted is late wake-ups: the ticks that one of them misses are no independent events (a host that takes the
processor away for 30 ms costs 30 at once). The ticks are printed beside them. A block counts its late wake-ups beyond those
of cyclictest in the same block, since the host takes the processor away in bursts.
"""
import math
import os
import signal
import time
import unittest

import harness

BLOCK_S = 1.5
LOOK_S = 0.02  # Ticks missed between two looks count as one late wake-up.
ROUNDS = int(os.environ.get("HAPTICS_ROUNDS", "4"))  # of quiet, stopped, quiet, killed
IN_STEP_S = 2.0
# A run fails by chance once in a thousand.
SIGNIFICANCE = 0.001


def chance_of_as_many(disturbed, quiet, share):
    """P(X >= disturbed), X binomial of disturbed + quiet trials with probability `share`."""
    total = disturbed + quiet
    logs = [math.lgamma(total + 1) - math.lgamma(k + 1) - math.lgamma(total - k + 1) +
            k * math.log(share) + (total - k) * math.log1p(-share) for k in range(disturbed, total + 1)]
    return min(1.0, math.fsum(map(math.exp, logs)))


class ConditionalTest(unittest.TestCase):
    def test_it_knows_a_higher_rate_from_an_equal_one(self):
        self.assertAlmostEqual(chance_of_as_many(3, 0, 0.5), 0.125)
        self.assertAlmostEqual(chance_of_as_many(0, 5, 0.5), 1.0)
        self.assertGreater(chance_of_as_many(55, 45, 0.5), SIGNIFICANCE)
        self.assertLess(chance_of_as_many(80, 20, 0.5), SIGNIFICANCE)


class ViewerDeath(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.server = self.start_server()
        self.probe = harness.StatusProbe(self.server)
        self.addCleanup(self.probe.close)
        self.display = self.start_display()
        self.time_s = dict.fromkeys(("quiet", "stopped", "killed"), 0.0)
        self.missed = dict.fromkeys(self.time_s, 0)
        self.late = dict.fromkeys(self.time_s, 0)

    def count(self, kind):
        """One block of this kind."""
        late = 0
        with harness.Cyclictest() as others:
            start, before = time.monotonic(), self.probe.status().missed_ticks
            while time.monotonic() < start + BLOCK_S:
                time.sleep(LOOK_S)
                now = self.probe.status().missed_ticks
                late += now > before
                self.missed[kind] += now - before
                before = now
            self.time_s[kind] += time.monotonic() - start
        self.late[kind] += max(0, late - others.late)

    def new_viewer(self):
        status, start = self.probe.status(), time.monotonic()
        viewer = self.start_viewer(self.server.address, self.display)
        viewer.wait_for(status.revision, status.root.hex())
        return viewer, time.monotonic() - start

    def test_the_servo_misses_no_more_ticks_and_a_new_viewer_is_soon_in_step(self):
        viewer, _ = self.new_viewer()
        joined_s = []
        for _ in range(ROUNDS):
            self.count("quiet")
            viewer.send(signal.SIGSTOP)
            self.count("stopped")
            viewer.send(signal.SIGCONT)
            self.count("quiet")
            viewer.kill()
            self.count("killed")
            viewer, took_s = self.new_viewer()
            joined_s.append(took_s)

        for kind in self.time_s:
            print(f"{kind}: {self.late[kind]} late wake-ups, {self.missed[kind]} missed ticks in {self.time_s[kind]:.1f} s")
        for kind in ("stopped", "killed"):
            share = self.time_s[kind] / (self.time_s[kind] + self.time_s["quiet"])
            chance = chance_of_as_many(self.late[kind], self.late["quiet"], share)
            print(f"{kind}: p = {chance:.3g}")
            self.assertGreater(chance, SIGNIFICANCE, f"more late wake-ups with the viewer {kind} than without")
        print("new viewers were in step after", ", ".join(f"{took_s:.2f} s" for took_s in joined_s))
        self.assertLess(max(joined_s), IN_STEP_S)
        self.stop_and_check(self.server)


if __name__ == "__main__":
    unittest.main()
