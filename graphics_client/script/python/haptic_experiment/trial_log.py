"""The log of a session: one line of JSON an event, appended and on the disk before the next thing happens.

The first line is the header, which says what the session is. Only a line "answer" counts a trial. A kill tears at most the
last line; it is dropped when the log is opened again.
"""
import fcntl
import json
import os
from pathlib import Path

from haptic_experiment.design import FORMAT

LOOSE = ("event", "server", "started", "recording", "definition_sha256")  # of the header: may differ when a session is resumed


class LogRefused(Exception):
    """The log cannot be opened as asked: which field differs, and what it would have to be."""


class LogFailed(Exception):
    """An event could not be put on the disk: it did not happen."""


class TrialLog:
    """Appends events to a file that no other process may have open.

    header: what the session is, compared with the log's when it is resumed. answers: the answered trials of the log, the
    events "answer" in order. Raises LogRefused.
    """

    def __init__(self, path, header, resume=False):
        self.path, self.answers = Path(path), []
        header = {"event": "header", "format": FORMAT, **header}
        try:
            self._file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o644)
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(self._file)
            raise LogRefused(f"{self.path}: another process runs this session") from None
        except OSError as error:
            raise LogRefused(f"{self.path}: {error.strerror}") from None
        try:
            events = self._whole_events()
            if events and not resume:
                raise LogRefused(f"{self.path} is there, with {count(events)} answered trials; go on with --resume, or give "
                                 "another --out or --participant")
            if events:
                compare(events[0], header, self.path)
                self.answers = [event for event in events if event["event"] == "answer"]
            self.header = events[0] if events else header
            if not events:
                self.append(**header)
                sync_folder(self.path.parent)
        except BaseException:
            os.close(self._file)
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        os.close(self._file)

    def append(self, event, **fields):
        """Puts a line on the disk. Raises LogFailed; the log then ends with its last whole line."""
        line = (json.dumps({"event": event, **fields}, allow_nan=False) + "\n").encode()
        end = os.fstat(self._file).st_size
        try:
            written = 0
            while written < len(line):
                written += os.write(self._file, line[written:])
            os.fsync(self._file)
        except OSError as error:
            self._cut(end)
            raise LogFailed(f"{self.path} cannot be written: {error.strerror}") from None

    def _cut(self, end):
        try:
            os.ftruncate(self._file, end)
        except OSError:
            pass  # the torn line is dropped when the log is opened again

    def _whole_events(self):
        data = self.path.read_bytes()
        whole = data.rfind(b"\n") + 1
        if whole < len(data):
            os.ftruncate(self._file, whole)
            os.fsync(self._file)
        events = []
        for number, line in enumerate(data[:whole].splitlines(), 1):
            try:
                event = json.loads(line)
                event["event"]
            except (ValueError, TypeError, KeyError):
                raise LogRefused(f"{self.path}: line {number} is no event; the log was changed after it was written") from None
            events.append(event)
        if events and events[0]["event"] != "header":
            raise LogRefused(f"{self.path}: has no header in line 1; it is no log of an experiment")
        return events


def read(path):
    """(header, answers) of a log, which is not changed; a torn last line is left out."""
    events = [json.loads(line) for line in Path(path).read_bytes().split(b"\n")[:-1]]
    return events[0], [event for event in events if event["event"] == "answer"]


def compare(logged, header, path):
    """Raises LogRefused, which names the first field that differs."""
    for field, there, here in differences(logged, header):
        if field.split(".")[0] not in LOOSE:
            raise LogRefused(f"{path} is of another session: {field} is {shown(there)} there and {shown(here)} here; to resume "
                             f"it would have to be {shown(there)}")


def differences(there, here, prefix=""):
    """(name, there, here) of what differs, by dotted names."""
    for key in [*there, *(key for key in here if key not in there)]:
        one, other = there.get(key), here.get(key)
        if isinstance(one, dict) and isinstance(other, dict):
            yield from differences(one, other, f"{prefix}{key}.")
        elif one != other:
            yield prefix + key, one, other


def shown(value):
    text = json.dumps(value)
    return text if len(text) <= 200 else text[:200] + "..."


def count(events):
    return sum(event["event"] == "answer" for event in events)


def sync_folder(folder):
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
