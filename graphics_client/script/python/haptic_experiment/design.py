"""What an experiment is: what is felt, how a level becomes a transaction, how the hand explores, and its trials."""
import hashlib
import inspect
import json
from collections import namedtuple
from dataclasses import asdict, dataclass
from typing import Callable

from haptic_experiment.methods import draw

FORMAT = 1  # of the log


@dataclass(frozen=True)
class Press:
    """The hand presses on a place of a surface. Metres, world frame; newtons; seconds."""
    place: tuple
    normal: tuple
    force_N: float
    seconds: float


@dataclass(frozen=True)
class Stroke:
    """The hand strokes from `place` to `end` along a surface, pressing against its normal. Units as Press; speed in m/s."""
    place: tuple
    end: tuple
    normal: tuple
    force_N: float
    speed: float


@dataclass(frozen=True)
class Experiment:
    """A two-interval forced choice (2IFC): one interval presents the reference, level 0, the other the comparison.

    value(level) is what the level means, in value_unit; stimulus(value) is the transaction (its text) that presents it.
    estimate(felt) is what the simulated participant compares; the larger one is chosen.
    """
    name: str
    version: int
    question: str       # to the participant, who answers 1 or 2
    level_name: str     # "stiffness above the reference"
    level_unit: str     # "%"
    value_name: str     # "stiffness"
    value_unit: str     # "N/m"
    lowest: float       # of the levels
    highest: float
    scene: str          # a transaction's text: adds what is felt
    value: Callable
    stimulus: Callable
    exploration: Press | Stroke
    estimate: Callable

    def definition(self, method):
        """All that the data depend on, by name; what is code as a hash of its source."""
        fields = {name: getattr(self, name) for name in ("name", "version", "question", "level_name", "level_unit", "value_name",
                                                         "value_unit", "lowest", "highest", "scene")}
        fields["reference"] = self.stimulus(self.value(0))
        fields["comparison"] = self.stimulus(self.value(self.highest))
        fields["exploration"] = asdict(self.exploration)
        fields["estimate"] = digest(inspect.getsource(self.estimate))
        return json.loads(json.dumps({**fields, "method": method.describe()}))


# order: the interval, 1 or 2, that presents the comparison.
Trial = namedtuple("Trial", "number level staircase order")


class Sequence:
    """The trials of an experiment: a pure function of method, seed and answers."""

    def __init__(self, method, seed):
        self._method, self._seed, self._answered = method, seed, 0
        self.trials = method.trials

    def next(self):
        """The coming Trial; None when all are answered."""
        stimulus = self._method.next()
        number = self._answered + 1
        return stimulus and Trial(number, *stimulus, 1 if draw(self._seed, "order", number) < 0.5 else 2)

    def answered(self, answer):
        """Takes the interval, 1 or 2, that the participant chose; says whether it is that of the comparison."""
        correct = answer == self.next().order
        self._method.answered(correct)
        self._answered += 1
        return correct


def digest(text):
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def percent_above(reference):
    """The value of a level in percent above the reference: value = reference * (1 + level / 100)."""
    return lambda level: float(f"{reference * (1 + level / 100):.9g}")
