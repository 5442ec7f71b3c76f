"""The systemd unit and the udev rules agree with one another, and with the programs."""
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

TOP = Path(__file__).parents[2]
UNIT = TOP / "deploy/systemd/haptic_server.service"
RULES = TOP / "deploy/udev/70-haptic-devices.rules"
SERVER = Path(sys.argv.pop(1)).resolve()


def settings(key):
    """The values of a setting of the unit."""
    return re.findall(rf"^{key}=(.*)$", UNIT.read_text(), re.MULTILINE)


def rules():
    """Each rule as {key: value}; the operators are checked on the way."""
    made = []
    for line in RULES.read_text().splitlines():
        if not line or line.startswith("#"):
            continue
        pairs = [re.fullmatch(r'(\w+(?:\{[\w/]+\})?)(==|=|\+=)"([^"]*)"', pair.strip()) for pair in line.split(",")]
        assert all(pairs), line
        for pair in pairs:
            matches = pair[1].startswith(("ACTION", "KERNEL", "SUBSYSTEM", "ENV", "ATTR{id"))
            assert (pair[2] == "==") == matches, f"{pair[0]} in {line}"
        made.append({pair[1]: pair[3] for pair in pairs})
    return made


def usb_rules():
    return [rule for rule in rules() if rule["SUBSYSTEM"] == "usb"]


class Service(unittest.TestCase):
    def test_the_rules_are_for_the_devices_that_the_drivers_know(self):
        known = set()
        for source in (TOP / "haptic_server/device/usb").glob("*.h"):
            known |= set(re.findall(r"UsbModel k\w+Model\{\s*\.vendor = 0x(\w{4}), \.product = 0x(\w{4})", source.read_text()))
        known = {(vendor.lower(), product.lower()) for vendor, product in known}
        self.assertEqual(len(known), 2)
        known.add(("1451", "0402"))  # which their maker's library opens
        self.assertEqual({(rule["ATTR{idVendor}"], rule["ATTR{idProduct}"]) for rule in usb_rules()}, known)

    def test_the_service_is_in_the_group_that_may_use_them(self):
        groups = " ".join(settings("SupplementaryGroups")).split()
        for rule in rules():
            self.assertIn(rule["GROUP"], groups)
            self.assertEqual(rule["MODE"], "0660")
        for rule in usb_rules():
            self.assertEqual(rule["TAG"], "uaccess", "for who sits at the machine")

    def test_the_service_may_keep_processors_awake_and_others_may_not(self):
        self.assertEqual(len([rule for rule in rules() if rule.get("KERNEL") == "cpu_dma_latency"]), 1)
        self.assertIn("/dev/cpu_dma_latency rw", settings("DeviceAllow"))
        self.assertEqual(settings("ExecStartPre"), [], "nothing runs as root")

    def test_the_service_may_use_the_devices_and_be_real_time(self):
        self.assertIn("char-usb_device rw", settings("DeviceAllow"))
        self.assertGreaterEqual(int(settings("LimitRTPRIO")[0]), 80)
        self.assertEqual(settings("LimitMEMLOCK"), ["infinity"])
        self.assertEqual(settings("CapabilityBoundingSet"), [""])
        self.assertNotIn("yes", settings("RestrictRealtime"))
        self.assertNotIn("@resources", " ".join(call for call in settings("SystemCallFilter") if call[0] == "~"))

    def test_an_import_may_be_sandboxed_and_ends_alone_when_memory_runs_out(self):
        self.assertIn("seccomp", settings("SystemCallFilter")[0].split())
        self.assertEqual(settings("OOMPolicy"), ["continue"])
        self.assertIn("AF_UNIX", settings("RestrictAddressFamilies")[0])

    def test_what_watches_the_server_outlives_it_for_a_while(self):
        self.assertEqual(settings("KillMode"), ["control-group"], "mixed would kill it with the server")
        self.assertGreaterEqual(int(settings("TimeoutStopSec")[0]), 5)

    def test_the_rules_come_before_those_that_give_the_device_to_who_sits_there(self):
        self.assertLess(RULES.name, "73-seat-late.rules")

    def test_the_server_knows_the_options_of_the_unit(self):
        usage = subprocess.run([SERVER, "--help"], capture_output=True, text=True, check=True).stdout
        options = re.findall(r"--[\w-]+", settings("ExecStart")[0])
        self.assertTrue(options)
        for option in options:
            self.assertRegex(usage, rf"{option}\b")

    @unittest.skipUnless(shutil.which("systemd-analyze"), "no systemd here")
    def test_little_of_the_machine_is_open_to_the_service(self):
        done = subprocess.run(["systemd-analyze", "security", "--offline=true", "--threshold=30", "--no-pager", UNIT],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    @unittest.skipUnless(shutil.which("systemd-analyze"), "no systemd here")
    def test_systemd_finds_nothing_wrong_with_the_unit(self):
        with tempfile.TemporaryDirectory() as folder:
            unit = Path(folder) / UNIT.name
            unit.write_text(UNIT.read_text().replace("/usr/local/bin/haptic_server", str(SERVER)))
            done = subprocess.run(["systemd-analyze", "verify", "--man=no", unit], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout + done.stderr), (0, ""))


if __name__ == "__main__":
    unittest.main()
