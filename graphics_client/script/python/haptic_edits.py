"""Edits on their way to the server: numbered, kept until answered, sent again after a reconnect."""
import concurrent.futures
import time

from haptics.v1 import envelope_pb2

MAX_IN_FLIGHT = 32  # sent and not yet answered: no more than results that the server remembers


class Rejected(Exception):
    """An edit that the server cannot carry out; `field` names the part that is wrong."""

    def __init__(self, field, reason):
        super().__init__(f"{field}: {reason}" if field else reason)
        self.field, self.reason = field, reason


class Conflict(Exception):
    """A precondition did not hold; `current` are the objects (ObjectState) as they now stand."""

    def __init__(self, reason, current):
        super().__init__(reason)
        self.current = current


class StateLost(Exception):
    """The server restarted without the state in which it had accepted the edit."""


class Edit:
    """Two answers, each to be waited for."""

    def __init__(self, request):
        self.request = request
        self.sent = False
        self.reply = concurrent.futures.Future()
        self.live = concurrent.futures.Future()

    def result(self, timeout_s=None):
        """Accepted; raises Conflict or Rejected."""
        return self.reply.result(timeout_s)

    def live_since_tick(self, timeout_s=None):
        """The first tick that felt it; raises StateLost too."""
        self.result(timeout_s)
        return self.live.result(timeout_s)


class EditQueue:
    def __init__(self):
        self._edits = {}  # by client_seq, oldest first
        self._last_seq = 0
        self._waiting_until = None  # sends nothing: the server found that edits came too early

    def add(self, transaction, epoch):
        """Made from a scene of this epoch."""
        self._last_seq += 1
        edit = Edit(envelope_pb2.EditRequest(client_seq=self._last_seq, transaction=transaction, epoch=epoch))
        self._edits[self._last_seq] = edit
        return edit

    def take_unsent(self):
        """Requests to send now, oldest first. What came too early goes again once every answer under way is here."""
        in_flight = sum(edit.sent and not edit.reply.done() for edit in self._edits.values())
        if self._waiting_until is not None:
            if in_flight or time.monotonic() < self._waiting_until:
                return []
            self._waiting_until = None
        unsent = [edit for edit in self._edits.values() if not edit.sent and not edit.reply.done()]
        requests = []
        for edit in unsent[:MAX_IN_FLIGHT - in_flight]:
            edit.sent = True
            requests.append(edit.request)
        return requests

    def connection_lost(self):
        self._waiting_until = None
        for edit in self._edits.values():
            edit.sent = False

    def state_lost(self):
        for seq in [seq for seq, edit in self._edits.items() if edit.reply.done()]:
            self._edits.pop(seq).live.set_exception(StateLost("the server restarted without its state"))

    def replied(self, reply):
        edit = self._edits.get(reply.client_seq)
        if not edit or edit.reply.done():
            return
        if reply.HasField("accepted"):
            edit.reply.set_result(reply.accepted)
            return
        if reply.rejected.retry_after_ms:
            edit.sent = False
            self._waiting_until = time.monotonic() + 1e-3 * reply.rejected.retry_after_ms
            return
        del self._edits[reply.client_seq]
        if reply.HasField("conflict"):
            edit.reply.set_exception(Conflict(reply.conflict.reason, list(reply.conflict.current)))
        else:
            edit.reply.set_exception(Rejected(reply.rejected.field, reply.rejected.reason))

    def adopted(self, revision, tick):
        """What the servo feels: edits up to this revision are live, also those of which nobody said so."""
        for seq, edit in list(self._edits.items()):
            if edit.reply.done() and edit.reply.result().revision <= revision:
                self._edits.pop(seq).live.set_result(tick)

    def live(self, live):
        if live.client_seq in self._edits:
            self._edits.pop(live.client_seq).live.set_result(live.tick)
