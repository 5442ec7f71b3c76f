"""Does the server miss ticks that a bare real-time thread would not? haptic_server (FIFO, pinned) and cyclictest (rt-tests),
with the same period and priority, run in the same instant, each on a processor of its own; from block to block they change
places. Meanwhile stress-ng loads every processor and haptic_stress runs servers, viewers and editors across a bad network; or,
with --soup, the machine is idle and the scene holds what no tree sorts well, too: random triangles each as long as the cube of
0.1 m that they lie in, which the simulated hand explores. Compared are wake-ups later than a period, as Poisson counts. Prints
JSON; exits with 1 when the two can hardly be of one rate (p <= 0.001), a fault came up, or the servo touched the heap, with 2
when the machine cannot tell.

usage: servo_beside_cyclictest.py BIN SCENE [--soup TRIANGLES] [--seconds N] [--blocks N] [--rate HZ] [--assets FOLDER]
"""

import argparse
import json
import math
import os
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import servo_rates

LEAST_P = 0.001
CANNOT_TELL = 2  # exit code
WARM_UP_S = 3  # until the attack is under way
SOUP = """
operations {{ add {{ name: "soup" mesh {{ file: "{file}" }}
                     pose {{ position {{ x: 0.045 y: 0.02 z: 0.1 }} }} material {{ stiffness_N_per_m: 600 }} }} }}
"""


def poisson_p(a, exposure_a, b, exposure_b):
    """Whether two Poisson counts can be of one rate: the exact two-sided conditional test (given the sum, one count is
    binomial)."""
    n, share = a + b, exposure_a / (exposure_a + exposure_b)
    if n == 0:
        return 1.0
    log_p = [math.lgamma(n + 1) - math.lgamma(k + 1) - math.lgamma(n - k + 1) + k * math.log(share) +
             (n - k) * math.log1p(-share) for k in range(n + 1)]
    return min(1.0, sum(math.exp(p) for p in log_p if p <= log_p[a] + 1e-9))


def write_soup(file, triangles, edge_m=0.1):
    """Binary STL: corners anywhere in a cube about the origin."""
    draw = random.Random(1)
    with open(file, "wb") as out:
        out.write(bytes(80) + struct.pack("<I", triangles))
        for _ in range(triangles):
            out.write(struct.pack("<12fH", 0, 0, 0, *(draw.uniform(-edge_m / 2, edge_m / 2) for _ in range(9)), 0))


class Attack:
    """All processors, memory, disk and scheduler; and whole servers, viewers and editors beside them."""

    def __init__(self, tools, seconds, folder):
        self.processes = [
            subprocess.Popen(["stress-ng", "--cpu", "0", "--vm", "1", "--vm-bytes", "256M", "--hdd", "1", "--hdd-bytes", "64M",
                              "--switch", "2", "--timer", "1", "--temp-path", folder, "--timeout", f"{seconds:.0f}s"],
                             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL),
            subprocess.Popen([tools / "haptic_stress", "--clients", "4", "--seconds", str(round(seconds)), "--out",
                              Path(folder) / "stress"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)]

    def running(self):
        return all(process.poll() is None for process in self.processes)

    def end(self):
        for process in self.processes:
            if process.poll() is None:
                process.terminate()
        for process in self.processes:
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def late_ticks(recording):
    """Wake-ups that were later than a period: the ticks before which some are missing."""
    import haptic_recording
    numbers = [tick.tick for tick in haptic_recording.ticks(recording)]
    return sum(b > a + 1 for a, b in zip(numbers, numbers[1:]))


def run_block(options, cpus, folder):
    """Figures of server and cyclictest over the same seconds."""
    ours, theirs = servo_rates.run_both(options, options.rate, cpus, folder, ["--record", folder / "ticks"])
    run = json.loads((folder / "server.json").read_text())
    ours.update({key: run[key] for key in ("allowance_spent", "contact_ticks", "faults")}, fifo=run["realtime"]["fifo"],
                late=late_ticks(folder / "ticks"), tick_max_us=run["tick_ns"]["max"] / 1e3)
    theirs["late"] = theirs["late_wake_ups"]
    return ours, theirs


def result_of(options, blocks):
    ours, theirs = ([pair[i] for pair in blocks] for i in (0, 1))
    total = lambda side, key: sum(block[key] for block in side)
    p = poisson_p(total(ours, "late"), total(ours, "ticks"), total(theirs, "late"), total(theirs, "wake_ups"))
    result = {"rate_hz": options.rate, "soup_triangles": options.soup, "blocks": len(blocks), "seconds_each": options.seconds,
              "fifo": all(block["fifo"] for block in ours), "poisson_p": p,
              **{f"server_{key}": total(ours, key)
                 for key in ("ticks", "late", "missed", "allowance_spent", "contact_ticks", "faults", "allocations")},
              **{f"cyclictest_{key}": total(theirs, key) for key in ("wake_ups", "late", "missed")},
              **{f"server_{key}": max(block[key] for block in ours) for key in ("tick_p99_us", "tick_max_us")},
              "server_late_in_each_block": [block["late"] for block in ours],
              "cyclictest_late_in_each_block": [block["late"] for block in theirs]}
    result["pass"] = p > LEAST_P and result["server_faults"] == 0 and result["server_allocations"] == 0
    return result


def parse():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("bin", type=Path, help="folder of the programs")
    parser.add_argument("scene", type=Path)
    parser.add_argument("--assets", default="/usr/share/inventor/data")
    parser.add_argument("--soup", type=int, default=0, metavar="TRIANGLES", help="added to the scene, in place of the attack")
    parser.add_argument("--seconds", type=int, default=10, help="of each block")
    parser.add_argument("--blocks", type=int, default=20, help="an even number is fair to both")
    parser.add_argument("--rate", type=int, default=1000, help="Hz")
    options = parser.parse_args()
    options.server = options.bin / "haptic_server"
    sys.path.insert(0, str(options.bin.parent / "python"))
    return options


def main():
    options = parse()
    cpus = sorted(os.sched_getaffinity(0))[:2]
    needed = ("cyclictest",) if options.soup else ("cyclictest", "stress-ng")
    if len(cpus) < 2 or not all(map(shutil.which, needed)):
        print("needs two processors,", "rt-tests and", *needed, file=sys.stderr)
        return CANNOT_TELL
    blocks, attack, attacked = [], None, True
    with tempfile.TemporaryDirectory() as folder:
        if options.soup:
            soup = Path(folder) / "soup.stl"
            write_soup(soup, options.soup)
            text, options.scene = options.scene.read_text(), soup.with_suffix(".scene")
            options.scene.write_text(text + SOUP.format(file=soup.name))
        else:
            attack = Attack(options.bin, options.blocks * (options.seconds + 2) + 3 * WARM_UP_S, folder)
        try:
            time.sleep(WARM_UP_S if attack else 0)
            for i in range(options.blocks):
                blocks.append(run_block(options, cpus[::-1] if i % 2 else cpus, Path(folder)))
                attacked = attacked and (not attack or attack.running())
                print(f"block {i + 1}: server {blocks[-1][0]['late']} late, cyclictest {blocks[-1][1]['late']}", file=sys.stderr)
        finally:
            if attack:
                attack.end()
    result = result_of(options, blocks)
    print(json.dumps(result, indent=2))
    if not result["fifo"] or not attacked:
        print("the servo was not real-time, or the attack ended early: this tells nothing", file=sys.stderr)
        return CANNOT_TELL
    return 0 if result["pass"] else 1


if __name__ == "__main__":
    sys.exit(main())
