"""Experiments with the simulated participant: on a server, killed and resumed, and whether the threshold that was put in
comes out.

usage: experiments.py [-v]

HAPTICS_SEEDS: sessions of each experiment whose interval is looked at (4). HAPTICS_KILLS: times that one is killed (2).
"""
import csv
import importlib
import json
import os
import random
import signal
import subprocess
import sys
import time
import unittest

import harness
from haptic_client import Client
from haptic_experiment.felt import NothingFelt
from haptic_experiment.methods import method_named
from haptic_experiment.participants import SIMULATED, SimulatedParticipant, threshold_percent
from haptic_experiment.psychometric import NoThreshold, fit
from haptic_experiment.runner import MAX_REPEATS, Runner
from haptic_experiment.sessions import Interrupted, ServerSession, WorldSession
from haptic_experiment.trial_log import TrialLog, read

EXAMPLES = harness.PROJECT / "graphics_client/script/python/examples"
NAMES = ("stiffness_jnd", "friction_jnd", "grating_wavelength", "guidance_jnd")
SEEDS, KILLS = (int(os.environ.get(name, few)) for name, few in (("HAPTICS_SEEDS", 4), ("HAPTICS_KILLS", 2)))
WEBER, TRIALS = 0.1, 120
INSIDE = 0.9      # of the sessions' intervals hold the threshold that was put in
FEWEST = 20       # sessions, below which that is not asked: two may miss
LEVEL, ESTIMATE = 30, 0.03  # of a stimulus, and by how much its estimate by the server's led hand is off at most
LIVE_TRIALS, KILLED_TRIALS = 1, 150
SCENE = 'operations { add { name: "plate" mesh { sphere { radius_m: 0.01 segments: 4 } } } }'  # which the experiments replace
STONE = 'operations { add { name: "stone" mesh { sphere { radius_m: 0.01 segments: 4 } } pose { position { x: 0.3 } } } }'

sys.path.insert(0, str(EXAMPLES))


def experiment_named(name):
    return importlib.import_module(name).EXPERIMENT


