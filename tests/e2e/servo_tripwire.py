"""The servo thread of a server that is edited, watched, recorded and asked for its last seconds takes no lock and makes no
system call but its sleep. A preloaded library ends the server when it does.

HAPTICS_TRIPWIRE: the library.
"""
import os
import time
import unittest

import harness

TRIPPED = 99  # exit code


class ServoTripwire(harness.EndToEnd):
    def start(self, **environment):
        os.environ.update({"LD_PRELOAD": os.environ["HAPTICS_TRIPWIRE"], **environment})
        try:
            self.server = self.start_server(options=["--record", self.folder / "ticks", "--recordings", self.folder])
        finally:
            for name in ("LD_PRELOAD", *environment):
                del os.environ[name]

    def test_no_lock_and_no_system_call_but_the_sleep(self):
        self.start()
        end = time.monotonic() + 5
        step = 0
        while time.monotonic() < end:
            step += 1
            self.server.ctl("apply", "-", text='operations { set_material { object { name: "torus" } material { '
                                               f'stiffness_N_per_m: {600 + 100 * (step % 5)} }} }} }}').json()
            self.server.ctl("apply", "-", text='operations { set_pose { object { name: "box" } pose { position { '
                                               f'x: {0.06 + 0.001 * (step % 3)} z: 0.025 }} }} }} }}').json()
            self.server.ctl("watch", "--rate", "200", "--seconds", "0.2")
        self.server.ctl("dump").json()
        status = self.server.status()
        self.assertIn("tripwire: armed", self.server.text())
        self.assertTrue(self.server.alive(), self.server.text())
        self.assertGreater(status["ticks"], 1000)
        self.assertGreater(status["contact_ticks"], 100)
        self.assertEqual(status["allocations_in_servo"], 0)
        self.server.kill()  # to end the thread takes system calls

    def check_that_it_trips(self, on, says):
        try:
            self.start(HAPTICS_TRIPWIRE_TRY=on)
            code, text = self.server.wait(), self.server.text()
        except harness.NotStarted as ended:  # sooner than it could say where it listens
            code, text = ended.code, str(ended)
        self.assertEqual(code, TRIPPED, text)
        self.assertIn(says, text)

    def test_the_wire_trips_on_a_lock(self):
        self.check_that_it_trips("lock", "called pthread_mutex_lock")

    def test_the_wire_trips_on_a_system_call(self):
        self.check_that_it_trips("call", "made system call 110")


if __name__ == "__main__":
    unittest.main()
