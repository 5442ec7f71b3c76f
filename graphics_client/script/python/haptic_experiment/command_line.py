"""The command line of an experiment: main(EXPERIMENT, __doc__)."""
import argparse
import re
import shlex
import sys
from pathlib import Path

from haptic_experiment.design import digest
from haptic_experiment.methods import METHODS, method_named
from haptic_experiment.participants import SIMULATED, Person, SimulatedParticipant
from haptic_experiment.runner import GivenUp, Runner, now
from haptic_experiment.trial_log import LogFailed, LogRefused, TrialLog, read
from haptic_recording import HEAD
from haptic_text import printable

DONE, REFUSED, WRONG_USAGE, NO_CONNECTION, INTERRUPTED = 0, 1, 2, 3, 130  # exit status


def parser_of(experiment, documentation):
    parser = argparse.ArgumentParser(prog=f"{experiment.name}.py", description=documentation,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--participant", required=True, metavar="NAME", help="letters, digits, _ and -; names the files")
    parser.add_argument("--connect", default="127.0.0.1:7654", metavar="HOST:PORT")
    parser.add_argument("--credentials", metavar="FILE")
    parser.add_argument("--out", default=".", metavar="DIR", help="where log and results go (.)")
    parser.add_argument("--seed", type=int, default=1, help="of the random order (1)")
    parser.add_argument("--method", choices=METHODS, default="weighted",
                        help="weighted: two interleaved weighted up-down staircases, the default; staircase: two of 1-up-2-down")
    parser.add_argument("--trials", type=int, default=120, help="in all (120)")
    parser.add_argument("--resume", action="store_true", help="goes on where the log ends")
    parser.add_argument("--unblind", action="store_true", help="shows level and order of each trial once it is answered")
    parser.add_argument("--answer", choices=("keyboard", "button"), default="keyboard")
    parser.add_argument("--recording", metavar="FILE",
                        help="that the server writes (haptic_server --record FILE): named in the results")
    parser.add_argument("--simulated", action="store_true", help=f"a {SIMULATED} in place of a person")
    parser.add_argument("--weber", type=float, default=0.1, metavar="W", help="its Weber fraction (0.1)")
    parser.add_argument("--in-process", action="store_true", help="without a server; needs --simulated")
    return parser


def main(experiment, documentation):
    """Runs the experiment as the command line says, and exits: 0 done, 1 refused, 2 wrong usage, 3 no connection, 130 Ctrl-C."""
    parser = parser_of(experiment, documentation)
    given = parser.parse_args()
    try:
        check(given)
        method = method_named(given.method, experiment.lowest, experiment.highest, given.trials, given.seed)
        participant = SimulatedParticipant(given.weber, given.seed) if given.simulated else Person(given.answer)
    except ValueError as error:
        parser.error(str(error))
    sys.exit(Session(experiment, given, method, participant).run())


def check(given):
    if not re.fullmatch(r"[A-Za-z0-9_-]{1,64}", given.participant):
        raise ValueError("--participant: 1 to 64 letters, digits, _ and - are wanted")
    if given.in_process and not given.simulated:
        raise ValueError("--in-process: there is nothing that a person could touch; it needs --simulated")
    if given.in_process and given.recording:
        raise ValueError("--recording: there is no server that records; leave out --in-process")
    if given.trials < 1:
        raise ValueError(f"--trials: is {given.trials}; 1 or more is wanted")
    if given.recording:
        check_recording(given.recording)


def check_recording(path):
    try:
        with open(path, "rb") as file:
            is_one = file.read(len(HEAD)) == HEAD
    except OSError as error:
        raise ValueError(f"--recording: {path}: {error.strerror}; start the server with --record {path}") from None
    if not is_one:
        raise ValueError(f"--recording: {path} is no recording of haptic_server --record")


class Session:
    """One run of the program: from the log as it is to the results, or to a reason why not."""

    def __init__(self, experiment, given, method, participant):
        self._experiment, self._given, self._method, self._participant = experiment, given, method, participant
        self._stem = Path(given.out) / f"{experiment.name}-{given.participant}"
        self._log_path = Path(f"{self._stem}.jsonl")

    def run(self):
        from haptic_experiment.sessions import SessionRefused
        try:
            self._stem.parent.mkdir(parents=True, exist_ok=True)
            session = self._open_session()
        except OSError as error:
            return self._fail(REFUSED, f"--out: {error.filename}: {error.strerror}")
        except SessionRefused as error:
            return self._fail(NO_CONNECTION, str(error))
        except KeyboardInterrupt:
            return INTERRUPTED
        try:
            return self._run_in(session)
        except (LogRefused, GivenUp, SessionRefused) as error:
            return self._fail(REFUSED, f"{error}{self._how_to_resume() if not isinstance(error, LogRefused) else ''}")
        except LogFailed as error:
            return self._fail(REFUSED, f"{error}; the trial under way is not counted. Make room.{self._how_to_resume()}")
        except KeyboardInterrupt:
            print(f"\ninterrupted; the trial under way is not counted.{self._how_to_resume()}", flush=True)
            return INTERRUPTED
        finally:
            session.close()

    def _open_session(self):
        from haptic_experiment.sessions import ServerSession, WorldSession
        if self._given.in_process:
            return WorldSession(self._experiment.scene)
        return ServerSession(self._given.connect, self._experiment.scene, self._given.simulated, self._given.credentials)

    def _run_in(self, session):
        with TrialLog(self._log_path, self._header(session), self._given.resume) as log:
            if self._given.simulated:
                print(SIMULATED, flush=True)
            runner = Runner(self._experiment, self._method, self._given.seed, self._participant, session, log, say,
                            self._given.unblind)
            if log.answers:
                print(f"resumed: {len(log.answers)} of {self._method.trials} trials are answered", flush=True)
                log.append("resumed", time=now(), server=self._header(session)["server"])
            runner.run()
        return self._write_results()

    def _write_results(self):
        from haptic_experiment.results import Results
        results = Results(*read(self._log_path))
        files = results.write(self._stem)
        print(f"{results.simulated + ': ' if results.simulated else ''}{results.threshold_words}", flush=True)
        print("\n".join(map(str, [self._log_path, *files])), flush=True)
        return DONE

    def _header(self, session):
        definition = self._experiment.definition(self._method)
        return {"experiment": self._experiment.name, "participant": self._given.participant, "seed": self._given.seed,
                "simulated": self._participant.describe(), "device": session.device, "definition": definition,
                "definition_sha256": digest(repr(definition)), "server": "none, in process" if self._given.in_process
                else self._given.connect, "recording": self._given.recording, "started": now()}

    def _how_to_resume(self):
        if not self._log_path.exists():
            return ""
        command = shlex.join([Path(sys.argv[0]).name, *(word for word in sys.argv[1:] if word != "--resume"), "--resume"])
        return f" {len(read(self._log_path)[1])} answered trials are in {self._log_path}; go on with: {command}"

    def _fail(self, status, why):
        print(f"{self._experiment.name}: {printable(why)}", file=sys.stderr, flush=True)
        return status


def say(line):
    print(line, flush=True)
