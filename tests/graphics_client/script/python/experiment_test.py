"""Methods, log, fit and simulated participant of haptic_experiment, without a server.

usage: experiment_test.py [-v]
"""
import errno
import json
import math
import shutil
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy

from haptic_client import NotLeading
from haptic_experiment import command_line
from haptic_experiment.design import Experiment, Press, Sequence, percent_above
from haptic_experiment.felt import Felt, NothingFelt, friction_coefficient, stiffness_N_per_m, wavelength_m
from haptic_experiment.methods import METHODS, ConstantStimuli, Interleaved, Quest, Staircase, draw, method_named
from haptic_experiment.participants import SIMULATED, Person, SimulatedParticipant, threshold_percent
from haptic_experiment.psychometric import FAMILIES, NoThreshold, fit, psi
from haptic_experiment.results import Results
from haptic_experiment.runner import MAX_REPEATS, GivenUp, Runner
from haptic_experiment.sessions import Interrupted, ServerSession, SessionRefused
from haptic_experiment.trial_log import LogFailed, LogRefused, TrialLog, read

LOWEST, HIGHEST = 2, 50
COVERAGE_SEEDS, LEAST_COVERED = 60, 52  # 0.05 % of intervals that hold the truth in 95 % of cases are worse


def answers_of(proportion, method, seed):
    """(level, correct) of an observer who is right in this proportion of cases at each level."""
    trials = []
    while stimulus := method.next():
        correct = draw(seed, "answer", len(trials)) < proportion(stimulus.level)
        trials.append((stimulus.level, correct))
        method.answered(correct)
    return trials


class Methods(unittest.TestCase):
    def levels(self, method, answers):
        shown = []
        for correct in answers:
            shown.append(method.next().level)
            method.answered(correct)
        return shown

    def test_one_up_two_down(self):
        method = Staircase(16, 1, 64, 12, down_after=2, up_weight=1, ratio=2)
        # Steps by 4 until the second reversal, by 2 from then on.
        self.assertEqual(self.levels(method, (1, 1, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1)), [16, 16, 4, 4, 1, 4, 4, 2, 2, 1, 2, 2])
        self.assertEqual(method.reversals, [1, 4, 1, 2])
        self.assertIsNone(method.next())

    def test_weighted_steps_are_in_the_ratio_that_the_target_implies(self):
        method = Staircase.weighted(10, 1, 100, 40, target=0.75)
        shown = self.levels(method, (1, 0, 1, 0, 1, 0, 1, 0, 1))
        up, down = shown[8] / shown[7], shown[7] / shown[6]
        self.assertAlmostEqual(math.log(up) / -math.log(down), 3, places=4)

    def test_staircases_converge_where_they_should(self):
        def proportion(level):
            return psi("weibull", math.log10(level), 1, 1.5, 0)
        for staircase, target in ((Staircase, 0.5 ** 0.5), (Staircase.weighted, 0.75)):
            trials = answers_of(proportion, staircase(10, 1, 100, 4000), 1)[200:]
            self.assertAlmostEqual(proportion(10 ** numpy.mean([math.log10(level) for level, _ in trials])), target, delta=0.03)

    def test_quest_converges_on_its_threshold(self):
        trials = answers_of(lambda level: 0.99 - 0.49 * math.exp(-(level / 7) ** 1.3), Quest(20, LOWEST, HIGHEST, 400), 2)
        self.assertAlmostEqual(trials[-1][0], 7, delta=1)

    def test_constant_stimuli_show_each_level_once_a_block(self):
        method = ConstantStimuli([1, 2, 3, 4], 5, 7)
        shown = self.levels(method, [True] * 20)
        blocks = [shown[at:at + 4] for at in range(0, 20, 4)]
        self.assertTrue(all(sorted(block) == [1, 2, 3, 4] for block in blocks))
        self.assertGreater(len({tuple(block) for block in blocks}), 1)

    def test_levels_stay_between_the_ends(self):
        for name in METHODS:
            for correct in (True, False):
                shown = [level for level, _ in answers_of(lambda level, c=correct: 2 * c, method_named(name, 2, 50, 70, 1), 1)]
                self.assertTrue(all(2 <= level <= 50 for level in shown), (name, shown))

    def test_a_resumed_method_is_the_unbroken_one_at_every_cut(self):
        for name in METHODS:
            whole, given = self.sequence(name), []
            trials = []
            while trial := whole.next():
                trials.append(trial)
                given.append(1 if draw(5, "answer", trial.number) < 0.5 else 2)
                whole.answered(given[-1])
            for cut in range(len(trials)):
                resumed = self.sequence(name)
                for answer in given[:cut]:
                    resumed.answered(answer)
                self.assertEqual(resumed.next(), trials[cut], (name, cut))

    def test_another_seed_is_another_order(self):
        orders = []
        for seed in (1, 2):
            sequence = self.sequence("constant", seed)
            order = []
            while trial := sequence.next():
                order.append((trial.level, trial.order))
                sequence.answered(1)
            orders.append(order)
        self.assertNotEqual(*orders)
        self.assertAlmostEqual(numpy.mean([order for _, order in orders[0]]), 1.5, delta=0.25)

    def sequence(self, name, seed=3):
        return Sequence(method_named(name, LOWEST, HIGHEST, 42, seed), seed)

    def test_bad_parameters_are_named(self):
        for make, field in ((lambda: Staircase(1, 2, 50, 10), "start"), (lambda: Staircase.weighted(9, 2, 50, 10, 0.4), "target"),
                            (lambda: Quest(99, 2, 50, 10), "guess"), (lambda: ConstantStimuli([0, 1], 2, 1), "levels"),
                            (lambda: method_named("guess", 2, 50, 10, 1), "method"),
                            (lambda: SimulatedParticipant(0, 1), "weber"), (lambda: threshold_percent(2), "weber")):
            with self.assertRaisesRegex(ValueError, f"^{field} is|^{field} are"):
                make()


