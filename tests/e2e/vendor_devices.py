"""Devices of other makers through our own plug-ins, which load libraries of our own writing in place of the makers': felt, broken
in every documented way, and brought up again without a restart; without force when the server is killed or stopped.

HAPTICS_FAULTS: how often each fault is injected. HAPTICS_EMULATED_ARM: the hardware. HAPTICS_EMULATED_SDK: what FDSDK names.
"""
import os
import queue
import signal
import subprocess
import threading
import time
import unittest

import harness
import haptic_recording
from haptic_client import Client

TIMES = int(os.environ.get("HAPTICS_FAULTS", "1"))
SECONDS = float(os.environ.get("HAPTICS_SECONDS", "5"))
SEEN_MS, ZERO_MS = 5, 30
BLOCKED_SEEN_MS = 7  # of a call that blocks: by the age of the position

# The hand goes in and out of this box.
SCENE = """
operations { add { name: "box" mesh { box { size_m { x: 0.2 y: 0.2 z: 0.1 } segments: 4 } } material { stiffness_N_per_m: 300 } } }
"""

# Of Fault and of DeviceFault, common/telemetry: what the recording may say.
STALE, LOST = 4, 5
SILENT = {(LOST, 8), (STALE, 0), (STALE, 8)}
GARBLED = {(LOST, 9), (STALE, 9), (STALE, 0)}


class Arm:
    """The process of the hardware, real-time like a device's own where that is permitted."""

    def __init__(self, file, kind):
        realtime = ["chrt", "--fifo", "50"]
        prefix = realtime if subprocess.run([*realtime, "true"], capture_output=True).returncode == 0 else []
        self.process = subprocess.Popen([*prefix, os.environ["HAPTICS_EMULATED_ARM"], file, str(kind)], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, text=True, bufsize=1)
        self.said = queue.Queue()
        threading.Thread(target=self.listen, daemon=True).start()
        assert self.said.get(timeout=10)[0] == "ready"

    def listen(self):
        for line in self.process.stdout:
            self.said.put(line.split())

    def tell(self, text):
        self.process.stdin.write(text + "\n")

    def hears(self, word):
        said = self.said.get(timeout=5)
        assert said[0] == word, f"{said} instead of {word}"
        return int(said[1])

    def close(self):
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            pipe.close()


class VendorDevice(harness.EndToEnd):
    def start_arm(self, kind):
        file = self.folder / "arm"
        file.unlink(missing_ok=True)
        arm = Arm(file, kind)
        self.addCleanup(arm.close)
        self.environment = {"EMULATED_ARM": str(file), "FDSDK": os.environ["HAPTICS_EMULATED_SDK"]}
        return arm

    def program(self, *arguments, environment=None, text=""):
        return subprocess.run([harness.BIN / "haptic_server", *map(str, arguments)], capture_output=True, text=True, input=text,
                              timeout=60, env={**os.environ, **(self.environment if environment is None else environment)})

    def start_felt(self):
        """A server with the device, once the hand is in the box."""
        self.record = self.folder / "ticks.haptics"
        server = self.start_server(scene=SCENE, device=self.DEVICE, options=["--record", self.record], env=self.environment)
        client = Client(server.address, "watcher", telemetry_hz=200)
        self.addCleanup(client.close)
        self.samples = client.samples()
        self.wait_for_force()
        return server

    def wait_for(self, condition, timeout_s, what):
        deadline = time.monotonic() + timeout_s
        for sample in self.samples:
            if condition(sample):
                return
            self.assertLess(time.monotonic(), deadline, f"{what} is not there: {sample}")

    def wait_for_force(self):
        self.wait_for(lambda sample: sample.fault == 0 and sample.force.written.z > 1, 15, "a force")

    def judge(self, injected, faults):
        """Of (fault, when it began, when there was no force, how long it lasted): seen, named and without force in time."""
        ticks = list(haptic_recording.ticks(self.record))
        late, worst = [], {}
        for fault, began_ns, zero_ns in injected:
            after = next(tick for tick in ticks if tick.time_ns >= began_ns and tick.fault != 0)
            seen_ms, zero_ms = (after.time_ns - began_ns) * 1e-6, (zero_ns - began_ns) * 1e-6
            names = {(tick.fault, tick.device_fault) for tick in ticks
                     if began_ns <= tick.time_ns < began_ns + 100e6 and tick.fault != 0}
            worst[fault] = [max(pair) for pair in zip(worst.get(fault, (0, 0)), (seen_ms, zero_ms))]
            if seen_ms > (BLOCKED_SEEN_MS if fault == "late" else SEEN_MS) or zero_ms > ZERO_MS or not names & faults[fault]:
                late.append((fault, seen_ms, zero_ms, names))
        for fault, (seen_ms, zero_ms) in worst.items():
            print(f"\n{fault}: {TIMES} times, seen within {seen_ms:.1f} ms, no force within {zero_ms:.1f} ms", end="", flush=True)
        self.assertEqual(late, [])


