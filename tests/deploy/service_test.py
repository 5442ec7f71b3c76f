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
            matches = pair[1].startswith(("ACTION", "SUBSYSTEM", "ENV", "ATTR{id"))
            assert (pair[2] == "==") == matches, f"{pair[0]} in {line}"
        made.append({pair[1]: pair[3] for pair in pairs})
    return made


class Service(unittest.TestCase):
    def test_the_rules_are_for_the_devices_that_the_drivers_know(self):
        known = set()
        for source in (TOP / "haptic_server/device/usb").glob("*.h"):
            known |= set(re.findall(r"UsbModel k\w+Model\{\s*\.vendor = 0x(\w{4}), \.product = 0x(\w{4})", source.read_text()))
        known = {(vendor.lower(), product.lower()) for vendor, product in known}
        self.assertEqual(len(known), 2)
        self.assertEqual({(rule["ATTR{idVendor}"], rule["ATTR{idProduct}"]) for rule in rules()}, known)

    def test_the_service_is_in_the_group_that_may_use_them(self):
        groups = " ".join(settings("SupplementaryGroups")).split()
        for rule in rules():
            self.assertIn(rule["GROUP"], groups)
            self.assertEqual(rule["MODE"], "0660")
            self.assertEqual(rule["TAG"], "uaccess", "for who sits at the machine")

    def test_the_rules_come_before_those_that_give_the_device_to_who_sits_there(self):
        self.assertLess(RULES.name, "73-seat-late.rules")

    def test_the_server_knows_the_options_of_the_unit(self):
        usage = subprocess.run([SERVER, "--help"], capture_output=True, text=True, check=True).stdout
        options = re.findall(r"--[\w-]+", settings("ExecStart")[0])
        self.assertTrue(options)
        for option in options:
            self.assertRegex(usage, rf"{option}\b")

    @unittest.skipUnless(shutil.which("systemd-analyze"), "no systemd here")
    def test_systemd_finds_nothing_wrong_with_the_unit(self):
        with tempfile.TemporaryDirectory() as folder:
            unit = Path(folder) / UNIT.name
            unit.write_text(UNIT.read_text().replace("/usr/local/bin/haptic_server", str(SERVER)))
            done = subprocess.run(["systemd-analyze", "verify", "--man=no", unit], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout + done.stderr), (0, ""))


if __name__ == "__main__":
    unittest.main()
