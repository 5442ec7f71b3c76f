"""How many instructions does a tick take? Counted by callgrind, so the same on every run and under any load, and
compared with the committed figures: fails when a tick takes more than 2 % above its figure.

usage: instruction_gate.py COUNT_INSTRUCTIONS [--update]    (--update writes the figures anew)
"""

import json
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

FIGURES = Path(__file__).with_name("instructions_per_tick.json")
ALLOWED = 1.02
SKIPPED = 77  # as CMake is told


def count(program, trajectory):
    """Instructions in the mean tick."""
    run = subprocess.run(
        ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", "--collect-atstart=no",
         "--toggle-collect=countedTicks", "--toggle-collect=countedSteps", "--toggle-collect=countedForce",
         program, trajectory],
        capture_output=True, text=True, check=True)
    return round(int(re.search(r"Collected : (\d+)", run.stderr).group(1)) / int(run.stdout), 1)


def main():
    program, update = sys.argv[1], "--update" in sys.argv
    if not shutil.which("valgrind"):
        print("skipped: valgrind is not installed")
        return SKIPPED
    figures = json.loads(FIGURES.read_text())
    with ThreadPoolExecutor(2) as pool:
        counted = dict(zip(figures, pool.map(lambda trajectory: count(program, trajectory), figures)))
    if update:
        FIGURES.write_text(json.dumps(counted, indent=2) + "\n")
    failed = False
    for trajectory, instructions in counted.items():
        worse = instructions > ALLOWED * figures[trajectory] and not update
        failed = failed or worse
        print(f"{trajectory:14} {instructions:8} instructions a tick, committed {figures[trajectory]}"
              + (": more than 2 % above" if worse else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
