"""Edits on their way to the server: numbered, kept until answered, sent again after a reconnect."""
import concurrent.futures

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

    def add(self, transaction):
        self._last_seq += 1
        edit = Edit(envelope_pb2.EditRequest(client_seq=self._last_seq, transaction=transaction))
        self._edits[self._last_seq] = edit
        return edit

    def take_unsent(self):
        """Requests to send now, oldest first. Those accepted and not yet live are asked again after a reconnect."""
        room = MAX_IN_FLIGHT - sum(edit.sent and not edit.reply.done() for edit in self._edits.values())
        requests = []
        for edit in self._edits.values():
            if edit.sent or (not edit.reply.done() and room <= 0):
                continue
            room -= not edit.reply.done()
            edit.sent = True
            requests.append(edit.request)
        return requests

    def connection_lost(self):
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
        del self._edits[reply.client_seq]
        if reply.HasField("conflict"):
            edit.reply.set_exception(Conflict(reply.conflict.reason, list(reply.conflict.current)))
        else:
            edit.reply.set_exception(Rejected(reply.rejected.field, reply.rejected.reason))

    def live(self, live):
        if live.client_seq in self._edits:
            self._edits.pop(live.client_seq).live.set_result(live.tick)
