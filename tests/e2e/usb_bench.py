"""A machine with emulated devices on USB for the real server and the real libusb: a tree of sysfs (umockdev shows it to
libudev) and, before libusb, a usbfs node, behind which a model of the device works in a process of its own, with a user's
hand on it."""
import json
import os
import socket
import struct
import subprocess
from pathlib import Path



PRELOADED = os.environ["HAPTICS_EMULATED_USBFS"]
HARDWARE = os.environ["HAPTICS_EMULATED_USB_DEVICE"]
SYSFS = "libumockdev-preload.so.0"

FALCON = bytes.fromhex("1201000200000008030448CB00060102030109022000010100A02D0904000002FFFFFF020705810240000007050202400000")
WOODEN = bytes.fromhex("12010002000000403412060000010102030109022900010100803209040000020300000009211101000122210007058103080001"
                       "07050103080001")


def some_firmware():
    """A boot stream of the right form with a program that is none."""
    words = [0x08AA] + 8 * [0] + [0x003F, 0x8000]
    for length in (200, 7, 300):
        words += [length, 0, 0x8000] + [i * 37 & 0xFFFF for i in range(length)]
    return struct.pack(f"<{len(words) + 1}H", *words, 0)


class Bench:
    """`kind` is "falcon", "wooden" or None; a second device of the kind has a place in sysfs only."""

    def __init__(self, folder, kind, count=1):
        self.folder, self.kind = Path(folder), kind
        self.root = self.folder / "usb"
        self.node_path, self.control_path = self.folder / "usb.node", self.folder / "usb.socket"
        self.connection = self.hardware = None
        (self.root / "sys/bus/usb/devices").mkdir(parents=True)
        (self.root / "sys/class").mkdir()
        (self.root / "dev").mkdir()
        for i in range(count if kind else 0):
            self.add(i + 1, FALCON if kind == "falcon" else WOODEN)
        if kind:
            self.hardware = subprocess.Popen([HARDWARE, kind, self.node_path, self.control_path],
                                             stdout=subprocess.PIPE, text=True)
            self.hardware.stdout.readline()

    def add(self, port, descriptors):
        device = self.root / f"sys/devices/pci0000:00/0000:00:14.0/usb1/1-{port}"
        device.mkdir(parents=True)
        vendor, product = struct.unpack_from("<HH", descriptors, 8)
        attributes = {"bConfigurationValue": "1", "busnum": "1", "devnum": str(port + 1), "speed": "12",
                      "idVendor": f"{vendor:04x}", "idProduct": f"{product:04x}"}
        for name, value in attributes.items():
            (device / name).write_text(value + "\n")
        (device / "descriptors").write_bytes(descriptors)
        node = f"bus/usb/001/{port + 1:03}"
        (device / "uevent").write_text(f"SUBSYSTEM=usb\nDRIVER=usb\nBUSNUM=001\nDEVNUM={port + 1:03}\nDEVNAME={node}\n"
                                       f"DEVTYPE=usb_device\nMAJOR=189\nMINOR={port}\n")
        (device / "subsystem").symlink_to("../../../../../bus/usb")
        (self.root / f"sys/bus/usb/devices/1-{port}").symlink_to(f"../../../devices/pci0000:00/0000:00:14.0/usb1/1-{port}")
        (self.root / "dev" / node).parent.mkdir(parents=True, exist_ok=True)
        (self.root / "dev" / node).touch()

    def environment(self, **more):
        # A sanitizer's runtime has to be the first of all.
        preload = [os.environ.get("HAPTICS_SANITIZER_RUNTIME", ""), PRELOADED, SYSFS]
        return {"LD_PRELOAD": " ".join(filter(None, preload)), "UMOCKDEV_DIR": str(self.root),
                "EMULATED_USB": str(self.node_path), **more}

    def firmware(self):
        file = self.folder / "firmware.bin"
        file.write_bytes(some_firmware())
        return file

    def tell(self, line):
        """A command to the emulated hardware: its state after it. Times are those of the monotonic clock."""
        if self.connection is None:
            self.connection = socket.socket(socket.AF_UNIX)
            self.connection.connect(str(self.control_path))
        self.connection.sendall(line.encode() + b"\n")
        answer = b""
        while not answer.endswith(b"\n"):
            piece = self.connection.recv(1000)
            if not piece:
                raise AssertionError("the emulated hardware has ended")
            answer += piece
        return json.loads(answer)

    def close(self):
        if self.connection is not None:
            self.connection.close()
            self.connection = None
        if self.hardware is not None:
            self.hardware.kill()
            self.hardware.wait()
            self.hardware.stdout.close()
            self.hardware = None
