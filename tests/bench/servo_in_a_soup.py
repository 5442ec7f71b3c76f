"""Does the server miss ticks in a scene that no tree sorts well? The demo scene and a soup, random triangles each as long as
the cube of 0.1 m that they lie in, explored by the simulated hand; haptic_server (FIFO, pinned) and cyclictest (rt-tests),
with the same period and priority, run in the same instant, each on a processor of its own, and from block to block they
change places. Compared are wake-ups later than a period, as Poisson counts. Prints JSON; exits with 1 when the two can
hardly be of one rate (p <= 0.001), a fault came up, or the servo touched the heap, with 2 when the machine cannot tell.

usage: servo_in_a_soup.py BIN DEMO_SCENE [--triangles N] [--seconds N] [--blocks N] [--rate HZ] [--assets FOLDER]
"""

import argparse
import json
import os
import random
import shutil
import struct
import sys
import tempfile
from pathlib import Path

from servo_under_attack import CANNOT_TELL, LEAST_P, poisson_p, run_block

SOUP = """
operations {{ add {{ name: "soup" mesh {{ file: "{file}" }}
                     pose {{ position {{ x: 0.045 y: 0.02 z: 0.1 }} }} material {{ stiffness_N_per_m: 600 }} }} }}
"""


def write_soup(file, triangles, edge_m=0.1):
    """Binary STL: corners anywhere in a cube about the origin."""
    draw = random.Random(1)
    corner = lambda: [draw.uniform(-edge_m / 2, edge_m / 2) for _ in range(9)]
    with open(file, "wb") as out:
        out.write(bytes(80) + struct.pack("<I", triangles))
        for _ in range(triangles):
            out.write(struct.pack("<12fH", 0, 0, 0, *corner(), 0))


def parse():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("bin", type=Path, help="folder of the programs")
    parser.add_argument("demo", type=Path, help="scene that the soup is added to")
    parser.add_argument("--assets", default="/usr/share/inventor/data")
    parser.add_argument("--triangles", type=int, default=60_000)
    parser.add_argument("--seconds", type=int, default=30, help="of each block")
    parser.add_argument("--blocks", type=int, default=2, help="an even number is fair to both")
    parser.add_argument("--rate", type=int, default=1000, help="Hz")
    options = parser.parse_args()
    options.server = options.bin / "haptic_server"
    sys.path.insert(0, str(options.bin.parent / "python"))
    return options


def main():
    options = parse()
    cpus = sorted(os.sched_getaffinity(0))[:2]
    if len(cpus) < 2 or not shutil.which("cyclictest"):
        print("needs two processors and cyclictest (rt-tests)", file=sys.stderr)
        return CANNOT_TELL
    blocks = []
    with tempfile.TemporaryDirectory() as folder:
        soup = Path(folder) / "soup.stl"
        write_soup(soup, options.triangles)
        options.scene = Path(folder) / "soup.scene"
        options.scene.write_text(options.demo.read_text() + SOUP.format(file=soup.name))
        for i in range(options.blocks):
            blocks.append(run_block(options, cpus[::-1] if i % 2 else cpus, Path(folder)))
            print(f"block {i + 1}: server {blocks[-1][0]['late']} late, cyclictest {blocks[-1][1]['late']}", file=sys.stderr)
    ours, theirs = ([pair[side] for pair in blocks] for side in (0, 1))
    total = lambda side, key: sum(block[key] for block in side)
    p = poisson_p(total(ours, "late"), total(ours, "ticks"), total(theirs, "late"), total(theirs, "wake_ups"))
    result = {"rate_hz": options.rate, "triangles": options.triangles, "blocks": options.blocks,
              "seconds_each": options.seconds, "fifo": all(block["fifo"] for block in ours), "poisson_p": p,
              **{f"server_{key}": total(ours, key)
                 for key in ("ticks", "late", "missed", "allowance_spent", "contact_ticks", "faults", "allocations")},
              "server_tick_p99_us": max(block["tick_p99_us"] for block in ours),
              "server_tick_max_us": max(block["tick_max_us"] for block in ours),
              "cyclictest_wake_ups": total(theirs, "wake_ups"), "cyclictest_late": total(theirs, "late")}
    result["pass"] = p > LEAST_P and result["server_faults"] == 0 and result["server_allocations"] == 0
    print(json.dumps(result, indent=2))
    if not result["fifo"]:
        print("the servo was not real-time: this tells nothing", file=sys.stderr)
        return CANNOT_TELL
    return 0 if result["pass"] else 1


if __name__ == "__main__":
    sys.exit(main())
