"""The server drives emulated Falcon and WoodenHaptics hardware through the real libusb: brought up, homed, felt, broken in
every way, and refused with reasons. HAPTICS_SECONDS and HAPTICS_FAULTS make it longer."""
import os
import statistics
import subprocess
import time
import unittest

import harness
import usb_bench
from haptic_client import Client
from haptics.v1 import telemetry_pb2 as v1

SECONDS = float(os.environ.get("HAPTICS_SECONDS", "4"))
TRIES = 8  # of so many seconds
TIMES = int(os.environ.get("HAPTICS_FAULTS", "1"))
DEMO = (harness.Path(__file__).parents[2] / "deploy/scenes/demo.scene").read_text()

# What a test does to the hardware: how telemetry names it.
FAULTS = {
    "falcon": {"short": v1.DEVICE_FAULT_GARBLED, "shifted": v1.DEVICE_FAULT_GARBLED, "silence": v1.DEVICE_FAULT_SILENT,
               "stall": v1.DEVICE_FAULT_STALLED, "slow": v1.DEVICE_FAULT_LATE, "unhomed": v1.DEVICE_FAULT_HOMING_LOST,
               "jump": v1.DEVICE_FAULT_JUMPED, "unplug": v1.DEVICE_FAULT_UNPLUGGED},
    "wooden": {"short": v1.DEVICE_FAULT_GARBLED, "shifted": v1.DEVICE_FAULT_JUMPED, "silence": v1.DEVICE_FAULT_SILENT,
               "stall": v1.DEVICE_FAULT_STALLED, "slow": v1.DEVICE_FAULT_SILENT, "jump": v1.DEVICE_FAULT_JUMPED,
               "unplug": v1.DEVICE_FAULT_UNPLUGGED},
}


class UsbTest(harness.EndToEnd):
    def start_bench(self, kind, **options):
        bench = usb_bench.Bench(self.folder, kind, **options)
        self.addCleanup(bench.close)
        return bench

    def start_with_device(self, kind, options=()):
        bench = self.start_bench(kind)
        if kind == "falcon":
            options = ["--firmware", bench.firmware(), *options]
        options = ["--assets", "/usr/share/inventor/data", *options]
        server = self.start_server(scene=DEMO, device=kind, options=options, env=bench.environment())
        return bench, server

    def ended_with(self, arguments, environment):
        """What a server that does not start says; it has to end with an error."""
        done = subprocess.run([harness.BIN / "haptic_server", *map(str, arguments)], capture_output=True, text=True,
                              timeout=harness.STOP_TIMEOUT_S, env={**os.environ, **environment})
        self.assertNotEqual(done.returncode, 0, done.stdout)
        return done.stderr


class Refusals(UsbTest):
    def test_without_a_device(self):
        bench = self.start_bench(None)
        self.assertIn("no Novint Falcon is plugged in", self.ended_with(["--device", "falcon"], bench.environment()))

    def test_of_two_devices_one_has_to_be_chosen(self):
        bench = self.start_bench("falcon", count=2)
        said = self.ended_with(["--device", "falcon"], bench.environment())
        self.assertIn("there are 2 devices of this kind: 001/002 (port 1-1, serial SIM00001), 001/003 (port 1-2)", said)
        self.assertIn("--device NAME:SIM00001", said)
        self.assertIn('called "no-such"', self.ended_with(["--device", "falcon:no-such"], bench.environment()))

    def test_without_permission_the_udev_rule_is_named(self):
        bench = self.start_bench("wooden")
        said = self.ended_with(["--device", "wooden"], bench.environment(EMULATED_USB_DENY="1"))
        self.assertIn("/dev/bus/usb/001/002: no permission: copy deploy/udev/70-haptic-devices.rules", said)

    def test_that_another_program_uses(self):
        bench = self.start_bench("wooden")
        said = self.ended_with(["--device", "wooden"], bench.environment(EMULATED_USB_BUSY="1"))
        self.assertIn("another program uses the device", said)

    def test_firmware_that_is_none_or_is_cut_off(self):
        bench = self.start_bench("falcon")
        wrong = self.folder / "wrong.bin"
        wrong.write_bytes(b"\x7fELF" + bytes(100))
        said = self.ended_with(["--device", "falcon", "--firmware", wrong], bench.environment())
        self.assertIn(f"{wrong}: does not begin with the boot key 0x08AA but with 0x457F", said)
        cut = self.folder / "cut.bin"
        cut.write_bytes(usb_bench.some_firmware()[:700])
        said = self.ended_with(["--device", "falcon", "--firmware", cut], bench.environment())
        self.assertIn(f"{cut}: is cut off", said)

    def test_a_calibration_file_with_an_unknown_key(self):
        bench = self.start_bench("falcon")
        file = self.folder / "calibration.text"
        file.write_text("force_scale: 0.5\nforce_scael: 1\n")
        said = self.ended_with(["--device", "falcon", "--calibration", file], bench.environment())
        self.assertIn(f"{file}:2:", said)
        self.assertIn('no field "force_scael"', said)

    def test_a_rate_that_it_cannot_do(self):
        bench = self.start_bench("falcon")
        said = self.ended_with(["--device", "falcon", "--rate", "4000"], bench.environment())
        self.assertIn("--rate: is 4000 Hz; a Novint Falcon exchanges positions and forces at most 1000 times a second", said)

    def test_a_device_that_does_not_exist(self):
        self.assertIn('there is no device "phantom"', self.ended_with(["--device", "phantom"], {}))