class Fits(unittest.TestCase):
    def test_the_interval_holds_the_truth_as_often_as_it_says(self):
        for family in FAMILIES:
            for name in ("constant", "weighted"):
                held = 0
                for seed in range(COVERAGE_SEEDS):
                    def proportion(level):
                        return psi(family, math.log10(level), 1, 1.5, 0.01)
                    found = fit(answers_of(proportion, method_named(name, 3, 40, 140, seed), seed), family)
                    held += found.low <= 10 <= found.high
                self.assertGreaterEqual(held, LEAST_COVERED, (family, name))

    def test_many_answers_give_what_was_put_in(self):
        for family in FAMILIES:
            method = ConstantStimuli([4, 6, 9, 12, 20, 40], 2000, 1)
            found = fit(answers_of(lambda level: psi(family, math.log10(level), 1, 2, 0.02), method, 1), family)
            self.assertAlmostEqual(found.threshold, 10, delta=0.4)
            self.assertAlmostEqual(found.slope, 2, delta=0.2)
            self.assertAlmostEqual(found.lapse_rate, 0.02, delta=0.01)
            self.assertLess(found.high / found.low, 1.15)

    def test_what_determines_no_threshold_is_said_in_words(self):
        levels = [2, 4, 8, 16, 32] * 12
        for trials, why in (([(level, True) for level in levels], "every answer is correct.*Smaller levels"),
                            ([(level, False) for level in levels], "every answer is wrong"),
                            ([(level, index % 2 == 0) for index, level in enumerate(levels)], "upper end|beyond the levels"),
                            ([(level, level < 10) for level in levels], "upper end|beyond the levels"),
                            ([(8, index % 4 > 0) for index in range(60)], "one level"),
                            ([(2, True), (4, False)], "2 trials are too few")):
            with self.assertRaisesRegex(NoThreshold, why):
                fit(trials)


