"""Devices of other makers through our own plug-ins, with libraries and services of our own writing in place of the makers': felt, broken
in every documented way, and brought up again without a restart; without force when the server is killed or stopped.

HAPTICS_FAULTS: how often each fault is injected. HAPTICS_EMULATED_ARM, HAPTICS_EMULATED_HAPLY: the hardware.
HAPTICS_EMULATED_SDK: what FDSDK names.
"""
import os
import signal
import subprocess
import time
import unittest

import harness
import haptic_recording
from haptic_client import Client

TIMES = int(os.environ.get("HAPTICS_FAULTS", "1"))
SECONDS = float(os.environ.get("HAPTICS_SECONDS", "2"))
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


class VendorDevice(harness.EndToEnd):
    environment = {}

    def start_hardware(self, *command):
        hardware = harness.Hardware(*command)
        self.addCleanup(hardware.close)
        return hardware

    def program(self, *arguments, environment=None, text=""):
        return subprocess.run([harness.BIN / "haptic_server", *map(str, arguments)], capture_output=True, text=True, input=text,
                              timeout=harness.STOP_TIMEOUT_S,
                              env={**os.environ, **(self.environment if environment is None else environment)})

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
        deadline = time.monotonic() + harness.PATIENCE * timeout_s
        for sample in self.samples:
            if condition(sample):
                return
            self.assertLess(time.monotonic(), deadline, f"{what} is not there: {sample}")

    def wait_for_force(self):
        self.wait_for(lambda sample: sample.fault == 0 and sample.force.written.z > 1, 40, "a force")

    def check_time_without(self, server, harm):
        """From the signal to no force; not judged where the machine held a real-time thread up."""
        with harness.Cyclictest() as stall:
            began_ns = time.monotonic_ns()
            server.send(harm)
            self.hardware.tell("watch 0")
            zero_ms = (self.hardware.hears("zero") - began_ns) * 1e-6
        print(f"\nno force within {zero_ms:.1f} ms{', of a machine that was late' if stall.late else ''}", end="", flush=True)
        if not stall.late:
            self.assertLess(zero_ms, ZERO_MS)

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


def is_close(a, b, within):
    return all(abs(x - y) < within for x, y in zip(a, b))