class Listing(UsbTest):
    def listed(self, environment):
        done = subprocess.run([harness.BIN / "haptic_server", "--list-devices"], capture_output=True, text=True,
                              timeout=harness.STOP_TIMEOUT_S, env={**os.environ, **environment}, check=True)
        return done.stdout.splitlines()

    def test_says_how_to_choose_and_whether_it_may_be_opened(self):
        bench = self.start_bench("falcon", count=2)
        lines = self.listed(bench.environment())
        self.assertEqual(len([line for line in lines if " at USB " in line]), 2, lines)
        self.assertEqual(lines[0], "--device falcon:SIM00001   Novint Falcon at USB 001/002 (port 1-1, serial SIM00001), ready")
        self.assertRegex(lines[1], "^--device falcon:1-2 .* went away")
        self.assertIn("no permission", self.listed(bench.environment(EMULATED_USB_DENY="1"))[0])

    def test_without_devices(self):
        self.assertIn("no device on USB", self.listed(self.start_bench(None).environment())[0])


class ClosedLoop(UsbTest):
    """A hand on the emulated device moves over the demo scene."""

    @staticmethod
    def moment(server, bench):
        """The server's status, the hardware's state, and how long it took to ask for both."""
        began = time.monotonic()
        status, state = server.status(), bench.tell("state")
        return status, state, time.monotonic() - began

    def felt(self, kind):
        bench, server = self.start_with_device(kind)
        with Client(server.address, "watcher", telemetry_hz=200) as client:
            unhomed_force = 0
            for sample in client.samples(30):
                if sample.device_state == v1.DEVICE_STATE_READY:
                    break
                force = sample.force.written
                unhomed_force = max(unhomed_force, abs(force.x), abs(force.y), abs(force.z))
            self.assertEqual(unhomed_force, 0, "before it was homed")
            self.assertEqual(sample.device_state, v1.DEVICE_STATE_READY, server.text())
            for _ in range(TRIES):
                before, bench_before, took_before_s = self.moment(server, bench)
                time.sleep(SECONDS)
                after, bench_after, took_after_s = self.moment(server, bench)
                sent, late = (bench_after[key] - bench_before[key] for key in ("replies", "late"))
                said = {key: int(after["device_exchange"][key]) - int(before["device_exchange"].get(key, 0))
                        for key in ("commands", "replies", "replies_used")}
                ticks = int(after["ticks"]) - int(before["ticks"])
                print(f"\n{kind}: {ticks} ticks, {said}, {sent} replies sent by the device, "
                      f"{100 * said['replies_used'] / said['replies']:.3f} % used, {after['missed_ticks']} ticks missed, "
                      f"the hardware held up {bench_after['held_up']} times, {100 * late / sent:.3f} % of its replies late")
                # Replies on their way at either end are a few, and server and hardware are not asked at the same moment.
                taken = 0.999 * sent - 5 - 1000 * (took_before_s + took_after_s)
                # The servo takes the newest: where the machine held one of the threads up, several come at once. The driver's
                # and the servo's are held up as often as the hardware's, which says when it was late. 99.9 % is asked for in
                # virtual_loop_test.cpp.
                used = 0.99 * said["replies"] - 2 * late
                if said["replies"] >= taken and said["replies_used"] >= used:
                    break
                # Once more: the machine holds threads up for seconds at times, and where the bus's frames begin just when
                # the servo ticks, two replies come in one tick and none in the next.
                bench.tell("shift frames")
        self.assertGreater(said["replies"], 0.9 * 1000 * SECONDS)
        self.assertGreaterEqual(said["replies"], taken)
        self.assertGreaterEqual(said["replies_used"], used)
        self.assertGreater(int(after["contact_ticks"]), 100)
        self.assertEqual(int(after.get("allocations_in_servo", 0)), 0)
        # The machine may let the hardware wait: then it is silent, and late after that.
        held_up = bench_after["held_up"]
        self.assertLessEqual(int(after["device_exchange"].get("faults", 0)), 2 * held_up, server.text())
        summary = self.stop_and_check(server)
        self.assertEqual(summary["device_exchange"]["connections"], 1)
        self.assertIn("homing: ", server.text())

    def test_falcon(self):
        self.felt("falcon")

    def test_wooden_haptics(self):
        self.felt("wooden")


