"""deploy/run installs what building and running needs and no more; --version says the same everywhere.

usage: packages_test.py PROGRAM... [-v]
"""
import re
import subprocess
import sys
import unittest
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]


def missing(*sections):
    """As deploy/lib.sh finds them on a machine that has nothing."""
    script = f"source {PROJECT}/deploy/lib.sh; dpkg-query() {{ :; }}; missing_packages {' '.join(sections)}"
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    return done.stdout.split()


class Packages(unittest.TestCase):
    def test_running_installs_little_more_than_half_of_the_list(self):
        run, everything = missing("Build", "Run"), missing("Build", "Run", "Test")
        self.assertLess(set(run), set(everything))
        self.assertLessEqual(len(run), 0.55 * len(everything))
        self.assertEqual(sorted([*run, *missing("Test")]), sorted(everything))
        self.assertEqual(sorted([*everything, *missing("Package", "Aarch64")]), sorted(missing()))

    def test_what_runs_needs_is_there_and_what_tests_need_is_not(self):
        run = missing("Build", "Run")
        for package in ("g++", "libvtk9-dev", "inventor-data", "xvfb"):
            self.assertIn(package, run)
        for package in ("libgtest-dev", "valgrind", "clang-14", "libcgal-dev"):
            self.assertNotIn(package, run)


class Versions(unittest.TestCase):
    def test_every_program_says_the_projects(self):
        version = re.search(r"^project\(haptics VERSION (\S+)", (PROJECT / "CMakeLists.txt").read_text(), re.MULTILINE)[1]
        for program in PROGRAMS:
            with self.subTest(program):
                done = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
                self.assertEqual(done.stdout, f"{Path(program).name} {version}\n")


if __name__ == "__main__":
    PROGRAMS = [argument for argument in sys.argv[1:] if not argument.startswith("-")]
    sys.argv[1:] = [argument for argument in sys.argv[1:] if argument.startswith("-")]
    unittest.main()
