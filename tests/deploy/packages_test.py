"""deploy/run installs what building and running needs and no more; what cannot be installed or built is said in one line, and
the next call goes on; --version says the same everywhere.

usage: packages_test.py PROGRAM... [-v]
"""
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]


def lib(script):
    """A process that has done what deploy/lib.sh does, and then the script."""
    return subprocess.run(["bash", "-euc", f"source {PROJECT}/deploy/lib.sh; {script}", "deploy/run"], capture_output=True,
                          text=True)


def missing(*sections, release=12):
    """As deploy/lib.sh finds them on a machine that has nothing."""
    done = lib(f"dpkg-query() {{ :; }}; of_release() {{ echo {release}; }}; missing_packages {' '.join(sections)}")
    assert done.returncode == 0, done.stderr
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

    def test_what_13_does_not_have_is_asked_of_12_alone(self):
        only = set(missing()) - set(missing(release=13))
        self.assertEqual(only, {"clang-14", "clang-format-14", "clang-tidy-14", "libclang-rt-14-dev"})
        self.assertLessEqual(set(missing(release=13)), set(missing()))


class Releases(unittest.TestCase):
    def check(self, text):
        with tempfile.NamedTemporaryFile("w") as file:
            file.write(text)
            file.flush()
            return lib(f"os_release={file.name}; check_release")

    def test_12_and_13_are_supported(self):
        for release in (12, 13):
            done = self.check(f"ID=debian\nVERSION_ID={release}\n")
            self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_what_is_made_from_debian_is_warned_of_and_tried(self):
        done = self.check('PRETTY_NAME="Grey 24.04"\nID=grey\nID_LIKE="blue debian"\nVERSION_ID=24.04\n')
        self.assertEqual(done.returncode, 0)
        self.assertEqual(done.stderr, "deploy/run: tested on Debian 12 and 13, not on Grey 24.04; going on\n")
        self.assertEqual(self.check("ID=debian\nPRETTY_NAME='Debian GNU/Linux sid'\n").returncode, 0)

    def test_others_are_named_with_what_works(self):
        for name, text in (("Debian 11", "ID=debian\nVERSION_ID=11\n"), ("Red 9", "ID=red\nID_LIKE=hat\n"), ("this system", "")):
            done = self.check(text and f'PRETTY_NAME="{name}"\n{text}')
            self.assertEqual(done.returncode, 1)
            self.assertIn(f"deploy/run: {name} is not supported; Debian 12 and 13 are", done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1)


class Refusals(unittest.TestCase):
    """deploy/run, deploy/test and deploy/package, with programs in the place of apt's, dpkg's and CMake."""

    COMMANDS = (["run", "--headless"], ["test"], ["test", "evaluation"], ["package"])

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.log = self.folder / "log"
        self.log.touch()
        self.fake("id", "echo 0")
        self.fake("dpkg", f"echo dpkg $* >>{self.log}")
        self.fake("apt-get", f"echo apt-get $* >>{self.log}")
        self.fake("apt-cache", "printf '%s\\n' " + " ".join(missing()))
        for name in ("cmake", "dpkg-buildpackage", "npm"):
            self.fake(name, "exit 1")
        self.installed()

    def fake(self, name, script):
        program = self.folder / name
        program.write_text(f"#!/bin/sh\n{script}\n")
        program.chmod(0o755)

    def installed(self, *packages):
        self.fake("dpkg-query", "printf 'ii %s\\n' " + " ".join(packages or ["nothing"]))

    def start(self, command, *arguments):
        return subprocess.Popen([PROJECT / "deploy" / command, *arguments], cwd=self.folder, text=True, stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
                                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # of a test in the background
                                env={**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"})

    def refusal(self, command):
        """The last line that a command says, which has to fail."""
        process = self.start(*command)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, errors)
        last = errors.splitlines()[-1]
        self.assertTrue(last.startswith(f"deploy/{command[0]}: "), errors)
        return last

    def interrupt(self, command):
        """What a command says that is interrupted once it has come to the program that sleeps."""
        process = self.start(*command)
        deadline = time.monotonic() + 60
        while "sleeps" not in self.log.read_text() and time.monotonic() < deadline:
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, errors)
        return errors

    def test_a_package_that_apt_does_not_know(self):
        self.fake("apt-get", 'case "$*" in install*) echo "E: Unable to locate package libnats-dev" >&2; exit 100; esac')
        self.fake("apt-cache", "printf '%s\\n' " + " ".join(set(missing()) - {"libnats-dev"}))
        for command in self.COMMANDS:
            with self.subTest(command):
                self.assertIn("apt knows no package libnats-dev;", self.refusal(command))

    def test_apt_asks_nothing_under_sudo(self):
        self.fake("id", "echo 1000")
        self.fake("sudo", 'exec env -i PATH="$PATH" "$@"')  # as sudo does by default
        self.fake("apt-get", f"echo apt-get frontend $DEBIAN_FRONTEND >>{self.log}")
        self.start("test").communicate(timeout=60)
        asked = [line for line in self.log.read_text().splitlines() if line.startswith("apt-get frontend")]
        self.assertEqual(asked[-1], "apt-get frontend noninteractive")

    def test_a_link_in_the_place_of_the_build(self):
        source = Path("/tmp/haptics-package")
        if source.exists() or source.is_symlink():
            self.skipTest(f"{source} is in use")
        self.installed(*missing())
        theirs = self.folder / "theirs"
        theirs.mkdir()
        (theirs / "kept").touch()
        source.symlink_to(theirs)
        self.addCleanup(source.unlink, missing_ok=True)
        self.assertIn("is not a folder of this user's", self.refusal(["package"]))
        self.assertTrue((theirs / "kept").exists())

    def test_no_network(self):
        self.fake("apt-get", 'echo "E: Temporary failure resolving" >&2; exit 100')
        for command in self.COMMANDS:
            with self.subTest(command):
                self.assertIn("apt could not fetch its lists (is there no network", self.refusal(command))

    def test_an_interrupt_while_packages_are_installed(self):
        going_on = f"echo apt-get $* >>{self.log}"
        for command in self.COMMANDS:
            with self.subTest(command):
                self.log.write_text("")
                self.fake("apt-get", f"echo sleeps >>{self.log}; exec sleep 60")
                self.assertIn("interrupted; the same command goes on from here", self.interrupt(command))
                self.log.write_text("")
                self.fake("apt-get", going_on)
                self.start(*command).communicate(timeout=60)
                called = self.log.read_text()
                self.assertIn("dpkg --configure -a", called)
                self.assertRegex(called, r"apt-get install (?!.*--simulate).* libvtk9-dev")

    def test_an_interrupt_while_it_builds(self):
        self.installed(*missing())
        self.fake("cmake", f"echo sleeps >>{self.log}; exec sleep 60")
        for command in self.COMMANDS[:3]:
            with self.subTest(command):
                self.log.write_text("")
                self.assertIn("interrupted; the same command goes on from here", self.interrupt(command))

    def test_a_build_that_fails_and_one_that_fills_the_disk(self):
        self.installed(*missing())
        for free, said in ((90_000_000, "build"), (2000, "the disk is full; make room")):
            self.fake("df", f"printf 'Avail\\n90000000\\n{free}\\n'")
            for command in self.COMMANDS[:3]:
                with self.subTest(command, free=free):
                    self.assertIn(said, self.refusal(command))


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