def started(name, folder, *arguments):
    return subprocess.Popen([sys.executable, "-B", EXAMPLES / f"{name}.py", "--participant", "model", "--out", folder,
                             *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                            stdin=subprocess.DEVNULL)


def finished(process, timeout_s=600):
    """(exit status, output, errors)"""
    output, errors = process.communicate(timeout=timeout_s)
    return process.returncode, output, errors


def trials_of(log):
    """What must be the same however often a session was interrupted."""
    keys = "trial", "level", "staircase", "order", "answer", "correct"
    return [tuple(answer[key] for key in keys) for answer in read(log)[1]]


class OnAServer(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.server = self.start_server(scene=SCENE)

    def test_each_example_runs_and_marks_what_is_simulated(self):
        import h5py
        for name in NAMES:
            with self.subTest(name):
                code, output, errors = finished(started(name, self.folder, "--simulated", "--connect", self.server.address,
                                                        "--trials", LIVE_TRIALS))
                self.assertEqual(code, 0, output + errors)
                stem = self.folder / f"{name}-model"
                header, answers = read(f"{stem}.jsonl")
                self.assertEqual([answer["trial"] for answer in answers], list(range(1, LIVE_TRIALS + 1)))
                self.assertEqual(header["simulated"]["what"], SIMULATED)
                self.assertIn(SIMULATED, output)
                with open(f"{stem}.csv", newline="") as file:
                    self.assertEqual([row["simulated"] for row in csv.DictReader(file)], LIVE_TRIALS * [SIMULATED])
                with h5py.File(f"{stem}.h5") as file:
                    self.assertEqual(file.attrs["simulated"], SIMULATED)
                    self.assertEqual(file["trials/level"].attrs["units"], "%")
                    self.assertEqual(len(file["trials/level"]), LIVE_TRIALS)
                for kind in ("md", "svg"):
                    self.assertIn(SIMULATED, (self.folder / f"{name}-model.{kind}").read_text().replace("<!-- ", ""))
                self.assertNotRegex(output, r"level \d|interval 1|interval 2")  # blind

    def test_the_led_hand_estimates_what_is_there(self):
        for name in NAMES:
            experiment = experiment_named(name)
            session = ServerSession(self.server.address, experiment.scene, leads=True)
            try:
                scale = 1000 if experiment.value_unit == "mm" else 1
                value = experiment.value(LEVEL)
                session.apply(experiment.stimulus(value))
                estimate = scale * self.estimate(experiment, session)
                print(f"\n{name}: {estimate:.4g} {experiment.value_unit} of {value:g}", end="", flush=True)
                self.assertAlmostEqual(estimate / value, 1, delta=ESTIMATE)
            finally:
                session.close()

    def estimate(self, experiment, session):
        """A machine that holds processes up voids intervals, as it does in a session."""
        for _ in range(MAX_REPEATS):
            try:
                return experiment.estimate(session.explore(experiment.exploration))
            except (Interrupted, NothingFelt) as error:
                print(f"\nagain: {error}", end="", flush=True)
        raise AssertionError("no interval was sound")

    def test_a_trial_in_which_the_server_ends_is_repeated_with_its_stimuli(self):
        program = started("stiffness_jnd", self.folder, "--simulated", "--connect", self.server.address,
                          "--trials", LIVE_TRIALS + 1)
        self.addCleanup(program.kill)
        self.read_until("trial 1 of", program)
        self.server.kill()
        self.read_until("trial 2 is repeated", program)
        self.start_server(scene=SCENE, listen=self.server.address)
        code, output, errors = finished(program)
        self.assertEqual(code, 0, output + errors)
        log = self.folder / "stiffness_jnd-model.jsonl"
        self.assertEqual([trial[0] for trial in trials_of(log)], list(range(1, LIVE_TRIALS + 2)))
        events = [json.loads(line) for line in log.read_text().splitlines()]
        begun, answered = ([tuple(event[key] for key in ("trial", "level", "order")) for event in events if event["event"] == kind]
                           for kind in ("trial", "answer"))
        self.assertEqual(begun, answered)
        self.assertGreaterEqual(sum(event["event"] == "interrupted" for event in events), 1)

    def read_until(self, beginning, program):
        said = []
        while not said or not said[-1].startswith(beginning):
            said.append(program.stdout.readline())
            self.assertTrue(said[-1], said)

    def test_what_cannot_be_run_is_refused_with_the_reason(self):
        connect = "--simulated", "--connect", self.server.address, "--trials", 1
        with Client(self.server.address, "somebody", telemetry_hz=100) as client:
            with client.hand():
                self.assert_refused("the hand is led by somebody", *connect)
            client.apply(STONE)
        self.assert_refused("the server's scene holds stone", *connect)

    def assert_refused(self, why, *arguments):
        code, output, errors = finished(started("friction_jnd", self.folder, *arguments))
        self.assertEqual((code, output), (3, ""))
        self.assertIn(why, errors)
        self.assertFalse((self.folder / "friction_jnd-model.jsonl").exists())


class InProcess(harness.EndToEnd):
    def test_killed_at_random_moments_no_trial_is_lost_or_doubled(self):
        unbroken, killed = self.folder / "unbroken", self.folder / "killed"
        arguments = "--simulated", "--in-process", "--trials", KILLED_TRIALS
        code, output, errors = finished(started("stiffness_jnd", unbroken, *arguments))
        self.assertEqual(code, 0, output + errors)
        random_moment = random.Random(1)
        said, log = set(), killed / "stiffness_jnd-model.jsonl"
        for kill in range(KILLS):
            program = started("stiffness_jnd", killed, *arguments, *(["--resume"] if kill else []))
            lines = random_moment.randrange(2 * KILLED_TRIALS // KILLS + 1)
            for line in program.stdout:
                said.update([int(line.split()[1])] if "answered" in line and line.startswith("trial") else [])
                lines -= 1
                if lines < 0:
                    break
            time.sleep(random_moment.uniform(0, 0.01))
            program.send_signal(signal.SIGKILL)
            program.stderr.close()
            said.update(int(line.split()[1]) for line in program.stdout if line.startswith("trial") and "answered\n" in line)
            program.stdout.close()
            program.wait()
            numbers = [trial[0] for trial in trials_of(log)] if log.exists() and log.read_bytes().count(b"\n") else []
            self.assertEqual(numbers, list(range(1, len(numbers) + 1)))
            self.assertLessEqual(said, set(numbers))
        code, output, errors = finished(started("stiffness_jnd", killed, *arguments, "--resume"))
        self.assertEqual(code, 0, output + errors)
        self.assertEqual(trials_of(log), trials_of(unbroken / log.name))
        self.assertEqual(len(trials_of(log)), KILLED_TRIALS)
        print(f"\n{KILLS} kills, {KILLED_TRIALS} trials as in the unbroken run", end="", flush=True)

    def test_ctrl_c_says_how_to_go_on(self):
        program = started("stiffness_jnd", self.folder, "--simulated", "--in-process", "--trials", 5000)
        for _ in range(5):
            program.stdout.readline()
        program.send_signal(signal.SIGINT)
        code, output, errors = finished(program)
        self.assertEqual((code, errors), (130, ""))
        self.assertRegex(output, r"interrupted; the trial under way is not counted\. \d+ answered trials are in .* "
                                 r"go on with: .*--resume")

    def test_the_interval_holds_the_threshold_that_was_put_in(self):
        true = threshold_percent(WEBER)
        for name in NAMES:
            with self.subTest(name):
                experiment = experiment_named(name)
                session = WorldSession(experiment.scene)
                intervals = [self.interval(experiment, session, seed) for seed in range(SEEDS)]
                inside = sum(low <= true <= high for low, high in intervals)
                print(f"\n{name}: {true:.2f} % inside the interval of {inside} of {SEEDS} seeds", end="", flush=True)
                self.assertGreaterEqual(inside, INSIDE * SEEDS if SEEDS >= FEWEST else SEEDS - 2)

    def interval(self, experiment, session, seed):
        """Of a session; of none where there is no threshold."""
        method = method_named("weighted", experiment.lowest, experiment.highest, TRIALS, seed)
        with TrialLog(self.folder / f"{experiment.name}-{seed}.jsonl", {"seed": seed}) as log:
            Runner(experiment, method, seed, SimulatedParticipant(WEBER, seed), session, log, lambda line: None).run()
        try:
            found = fit([(answer["level"], answer["correct"]) for answer in read(log.path)[1]])
        except NoThreshold:
            return 0, 0
        return found.low, found.high


if __name__ == "__main__":
    unittest.main()