class Felt:
    """What holds for each of them: DEVICE, FAULTS with what the recording may say of each, SAID of them in the log."""

    def test_each_fault_is_seen_and_named_the_force_taken_away_in_time_and_the_device_comes_back(self):
        server = self.start_felt()
        injected = []
        for _ in range(TIMES):
            for fault in self.FAULTS:
                self.hardware.tell(f"{fault} 60")
                injected.append((fault, self.hardware.hears(fault), self.hardware.hears("zero")))
                self.wait_for(lambda sample: sample.fault != 0, 5, "the fault")  # those before it lie ready still
                time.sleep(0.06)
                self.wait_for_force()
        self.stop_and_check(server)
        self.judge(injected, self.FAULTS)
        for said in self.SAID:
            self.assertIn(said, server.text())

    def test_its_readings_are_used_and_its_limits_told(self):
        server = self.start_felt()
        self.hardware.tell(f"{self.WEAKENED} 1000")
        for _ in range(5):  # others' work on the machine may hold one of them up
            before = server.status()["device_exchange"]
            time.sleep(SECONDS)
            after = server.status()["device_exchange"]
            replies, used = (int(after[key]) - int(before[key]) for key in ("replies", "replies_used"))
            print(f"\n{used} of {replies} readings used in {SECONDS} s", end="", flush=True)
            if replies > 900 * SECONDS and used >= 0.99 * replies:
                break
        self.assertGreater(replies, 900 * SECONDS)
        self.assertGreaterEqual(used, 0.99 * replies)
        self.stop_and_check(server)
        self.assertIn(self.SAID_OF_WEAKENED, server.text())
        self.judge_velocity(list(haptic_recording.ticks(self.record)))

    def judge_velocity(self, ticks):
        """What the device measured, by where it was 10 ms before and after."""
        judged = [(now.velocity, [(b - a) / 0.02 for a, b in zip(before.position, after.position)])
                  for before, now, after in zip(ticks, ticks[10:], ticks[20:])
                  if after.tick == before.tick + 20 and after.fault == now.fault == before.fault == 0]
        fast = max(max(map(abs, velocity)) for velocity, _ in judged)
        wrong = sum(not is_close(velocity, way, 0.02) for velocity, way in judged)
        print(f"\nof {len(judged)} velocities, up to {fast:.3f} m/s, {wrong} are not those of the positions", end="", flush=True)
        self.assertGreater(fast, 0.04)
        self.assertLess(wrong, 0.05 * len(judged))  # the hardware is held up now and then

    def test_without_force_by_its_own_means_when_the_server_is_killed(self):
        for _ in range(TIMES):
            server = self.start_felt()
            self.check_time_without(server, signal.SIGKILL)
            server.kill()

    def test_without_force_when_the_server_is_stopped_and_felt_again_when_it_goes_on(self):
        server = self.start_felt()
        for _ in range(TIMES):
            later = time.monotonic() + 2.1  # sooner again, its force would stay away for longer each time
            self.wait_for(lambda _: time.monotonic() > later, 5, "a sample")
            self.wait_for_force()
            self.check_time_without(server, signal.SIGSTOP)
            time.sleep(0.1)
            server.send(signal.SIGCONT)
            self.wait_for(lambda sample: sample.fault != 0, 5, "the fault")
            self.wait_for_force()
        self.stop_and_check(server)
        self.assertIn(self.SAID_OF_STOPPED, server.text())

    def test_is_listed_and_checked(self):
        self.assertIn(self.LISTED, self.program("--list-devices").stdout)
        self.hardware.tell("rest 1")
        for _ in range(10):  # others' work on the machine may hold the hardware up: short, and often
            checked = self.program("check-device", self.DEVICE, "--seconds", 0.4, "--force", 1, text="\n")
            if checked.returncode == 0:
                break
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)
        for axis in "xyz":
            self.assertIn(f"+{axis} pushes the right way", checked.stdout)

    def refusal_of(self, device, environment=None):
        refused = self.program("--device", device, "--listen", "127.0.0.1:0", environment=environment)
        self.assertEqual(refused.returncode, 1)
        return refused.stderr


class ForceDimension(Felt, VendorDevice):
    DEVICE, LISTED = "forcedimension", "--device forcedimension   omega.6, ready"
    FAULTS = {"guard": SILENT, "error": GARBLED, "nan": GARBLED, "jump": {(LOST, 13)}, "lost": {(LOST, 12)},
              "velocity": {(LOST, 15)}, "late": SILENT | {(LOST, 9)}, "unplugged": {(LOST, 7)}}
    SAID = ["omega.6: its force is off: it was moved faster than its limit of velocity", "omega.6: communication error"]
    WEAKENED, SAID_OF_WEAKENED = "saturated", "its motors are saturated"
    SAID_OF_STOPPED = "its force is off: its watchdog got no force for 25 ms"

    def setUp(self):
        super().setUp()
        file = self.folder / "arm"
        self.hardware = self.start_hardware(os.environ["HAPTICS_EMULATED_ARM"], file, 34)
        self.environment = {"EMULATED_ARM": str(file), "FDSDK": os.environ["HAPTICS_EMULATED_SDK"]}

    def test_what_cannot_be_opened_is_refused_with_a_reason(self):
        nowhere = {"FDSDK": "/nowhere", "HOME": "/nowhere"}
        self.assertIn("Force Dimension's library: there is none of /nowhere/", self.refusal_of(self.DEVICE, nowhere))
        self.hardware.tell("busy 20000")
        self.hardware.hears("busy")
        self.assertIn("device already in use", self.refusal_of(self.DEVICE))


