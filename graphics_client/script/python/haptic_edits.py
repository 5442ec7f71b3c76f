"""Edits on their way to the server: numbered, kept until answered, sent again after a reconnect."""
import concurrent.futures
import contextlib
import time

from haptic_text import printable
from haptics.v1 import envelope_pb2

MAX_IN_FLIGHT = 32  # sent and not yet answered: no more than results that the server remembers
MAX_PENDING = 1000  # not live yet
MAX_TRANSACTION_BYTES = (1 << 20) - 64  # of a frame, without what stands around it
PATIENCE_S = 60.0  # what the server puts off for longer is given up


class Rejected(Exception):
    """An edit that the server cannot carry out, or that is too large to be sent; `field` names the part that is wrong.
    `field` and `reason` are as the server wrote them, the exception's text is escaped for a terminal."""

    def __init__(self, field, reason):
        super().__init__(printable(f"{field}: {reason}" if field else reason))
        self.field, self.reason = field, reason


class Conflict(Exception):
    """A precondition did not hold; `current` are the objects (ObjectState) as they now stand."""

    def __init__(self, reason, current):
        super().__init__(printable(reason))
        self.current = current


class StateLost(Exception):
    """The server restarted without the state in which it had accepted the edit."""


class Closed(Exception):
    """The client was closed, or has failed, before there was an answer."""


def settle(future, result=None, error=None):
    """Unless its owner has cancelled it."""
    with contextlib.suppress(concurrent.futures.InvalidStateError):
        future.set_exception(error) if error else future.set_result(result)


def awaited(future, timeout_s, trouble):
    """The future's result. TimeoutError says why there may be none: trouble()."""
    try:
        return future.result(timeout_s)
    except concurrent.futures.TimeoutError:
        if future.done():
            raise
        why = trouble()
        raise TimeoutError(f"no answer within {timeout_s:g} s" + (f": {why}" if why else "")) from None


class Edit:
    """Two answers, each to be waited for. A wait without a timeout ends with Closed when the client does."""

    def __init__(self, request, trouble):
        self.request = request
        self.sent = False
        self.put_off_since = None
        self.unreadable_once = False
        self.reply = concurrent.futures.Future()
        self.live = concurrent.futures.Future()
        self._trouble = trouble

    def result(self, timeout_s=None):
        """Accepted; raises Conflict, Rejected, Closed, TimeoutError."""
        return awaited(self.reply, timeout_s, self._trouble)

    def live_since_tick(self, timeout_s=None):
        """The first tick that felt it; raises StateLost too."""
        self.result(timeout_s)
        return awaited(self.live, timeout_s, self._trouble)

    def fail(self, error):
        settle(self.reply, error=error)
        settle(self.live, error=error)


class EditQueue:
    def __init__(self, trouble=lambda: ""):
        """`trouble()`: why there is no connection, for those who wait."""
        self._edits = {}  # not answered, by client_seq, oldest first
        self._accepted = {}  # not live: (revision, future) by client_seq
        self._last_seq = 0
        self._waiting_until = None  # sends nothing: the server found that edits came too early
        self._trouble = trouble
        self._end = None

    def add(self, transaction, epoch):
        """Made from a scene of this epoch. What cannot be sent is answered at once."""
        edit = Edit(envelope_pb2.EditRequest(transaction=transaction, epoch=epoch), self._trouble)
        if self._end:
            edit.fail(self._end)
        elif edit.request.transaction.ByteSize() > MAX_TRANSACTION_BYTES:
            edit.fail(Rejected("transaction", "is larger than a frame, 1 MiB; split it"))
        elif len(self._edits) + len(self._accepted) >= MAX_PENDING:
            edit.fail(Rejected("", f"{MAX_PENDING} edits wait for the server; try again later"))
        else:
            self._last_seq += 1
            edit.request.client_seq = self._last_seq
            self._edits[self._last_seq] = edit
        return edit

    def take_unsent(self):
        """Requests to send now, oldest first. What came too early goes again once every answer under way is here."""
        in_flight = sum(edit.sent for edit in self._edits.values())
        if self._waiting_until is not None:
            if in_flight or time.monotonic() < self._waiting_until:
                return []
            self._waiting_until = None
        unsent = [edit for edit in self._edits.values() if not edit.sent]
        requests = []
        for edit in unsent[:MAX_IN_FLIGHT - in_flight]:
            edit.sent = True
            requests.append(edit.request)
        return requests

    def answer_unreadable(self):
        """What the server has said cannot be read, which may be the answer to the oldest edit that was sent. At the second time
        that edit is given up: sent again, it would be answered the same."""
        edit = next((edit for edit in self._edits.values() if edit.sent), None)
        if edit and edit.unreadable_once:
            del self._edits[edit.request.client_seq]
            edit.fail(Rejected("edit_reply", "cannot be read, twice; whether the edit was applied is not known"))
        elif edit:
            edit.unreadable_once = True

    def connection_lost(self):
        self._waiting_until = None
        for edit in self._edits.values():
            edit.sent = False

    def state_lost(self):
        for _, live in self._accepted.values():
            settle(live, error=StateLost("the server restarted without its state"))
        self._accepted.clear()

    def end(self, error):
        """Every wait ends with the error, now and from now on."""
        self._end = error
        for edit in self._edits.values():
            edit.fail(error)
        for _, live in self._accepted.values():
            settle(live, error=error)
        self._edits.clear()
        self._accepted.clear()

    def replied(self, reply):
        edit = self._edits.get(reply.client_seq)
        if not edit or self._put_off(edit, reply.rejected.retry_after_ms):
            return
        del self._edits[reply.client_seq]
        outcome = reply.WhichOneof("outcome")
        if outcome == "accepted":
            self._accepted[reply.client_seq] = reply.accepted.revision, edit.live
            settle(edit.reply, reply.accepted)
        elif outcome == "conflict":
            edit.fail(Conflict(reply.conflict.reason, list(reply.conflict.current)))
        elif outcome == "rejected":
            edit.fail(Rejected(reply.rejected.field, reply.rejected.reason))
        else:
            edit.fail(Rejected("edit_reply", "is of a kind that this client does not know; whether the edit was applied, too"))

    def _put_off(self, edit, retry_after_ms):
        """Whether the edit came too early and is to be sent again."""
        now = time.monotonic()
        edit.put_off_since = edit.put_off_since or now
        if not retry_after_ms or now - edit.put_off_since >= PATIENCE_S:
            return False
        edit.sent = False
        self._waiting_until = now + min(1e-3 * retry_after_ms, PATIENCE_S)
        return True

    def adopted(self, revision, tick):
        """What the servo feels: edits up to this revision are live, also those of which nobody said so."""
        for seq in [seq for seq, (accepted, _) in self._accepted.items() if accepted <= revision]:
            settle(self._accepted.pop(seq)[1], tick)

    def live(self, live):
        if live.client_seq in self._accepted:
            settle(self._accepted.pop(live.client_seq)[1], live.tick)
