"""Runs the trials of a session, each with its events in the log."""
import time
from datetime import datetime, timezone

from haptic_experiment.design import Sequence
from haptic_experiment.sessions import Interrupted
from haptic_experiment.trial_log import LogRefused

MAX_REPEATS = 10   # of a trial that is interrupted again and again
RECOVERY_S = 60.0  # in which a server has to come back


class GivenUp(Exception):
    """A trial was interrupted again and again: why the last time."""


def now():
    return datetime.now(timezone.utc).isoformat(timespec="milliseconds")


def replay(sequence, answers, path):
    """Brings the sequence to where the log ends. Raises LogRefused where the log has another trial than the sequence."""
    for answer in answers:
        trial = sequence.next()
        logged = tuple(answer.get(field) for field in ("trial", "level", "staircase", "order"))
        if trial is None or tuple(trial) != logged:
            raise LogRefused(f"{path}: trial {len(answers) if trial is None else trial.number} is {logged} in the log and "
                             f"{trial and tuple(trial)} by the method; the log was changed after it was written")
        sequence.answered(answer["answer"])


class Runner:
    """Runs what is left of a session. `say`: takes lines for the experimenter, who is blind unless `unblind`."""

    def __init__(self, experiment, method, seed, participant, session, log, say=print, unblind=False):
        self._experiment, self._participant, self._session, self._log = experiment, participant, session, log
        self._say, self._unblind = say, unblind
        self._sequence = Sequence(method, seed)
        replay(self._sequence, log.answers, log.path)
        self.answered = len(log.answers)

    def run(self):
        """Until every trial is answered. Raises LogFailed, GivenUp, SessionRefused; a trial under way is then not counted."""
        while trial := self._sequence.next():
            self._log.append("trial", trial=trial.number, time=now(), **self._stimuli(trial))
            begun = time.monotonic()
            answer, felt = self._until_answered(trial)
            self._log.append("answer", trial=trial.number, **self._stimuli(trial), answer=answer,
                             correct=answer == trial.order, seconds=round(time.monotonic() - begun, 3), time=now(),
                             intervals=[each.summary() for each in felt])
            correct = self._sequence.answered(answer)
            self.answered += 1
            detail = (f": level {trial.level:g} {self._experiment.level_unit}, comparison in interval {trial.order}, "
                      f"{'correct' if correct else 'wrong'}" if self._unblind else "")
            self._say(f"trial {trial.number} of {self._sequence.trials} answered{detail}")

    def _stimuli(self, trial):
        return {"level": trial.level, "staircase": trial.staircase, "order": trial.order,
                "reference_value": self._experiment.value(0), "comparison_value": self._experiment.value(trial.level)}

    def _until_answered(self, trial):
        """(answer, what was Felt in both intervals). An interrupted trial is repeated with the same stimuli."""
        for _ in range(MAX_REPEATS):
            try:
                felt = [self._interval(trial, interval) for interval in (1, 2)]
                return self._participant.answer(self._session, self._experiment, trial, felt), felt
            except Interrupted as error:
                why = str(error)
                self._log.append("interrupted", trial=trial.number, why=why, time=now())
                self._say(f"trial {trial.number} is repeated: {why}")
                if error.lost:
                    self._session.recover(RECOVERY_S)
        raise GivenUp(f"trial {trial.number} was interrupted {MAX_REPEATS} times; the last time: {why}")

    def _interval(self, trial, interval):
        value = self._experiment.value(trial.level if interval == trial.order else 0)
        self._session.apply(self._experiment.stimulus(value))
        return self._participant.present(self._session, self._experiment, interval)
