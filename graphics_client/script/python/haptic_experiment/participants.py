"""Who answers: a person at keyboard or device buttons, or a simulated participant with a known threshold."""
import math
import select
import sys
import termios
import time
from statistics import NormalDist

from haptic_experiment.felt import NothingFelt
from haptic_experiment.methods import draw
from haptic_experiment.sessions import Interrupted

SIMULATED = "SIMULATED PARTICIPANT"
FELT_S = 3.0       # of an interval, for a person
LOOK_S = 0.02      # between two looks at keyboard or buttons
LIFTED_S = 0.2     # without contact, before the next stimulus


def threshold_percent(weber, correct=0.75):
    """The level, in percent above the reference, at which the simulated participant answers this proportion correctly.

    Its estimates of reference r and comparison c = r (1 + x) are r (1 + w n1) and c (1 + w n2), n1 and n2 standard normal. It
    is right where the comparison's is larger, c - r > w (r n1 - c n2), whose right side has the variance w^2 (r^2 + c^2):

        p(x) = Phi(x / (w sqrt(1 + (1 + x)^2)))

    (2IFC with noise of its own in each interval: Green & Swets 1966, Signal Detection Theory, ch. 2). With k = (w z)^2,
    z = Phi^-1(p), the positive root of (1 - k) x^2 - 2 k x - 2 k = 0 is

        x = (k + sqrt(k^2 + 2 k (1 - k))) / (1 - k).
    """
    k = (weber * NormalDist().inv_cdf(correct)) ** 2
    if k >= 1:
        raise ValueError(f"weber is {weber}; with it no level is answered {100 * correct:g} % correctly")
    return 100 * (k + math.sqrt(k * k + 2 * k * (1 - k))) / (1 - k)


class SimulatedParticipant:
    """Estimates both stimuli by the forces that the led hand met, with Weber noise, and chooses the larger one. Its noise is a
    function of (seed, experiment, trial, interval) alone."""

    def __init__(self, weber, seed, lapse_rate=0.0):
        if not 0 < weber < 1:
            raise ValueError(f"weber is {weber}; above 0 and below 1 is wanted")
        if not 0 <= lapse_rate < 0.5:
            raise ValueError(f"lapse rate is {lapse_rate}; from 0 and below 0.5 is wanted")
        self._weber, self._seed, self._lapse_rate = weber, seed, lapse_rate

    def describe(self):
        return {"what": SIMULATED, "weber_fraction": self._weber, "lapse_rate": self._lapse_rate,
                "true_threshold_percent": threshold_percent(self._weber)}

    def present(self, session, experiment, interval):
        """What the led hand Felt."""
        return session.explore(experiment.exploration)

    def answer(self, session, experiment, trial, felt):
        """The interval, 1 or 2. Raises Interrupted where too little was felt."""
        if draw(self._seed, "lapse", trial.number) < self._lapse_rate:
            return 1 if draw(self._seed, "guess", trial.number) < 0.5 else 2
        try:
            estimates = [experiment.estimate(each) * (1 + self._weber * self._noise(experiment.name, trial.number, interval))
                         for interval, each in enumerate(felt, 1)]
        except NothingFelt as error:
            raise Interrupted(str(error), lost=False) from None
        return 1 if estimates[0] > estimates[1] else 2

    def _noise(self, experiment, trial, interval):
        return NormalDist().inv_cdf(max(draw(self._seed, "noise", experiment, trial, interval), 2**-54))


class Person:
    """Feels each interval for some seconds, and answers 1 or 2 by `by`: "keyboard", or "button", the first or second one of the
    device. The next stimulus waits until the hand touches nothing."""

    def __init__(self, by="keyboard", seconds=FELT_S, say=print):
        self._by, self._seconds, self._say = by, seconds, say

    def describe(self):
        return None

    def present(self, session, experiment, interval):
        """What the person Felt."""
        self._say(f"interval {interval}: feel it")
        felt = session.feel(self._seconds)
        self._say("lift")
        self._until_lifted(session)
        return felt

    def answer(self, session, experiment, trial, felt):
        """The interval, 1 or 2."""
        self._say(f"{experiment.question} Answer 1 or 2{' by the first or second button' if self._by == 'button' else ''}: ")
        if self._by == "button":
            return self._pressed(session)
        if sys.stdin.isatty():
            termios.tcflush(sys.stdin, termios.TCIFLUSH)  # what was typed before the question is no answer
        return self._typed(session)

    def _until_lifted(self, session):
        free_since = None
        while free_since is None or time.monotonic() - free_since < LIFTED_S:
            for sample in session.samples(0.5):
                free_since = None if sample.object else free_since or time.monotonic()
                if free_since and time.monotonic() - free_since >= LIFTED_S:
                    break

    def _pressed(self, session):
        before = ~0
        while True:
            for sample in session.samples(0.5):
                went_down = sample.device_buttons & ~before
                before = sample.device_buttons
                if went_down & 3 in (1, 2):
                    return went_down & 3

    def _typed(self, session):
        while True:
            for _ in session.samples(0.5):
                if select.select([sys.stdin], [], [], 0)[0]:
                    break
            else:
                continue
            line = sys.stdin.readline()
            if not line:
                raise KeyboardInterrupt  # no answer will come
            if line.strip() in ("1", "2"):
                return int(line)
            self._say("1 or 2: ")