class Simulation(unittest.TestCase):
    def test_the_threshold_is_that_of_the_noise(self):
        for weber in (0.05, 0.2):
            x = threshold_percent(weber) / 100
            noise = numpy.random.default_rng(1).standard_normal((2, 400_000))
            right = (1 + x) * (1 + weber * noise[0]) > 1 + weber * noise[1]
            self.assertAlmostEqual(right.mean(), 0.75, delta=0.003)

    def test_it_answers_by_what_was_felt_and_the_same_again(self):
        participant = SimulatedParticipant(0.01, 1)
        experiment = mock.Mock(estimate=lambda felt: felt)
        experiment.name = "x"
        trials = [mock.Mock(number=number) for number in range(40)]
        self.assertEqual({participant.answer(None, experiment, trial, (1.2, 1)) for trial in trials}, {1})
        self.assertEqual({participant.answer(None, experiment, trial, (1, 1.2)) for trial in trials}, {2})
        even = [[participant.answer(None, experiment, trial, (1, 1)) for trial in trials] for _ in range(2)]
        self.assertEqual(*even)
        self.assertEqual(set(even[0]), {1, 2})

    def test_a_participant_that_feels_nothing_invents_no_answer(self):
        with self.assertRaises(Interrupted):
            experiment = mock.Mock(estimate=stiffness_N_per_m)
            SimulatedParticipant(0.1, 1).answer(None, experiment, mock.Mock(number=1), (felt(0), felt(0)))


def felt(count, force=lambda x: numpy.full(len(x), 1.5), friction=0.0):
    """A stroke along x over 50 mm."""
    x = numpy.linspace(0, 0.05, count)
    forces = numpy.stack([-friction * force(x), 0 * x, force(x)], axis=-1)
    return Felt(numpy.arange(count), numpy.stack([x, 0 * x, 0 * x], axis=-1), forces, numpy.tile([0., 0, 1], (count, 1)),
                force(x) / 600, 1000)


class Estimates(unittest.TestCase):
    def test_of_what_is_known(self):
        self.assertAlmostEqual(stiffness_N_per_m(felt(300)), 600)
        self.assertAlmostEqual(friction_coefficient(felt(300, friction=0.3)), 0.3)
        for wavelength in (0.002, 0.003, 0.0047):
            found = wavelength_m(felt(600, lambda x: 1 + 0.1 * numpy.sin(2 * math.pi * x / wavelength + 1)))
            self.assertAlmostEqual(found / wavelength, 1, delta=0.005)

    def test_of_nothing_there_is_none(self):
        with self.assertRaises(NothingFelt):
            friction_coefficient(felt(3))


PLATE = 'operations { add { name: "plate" mesh { box { size_m { x: 0.1 y: 0.1 z: 0.1 } } } } }'
EXPERIMENT = Experiment("x", 1, "?", "level", "%", "stiffness", "N/m", LOWEST, HIGHEST, "", percent_above(600),
                        lambda value: f"{value}", Press((0, 0, 0), (0, 0, 1), 1, 0.1), stiffness_N_per_m)


class FakeSession:
    """Forces of whatever stiffness it was asked for; interrupted where `interrupts` says so."""
    def __init__(self, interrupts=lambda presentation: False):
        self._interrupts, self.presented, self.recovered = interrupts, [], 0

    def apply(self, transaction):
        self.presented.append(transaction)
        if self._interrupts(len(self.presented)):
            raise Interrupted("the server has gone")

    def explore(self, exploration):
        pressed = felt(50)
        penetration_m = pressed.normal_force_N / float(self.presented[-1])
        return Felt(pressed.tick, pressed.hip_m, pressed.force_N, pressed.normal, penetration_m, 1000)

    def recover(self, timeout_s):
        self.recovered += 1