class OpenHaptics(Felt, VendorDevice):
    DEVICE, LISTED = "openhaptics", "--device openhaptics   Touch, ready"
    FAULTS = {"error": GARBLED, "guard": GARBLED, "nan": GARBLED, "jump": {(LOST, 13)}, "exceeded": {(LOST, 15)},
              "late": SILENT | {(LOST, 9)}, "unplugged": GARBLED}
    SAID = ["Touch: communication error", "Touch: a frame out of turn", "Touch: its force is off: it was moved too fast"]
    WEAKENED, SAID_OF_WEAKENED = "saturated", "Touch: its motors are warm"
    SAID_OF_STOPPED = "the device's position is old"

    def setUp(self):
        super().setUp()
        file = self.folder / "arm"
        self.hardware = self.start_hardware(os.environ["HAPTICS_EMULATED_ARM"], file, 0)
        self.environment = {"EMULATED_ARM": str(file), "LD_LIBRARY_PATH": os.environ["HAPTICS_EMULATED_OPENHAPTICS"]}

    def test_its_process_may_die(self):
        server = self.start_felt()
        for _ in range(TIMES):
            host = subprocess.run(["pgrep", "-P", str(server.process.pid), "openhaptics_hos"], capture_output=True, text=True)
            os.kill(int(host.stdout), signal.SIGKILL)
            self.wait_for(lambda sample: sample.fault != 0 and sample.force.written.z == 0, 1, "the fault")
            self.wait_for_force()
        self.stop_and_check(server)

    def test_what_cannot_be_opened_is_refused_with_a_reason(self):
        self.assertIn("libHD.so.3.4: cannot open shared object file", self.refusal_of(self.DEVICE, {"LD_LIBRARY_PATH": ""}))
        self.assertIn("communication error: cable, power, pairing", self.refusal_of("openhaptics:Left"))
        self.hardware.tell("busy 20000")
        self.hardware.hears("busy")
        self.assertIn("it is opened already", self.refusal_of(self.DEVICE))


class Haply(Felt, VendorDevice):
    DEVICE, LISTED = "haply:@17201", "--device haply   "  # which asks at the usual port
    FAULTS = {"silence": SILENT, "garbage": GARBLED, "null": GARBLED, "missing": GARBLED, "jump": {(LOST, 13)},
              "unpowered": {(LOST, 15)}, "uncalibrated": {(LOST, 12)}, "drop": {(LOST, 7)}}
    SAID = ["Inverse3 049D: its service sends what is no JSON", "Inverse3 049D: its force is off: it has no power supply",
            "Inverse3 049D: it is not calibrated"]
    WEAKENED, SAID_OF_WEAKENED = "weak", "its service applies another force than the server's"
    SAID_OF_STOPPED = "the device's position is old"

    def setUp(self):
        super().setUp()
        self.hardware = self.start_service()

    def start_service(self, *options):
        return self.start_hardware(os.environ["HAPTICS_EMULATED_HAPLY"], 17201, *options)

    def test_the_force_that_it_applies_is_told(self):
        server = self.start_felt()
        self.wait_for(lambda sample: sample.fault == 0 and sample.force.written.z > 1
                      and abs(sample.device_applied_force.z - sample.force.written.z) < 0.3, 5, "the force as it was written")
        self.hardware.tell("weak 1000")
        self.wait_for(lambda sample: sample.fault == 0 and sample.force.written.z > 1
                      and sample.device_applied_force.z < 0.7 * sample.force.written.z, 5, "less than was written")
        self.stop_and_check(server)

    def test_the_service_may_end_and_start_again_another_way(self):
        server = self.start_felt()
        for _ in range(TIMES):
            self.hardware.close()
            self.wait_for(lambda sample: sample.fault != 0 and sample.force.written.z == 0, 1, "the fault")
            self.hardware = self.start_service("values", "before")
            self.wait_for_force()

            def is_applied():
                self.hardware.tell("applied 0")
                return self.hardware.hears("applied") > 300  # mN
            harness.wait_until(is_applied, 20, "the force of the other spelling")
        self.stop_and_check(server)
        self.assertIn("another program commands it too", server.text())

    def test_what_cannot_be_opened_is_refused_with_a_reason(self):
        self.assertIn("its service has no such Inverse3", self.refusal_of("haply:9999@17201"))
        self.assertIn("the device's ID is wanted", self.refusal_of("haply:@http"))
        self.hardware.close()
        self.assertIn("does not listen at 127.0.0.1:17201", self.refusal_of(self.DEVICE))


if __name__ == "__main__":
    unittest.main()