class ForceDimension(VendorDevice):
    DEVICE = "forcedimension"
    FAULTS = {"guard": SILENT, "error": GARBLED, "nan": GARBLED, "jump": {(LOST, 13)}, "lost": {(LOST, 12)},
              "velocity": {(LOST, 15)}, "late": SILENT | {(LOST, 9)}, "unplugged": {(LOST, 7)}}

    def setUp(self):
        super().setUp()
        self.arm = self.start_arm(34)

    def test_each_fault_is_seen_and_named_the_force_taken_away_in_time_and_the_device_comes_back(self):
        server = self.start_felt()
        injected = []
        for _ in range(TIMES):
            for fault in self.FAULTS:
                self.arm.tell(f"{fault} 60")
                injected.append((fault, self.arm.hears(fault), self.arm.hears("zero")))
                self.wait_for(lambda sample: sample.fault != 0, 5, "the fault")  # those before it lie ready still
                time.sleep(0.06)
                self.wait_for_force()
        self.stop_and_check(server)
        self.judge(injected, self.FAULTS)
        self.assertIn("omega.6: its force is off: it was moved faster than its limit of velocity", server.text())
        self.assertIn("omega.6: communication error", server.text())

    def test_its_readings_are_used_and_its_limits_told(self):
        server = self.start_felt()
        before = server.status()["device_exchange"]
        self.arm.tell("saturated 200")
        time.sleep(SECONDS)
        after = server.status()["device_exchange"]
        replies, used = (int(after[key]) - int(before[key]) for key in ("replies", "replies_used"))
        print(f"\n{used} of {replies} readings used in {SECONDS} s", end="", flush=True)
        self.assertGreater(replies, 900 * SECONDS)
        self.assertGreaterEqual(used, 0.99 * replies)
        self.stop_and_check(server)
        self.assertIn("its motors are saturated", server.text())

    def test_without_force_by_its_own_watchdog_when_the_server_is_killed(self):
        for _ in range(TIMES):
            server = self.start_felt()
            server.send(signal.SIGKILL)
            began_ns = time.monotonic_ns()
            self.arm.tell("watch 0")
            self.assertLess((self.arm.hears("zero") - began_ns) * 1e-6, ZERO_MS)
            server.kill()

    def test_without_force_when_the_server_is_stopped_and_felt_again_when_it_goes_on(self):
        server = self.start_felt()
        for _ in range(TIMES):
            server.send(signal.SIGSTOP)
            began_ns = time.monotonic_ns()
            self.arm.tell("watch 0")
            self.assertLess((self.arm.hears("zero") - began_ns) * 1e-6, ZERO_MS)
            time.sleep(0.1)
            server.send(signal.SIGCONT)
            self.wait_for(lambda sample: sample.fault != 0, 5, "the fault")
            self.wait_for_force()
        self.stop_and_check(server)
        self.assertIn("its force is off: its watchdog got no force for 25 ms", server.text())

    def test_is_listed_checked_and_refused_with_a_reason(self):
        listed = self.program("--list-devices").stdout
        self.assertIn("--device forcedimension   omega.6, ready", listed)
        self.arm.tell("rest 1")
        for _ in range(10):  # others' work on the machine may hold the arm up: short, and often
            checked = self.program("check-device", self.DEVICE, "--seconds", 0.4, "--force", 1, text="\n")
            if checked.returncode == 0:
                break
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)
        for axis in "xyz":
            self.assertIn(f"+{axis} pushes the right way", checked.stdout)
        for said, environment in {"Force Dimension's library: there is none of /nowhere/": {"FDSDK": "/nowhere", "HOME": "/nowhere"}}.items():
            refused = self.program("--device", self.DEVICE, "--listen", "127.0.0.1:0", environment=environment)
            self.assertEqual(refused.returncode, 1)
            self.assertIn(said, refused.stderr)
        self.arm.tell("busy 20000")
        self.arm.hears("busy")
        self.assertIn("device already in use", self.program("--device", self.DEVICE, "--listen", "127.0.0.1:0").stderr)


if __name__ == "__main__":
    unittest.main()