class Faults(UsbTest):
    """Detected within 5 ms, no force within 30 ms, named, and felt again without a restart. Where the machine held server
    or hardware up at that moment, the times are not judged; virtual_faults_test.cpp judges all."""

    def next_sample(self, wanted, what, patience_s=30):
        """Patience is counted in the servo's time: this client may be slower than the servo where the machine is busy."""
        began_ns = None
        for sample in self.samples:
            if wanted(sample):
                return sample
            began_ns = began_ns or sample.time_ns
            self.assertLess(sample.time_ns - began_ns, patience_s * 1e9, f"never {what}: {sample}\n{self.server.text()}")
        raise AssertionError("no telemetry")

    def feel(self):
        """Waits until the hand presses on something and the motors push back."""
        def pressing(sample):
            return sample.fault == v1.FAULT_NONE and abs(sample.force.written.z) > 0.2
        while True:
            sample = self.next_sample(pressing, "felt")
            if self.bench.tell("state")["motors_on"]:
                return sample

    def inject(self, name, cause):
        """(detected, zero force) in ms, or None where the machine was late itself."""
        last = self.feel()
        began_ns = self.bench.tell("unplug" if name == "unplug" else f"fault {name}")["now_ns"]
        def faulty(sample):
            nonlocal last
            if sample.fault == v1.FAULT_NONE:
                last = sample
            return sample.fault != v1.FAULT_NONE and sample.time_ns > began_ns
        first = before_zero = self.next_sample(faulty, f"detected: {name}")
        def forceless(sample):
            nonlocal before_zero
            if abs(sample.force.written.x) + abs(sample.force.written.y) + abs(sample.force.written.z) == 0:
                return True
            before_zero = sample
            return False
        zero = self.next_sample(forceless, "without force")
        self.next_sample(lambda s: s.time_ns > began_ns + 80_000_000 and s.device_fault == cause,
                         f"named: {name} is {v1.DeviceFault.Name(cause)}")
        state = self.bench.tell("state")
        if name != "unplug":
            self.assertFalse(state["motors_on"], name)
        self.bench.tell("plug" if name == "unplug" else "fault none")
        self.next_sample(lambda s: s.fault == v1.FAULT_NONE, f"felt again after {name}")
        unseen = max(first.tick - last.tick, zero.tick - before_zero.tick) > 2  # samples that the network thread left out
        if unseen or zero.missed_ticks != last.missed_ticks:
            return None
        zero_ns = zero.time_ns if name == "unplug" else state["zero_since_ns"]
        return (first.time_ns - began_ns) * 1e-6, (zero_ns - began_ns) * 1e-6

    def break_often(self, kind):
        self.bench, self.server = self.start_with_device(kind)
        judged = 0
        with Client(self.server.address, "watcher", telemetry_hz=1000) as client:
            self.samples = client.samples()
            for name, cause in FAULTS[kind].items():
                known = [times for times in (self.inject(name, cause) for _ in range(TIMES)) if times]
                judged += len(known)
                if known:
                    detected, zero = zip(*known)
                    print(f"\n{kind} {name}: {len(known)} of {TIMES} judged; detected in {statistics.median(detected):.1f} "
                          f"ms, at most {max(detected):.1f}; no force after {statistics.median(zero):.1f}, at most "
                          f"{max(zero):.1f}", end="", flush=True)
                    self.assertLessEqual(statistics.median(detected), 5, name)
                    self.assertLessEqual(statistics.median(zero), 30, name)
        self.assertGreater(judged, 0, "no time could be judged")
        self.stop_and_check(self.server)
        for cause in ("unplugged", "fell silent", "garbled", "refuses transfers"):
            self.assertIn(cause, self.server.text())

    def test_falcon(self):
        self.break_often("falcon")

    def test_wooden_haptics(self):
        self.break_often("wooden")

    def test_firmware_that_does_not_arrive_whole(self):
        self.bench, self.server = self.start_with_device("falcon")
        with Client(self.server.address, "watcher", telemetry_hz=200) as client:
            self.samples = client.samples()
            self.feel()
            for _ in range(TIMES):
                self.bench.tell("unplug")
                self.next_sample(lambda s: s.device_fault == v1.DEVICE_FAULT_UNPLUGGED, "unplugged")
                self.bench.tell("plug")
                self.bench.tell("fault firmware")
                self.next_sample(lambda s: s.device_fault == v1.DEVICE_FAULT_FIRMWARE, "refused by the loader")
                self.assertFalse(self.bench.tell("fault none")["motors_on"])
                self.feel()
        self.assertIn("the firmware arrived damaged: its echo differs at byte 300", self.server.text())
        self.stop_and_check(self.server)


if __name__ == "__main__":
    unittest.main()
