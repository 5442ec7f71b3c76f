"""Which level comes next: constant stimuli, staircases, QUEST.

A method is a pure function of its seed and of the answers so far: next() says a Stimulus, answered() takes whether it was
answered correctly. The same answers give the same levels, so that a log is resumed by replaying it. Levels are positive;
steps are ratios.
"""
import hashlib
import math
from collections import namedtuple

import numpy

# level: in the experiment's unit; staircase: number of the staircase that asks, from 1.
Stimulus = namedtuple("Stimulus", "level staircase")

METHODS = ("staircase", "weighted", "constant", "quest")
GUESS_RATE = 0.5  # of 2IFC
QUEST_LAPSE_RATE = 0.01
QUEST_STEP = 0.05  # decades between levels, 1 dB
QUEST_SLOPE = 1.3  # Weibull exponent of an observer whose d' is proportional to the level


def draw(seed, *what):
    """Uniform in [0, 1): a pure function of its arguments, the same on every machine (SHA-256)."""
    digest = hashlib.sha256(repr((seed, *what)).encode()).digest()
    return (int.from_bytes(digest[:8], "big") >> 11) / 2**53


def rounded(level):
    """To 6 digits, so that a level does not depend on the last bit of a machine's logarithm."""
    return float(f"{level:.6g}")


def spaced(lowest, highest, count):
    """`count` levels at equal ratios, both ends among them."""
    return [rounded(lowest * (highest / lowest) ** (index / (count - 1))) for index in range(count)]


class ConstantStimuli:
    """Each level equally often, in random order within each block of all levels (Fechner 1860; Gescheider 1997, ch. 3)."""

    def __init__(self, levels, repetitions, seed):
        check(len(levels) >= 2 and min(levels) > 0, "levels", f"are {levels}; two or more, each above 0, are wanted")
        check(repetitions >= 1, "repetitions", f"is {repetitions}; 1 or more is wanted")
        self._levels, self._repetitions, self._seed, self._answers = levels, repetitions, seed, 0
        self.trials = len(levels) * repetitions

    def describe(self):
        return {"method": "constant stimuli", "levels": self._levels, "repetitions": self._repetitions}

    def next(self):
        """The Stimulus of the coming trial; None when there is none left."""
        if self._answers == self.trials:
            return None
        block, place = divmod(self._answers, len(self._levels))
        order = sorted(self._levels, key=lambda level: draw(self._seed, "block", block, level))
        return Stimulus(order[place], 1)

    def answered(self, correct):
        self._answers += 1


class Staircase:
    """Up after a wrong answer, down after `down_after` correct ones in a row, until `trials` are answered.

    Steps are ratios: down by `ratio`, up by ratio**up_weight; until the second reversal by the square of that. It converges
    where p**down_after = up_weight / (1 + up_weight): on 70.7 % correct for 1-up-2-down with equal steps (Levitt 1971,
    J. Acoust. Soc. Am. 49, 467), and with down_after 1 on p = up_weight / (1 + up_weight), the weighted up-down method
    (Kaernbach 1991, Percept. Psychophys. 49, 227).
    """

    def __init__(self, start, lowest, highest, trials, down_after=2, up_weight=1.0, ratio=1.26):
        check(0 < lowest <= start <= highest, "start", f"is {start}; between lowest, {lowest}, and highest, {highest}, is wanted")
        check(ratio > 1, "ratio", f"is {ratio}; above 1 is wanted")
        check(trials >= 1, "trials", f"is {trials}; 1 or more is wanted")
        self._start, self._lowest, self._highest, self._ratio = start, lowest, highest, ratio
        self._down_after, self._up_weight, self.trials = down_after, up_weight, trials
        self._exponent = 0.0  # of the ratio, from the start level
        self._answers = self._in_a_row = self._direction = 0
        self.reversals = []  # levels at which the direction changed

    @classmethod
    def weighted(cls, start, lowest, highest, trials, target=0.75, ratio=1.26):
        """Converges on the proportion `target` of correct answers: up_weight = target / (1 - target). `ratio`: of a step up."""
        check(0.5 < target < 1, "target", f"is {target}; between 0.5 and 1 is wanted")
        weight = target / (1 - target)
        return cls(start, lowest, highest, trials, 1, weight, ratio ** (1 / weight))

    def describe(self):
        return {"method": "staircase", "start": self._start, "lowest": self._lowest, "highest": self._highest,
                "trials": self.trials, "down_after": self._down_after, "up_weight": self._up_weight, "ratio": self._ratio}

    def next(self):
        """The Stimulus of the coming trial; None when there is none left."""
        return Stimulus(self._level(), 1) if self._answers < self.trials else None

    def answered(self, correct):
        self._answers += 1
        self._in_a_row = self._in_a_row + 1 if correct else 0
        if correct and self._in_a_row < self._down_after:
            return
        direction = -1 if correct else 1
        if self._direction and direction != self._direction:
            self.reversals.append(self._level())
        self._direction, self._in_a_row = direction, 0
        step = (1 if correct else self._up_weight) * (2 if len(self.reversals) < 2 else 1)
        low = math.ceil(math.log(self._lowest / self._start, self._ratio) - 1e-9)
        high = math.floor(math.log(self._highest / self._start, self._ratio) + 1e-9)
        self._exponent = min(max(self._exponent + direction * step, low), high)

    def _level(self):
        return rounded(self._start * self._ratio ** self._exponent)


