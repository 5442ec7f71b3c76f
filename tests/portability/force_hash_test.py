"""The forces of every demo scene are the same whatever code the C library takes for this processor and with what the state has
beside its fields made anew at every tick, and all scenes are touched.

usage: force_hash_test.py FORCE_HASH SCENE...
"""
import os
import re
import subprocess
import sys

TICKS = "2000"
# Names of glibc 2.36 and of later ones; unknown ones are ignored.
OLD_PROCESSOR = "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX2_Usable"


def felt(*options, tunables=""):
    program, scenes = sys.argv[1], sys.argv[2:]
    run = subprocess.run([program, "--ticks", TICKS, *options, "--folder", "/usr/share/inventor/data", *scenes],
                         capture_output=True, text=True, check=True, env={**os.environ, "GLIBC_TUNABLES": tunables})
    return run.stdout


def main():
    here, there, dropped = felt(), felt(tunables=OLD_PROCESSOR), felt("--drop-caches")
    print(here)
    bad = [line for line in here.splitlines() if re.search(r" 0\.0 % in contact", line)]
    bad += [f"{a}   or   {b}" for other in (there, dropped) for a, b in zip(here.splitlines(), other.splitlines()) if a != b]
    print("\n".join(bad))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