class Logs(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="haptics-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.path = self.folder / "session.jsonl"

    def header(self, **changed):
        method = method_named("weighted", LOWEST, HIGHEST, 30, 1)
        return {"experiment": "x", "participant": "anna", "seed": 1, "simulated": None, "device": "d", "server": "s",
                "started": "t", "definition": EXPERIMENT.definition(method), "definition_sha256": "h", **changed}

    def run_session(self, resume=False, session=None, path=None):
        with TrialLog(path or self.path, self.header(), resume) as log:
            said = []
            runner = Runner(EXPERIMENT, method_named("weighted", LOWEST, HIGHEST, 30, 1), 1, SimulatedParticipant(0.1, 1),
                            session or FakeSession(), log, said.append)
            runner.run()
        return said

    def answers(self, path=None):
        return [tuple(answer[key] for key in ("trial", "level", "staircase", "order", "answer", "correct"))
                for answer in read(path or self.path)[1]]

    def test_cut_at_any_line_or_in_it_a_session_resumes_as_the_unbroken_one(self):
        self.run_session()
        whole, data = self.answers(), self.path.read_bytes()
        lines = data.splitlines(keepends=True)
        ends = [sum(map(len, lines[:count])) for count in range(len(lines) + 1)]
        for cut in sorted({end + more for end in ends for more in (-1, 0, 1, 40)} & set(range(len(data) + 1))):
            self.path.write_bytes(data[:cut])
            self.run_session(resume=True)
            self.assertEqual(self.answers(), whole, cut)
        self.assertEqual([trial[0] for trial in whole], list(range(1, 31)))

    def test_a_log_that_is_there_is_not_overwritten(self):
        self.run_session()
        before = self.path.read_bytes()
        with self.assertRaisesRegex(LogRefused, "with 30 answered trials; go on with --resume"):
            self.run_session()
        self.assertEqual(self.path.read_bytes(), before)

    def test_a_log_of_another_session_is_refused_by_the_field_that_differs(self):
        TrialLog(self.path, self.header()).close()
        other = self.header()["definition"]
        other["method"]["staircases"][1]["trials"] = 99
        for changed, field, there in (({"seed": 2}, "seed", "1"), ({"participant": "bob"}, "participant", '"anna"'),
                                      ({"experiment": "y"}, "experiment", '"x"'), ({"simulated": {"w": 1}}, "simulated", "null")):
            with self.assertRaisesRegex(LogRefused, f"{field} is {there} there.*would have to be {there}"):
                TrialLog(self.path, self.header(**changed), resume=True)
        changed = self.header()
        changed["definition"]["highest"] = 40
        with self.assertRaisesRegex(LogRefused, "definition.highest is 50 there and 40 here; to resume it would have to be 50"):
            TrialLog(self.path, changed, resume=True)

    def test_a_log_that_was_changed_is_refused(self):
        self.run_session()
        lines = self.path.read_text().splitlines(keepends=True)
        doubled = lines + lines[-1:]
        missing = lines[:5] + lines[9:]
        for changed, why in ((doubled, "trial 31 is"), (missing, "trial 3 is|trial 2 is"), (lines[1:], "no header in line 1"),
                             (lines[:3] + ["{]\n"] + lines[3:], "line 4 is no event")):
            self.path.write_text("".join(changed))
            with self.assertRaisesRegex(LogRefused, why):
                self.run_session(resume=True)

    def test_two_processes_do_not_write_one_log(self):
        with TrialLog(self.path, self.header()):
            with self.assertRaisesRegex(LogRefused, "another process"):
                TrialLog(self.path, self.header(), resume=True)

    def test_a_full_disk_stops_the_session_and_the_trial_does_not_count(self):
        import os
        write, written = os.write, []

        def full(file, data):
            written.append(data)
            if len(written) < 8:
                return write(file, data)
            write(file, data[:20])
            raise OSError(errno.ENOSPC, "No space left on device")
        with mock.patch("os.write", full), self.assertRaisesRegex(LogFailed, "cannot be written: No space left"):
            self.run_session()
        self.assertTrue(self.path.read_bytes().endswith(b"}\n"))
        answered = len(self.answers())
        self.assertEqual(answered, 3)
        self.run_session(resume=True)
        self.run_session(path=self.folder / "whole.jsonl")
        self.assertEqual(self.answers(), self.answers(self.folder / "whole.jsonl"))

    def test_each_event_is_on_the_disk_before_the_next_thing_happens(self):
        with mock.patch("os.fsync") as fsync:
            self.run_session()
        self.assertGreaterEqual(fsync.call_count, 1 + 2 * 30)

    def test_an_interrupted_trial_is_repeated_with_the_same_stimuli(self):
        self.run_session(path=self.folder / "whole.jsonl")
        session = FakeSession(lambda presentation: presentation in (6, 9))
        said = self.run_session(session=session)
        self.assertEqual(self.answers(), self.answers(self.folder / "whole.jsonl"))
        self.assertEqual(session.recovered, 2)
        self.assertIn("trial 3 is repeated: the server has gone", said)
        self.assertEqual(session.presented[4:6], session.presented[6:8])

    def test_a_trial_that_is_always_interrupted_is_given_up(self):
        with self.assertRaisesRegex(GivenUp, f"trial 2 was interrupted {MAX_REPEATS} times"):
            self.run_session(session=FakeSession(lambda presentation: presentation > 2))
        self.assertEqual(len(self.answers()), 1)

    def test_the_experimenter_is_blind(self):
        self.assertEqual(self.run_session()[4], "trial 5 of 30 answered")


class OnADevice(unittest.TestCase):
    def test_a_device_that_a_person_holds_has_no_simulated_participant(self):
        client = mock.Mock()
        client.objects.return_value = {}
        client.apply.return_value = mock.Mock(revision=1), 1
        client.hand.return_value.__enter__ = mock.Mock(side_effect=NotLeading("a person holds the device"))
        with mock.patch("haptic_experiment.sessions.Client", return_value=client):
            with self.assertRaisesRegex(SessionRefused, "a simulated participant needs .*: a person holds the device"):
                ServerSession("127.0.0.1:1", PLATE, leads=True)
            ServerSession("127.0.0.1:1", PLATE, leads=False).close()

    def test_a_button_that_goes_down_is_the_answer(self):
        session = mock.Mock()
        session.samples.return_value = [mock.Mock(device_buttons=buttons) for buttons in (1, 3, 0, 3, 0, 4, 6)]
        self.assertEqual(Person("button", say=lambda line: None).answer(session, EXPERIMENT, None, None), 2)


class Report(unittest.TestCase):
    def test_it_marks_what_is_simulated_and_gives_units(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "session.jsonl"
            header = Logs.header(None, simulated=SimulatedParticipant(0.1, 1).describe())
            with TrialLog(path, header) as log:
                Runner(EXPERIMENT, method_named("weighted", LOWEST, HIGHEST, 30, 1), 1, SimulatedParticipant(0.1, 1), FakeSession(),
                       log, lambda line: None).run()
            results = Results(*read(path))
            report = results.report("session")
            self.assertIn(f"**{SIMULATED}.** No person took part", report)
            self.assertRegex(report, r"hreshold \(75 % correct\) [\d.]+ %, 95 % interval [\d.]+ to [\d.]+ %, of 30 trials|"
                                     r"No threshold: ")
            self.assertEqual({unit for name, unit, *_ in results.columns() if name.endswith("force_N")}, {"N"})
            self.assertEqual(json.loads(path.read_text().splitlines()[0])["simulated"]["what"], SIMULATED)


class CommandLine(unittest.TestCase):
    def test_the_command_that_goes_on_is_one_for_a_shell(self):
        with tempfile.TemporaryDirectory() as folder:
            given, experiment = mock.Mock(out=folder, participant="p1"), mock.Mock()
            experiment.name = "study"
            Path(folder, "study-p1.jsonl").touch()
            with mock.patch.object(command_line.sys, "argv", ["/x/study.py", "--out", "my results", "--resume"]), \
                    mock.patch.object(command_line, "read", return_value=(None, [])):
                said = command_line.Session(experiment, given, None, None)._how_to_resume()
        self.assertTrue(said.endswith("go on with: study.py --out 'my results' --resume"), said)


if __name__ == "__main__":
    unittest.main()