class Interleaved:
    """Several staircases, of which a random one that is not at its end asks in each trial."""

    def __init__(self, staircases, seed):
        self._staircases, self._seed, self._answers = staircases, seed, 0
        self.trials = sum(staircase.trials for staircase in staircases)

    def describe(self):
        return {"method": "interleaved staircases",
                "staircases": [staircase.describe() for staircase in self._staircases]}

    def next(self):
        """The Stimulus of the coming trial; None when there is none left."""
        index = self._asking()
        return None if index is None else Stimulus(self._staircases[index].next().level, index + 1)

    def answered(self, correct):
        self._staircases[self._asking()].answered(correct)
        self._answers += 1

    def _asking(self):
        going = [index for index, staircase in enumerate(self._staircases) if staircase.next()]
        return going[int(draw(self._seed, "staircase", self._answers) * len(going))] if going else None


class Quest:
    """QUEST: each trial at the mean of the posterior of the threshold (Watson & Pelli 1983, Percept. Psychophys. 33, 113; the
    mean in place of the mode: King-Smith et al. 1994, Vision Res. 34, 885).

    The prior is a Gaussian of log10(level) about `guess` with standard deviation `spread` (decades). Its psychometric function
    is a Weibull with guess rate 1/2, lapse rate 0.01 and the exponent `slope`; its threshold is at 81.4 % correct.
    """

    def __init__(self, guess, lowest, highest, trials, spread=0.5, slope=QUEST_SLOPE):
        check(0 < lowest <= guess <= highest, "guess", f"is {guess}; between lowest, {lowest}, and highest, {highest}, is wanted")
        check(trials >= 1, "trials", f"is {trials}; 1 or more is wanted")
        self._given = {"method": "QUEST", "guess": guess, "lowest": lowest, "highest": highest, "trials": trials,
                       "spread": spread, "slope": slope}
        self.trials, self._answers = trials, 0
        self._thresholds = numpy.linspace(math.log10(lowest) - 0.5, math.log10(highest) + 0.5, 401)
        self._log_posterior = -0.5 * ((self._thresholds - math.log10(guess)) / spread) ** 2

    def describe(self):
        return self._given

    def next(self):
        """The Stimulus of the coming trial; None when there is none left."""
        if self._answers == self.trials:
            return None
        weights = numpy.exp(self._log_posterior - self._log_posterior.max())
        mean = float((weights * self._thresholds).sum() / weights.sum())
        level = 10 ** (round(mean / QUEST_STEP) * QUEST_STEP)
        return Stimulus(rounded(min(max(level, self._given["lowest"]), self._given["highest"])), 1)

    def answered(self, correct):
        level = math.log10(self.next().level)
        rise = 1 - numpy.exp(-10 ** (self._given["slope"] * (level - self._thresholds)))
        right = GUESS_RATE + (1 - GUESS_RATE - QUEST_LAPSE_RATE) * rise
        self._log_posterior = self._log_posterior + numpy.log(right if correct else 1 - right)
        self._answers += 1


def method_named(name, lowest, highest, trials, seed):
    """One of METHODS over the levels from `lowest` to `highest`, for `trials` trials in all; of constant stimuli as many as
    fill whole blocks of 7 levels, at least one."""
    middle = rounded(math.sqrt(lowest * highest))
    if name == "constant":
        return ConstantStimuli(spaced(lowest, highest, 7), max(1, round(trials / 7)), seed)
    if name == "quest":
        return Quest(middle, lowest, highest, trials)
    check(name in METHODS, "method", f"is {name}; one of {', '.join(METHODS)} is wanted")
    kind = Staircase if name == "staircase" else Staircase.weighted
    starts = (highest, rounded(highest / 1.26 ** round(math.log(highest / middle, 1.26))))  # of one set of levels
    shares = (trials - trials // 2, trials // 2)
    return Interleaved([kind(start, lowest, highest, share) for start, share in zip(starts, shares) if share], seed)


def check(holds, field, what):
    if not holds:
        raise ValueError(f"{field} {what}")
