"""Where an experiment takes place: on a server, or on forces that are computed in this process.

Both present a stimulus (apply) and have a led hand explore it (explore), which returns what it felt. Interrupted is raised
where an interval cannot be judged: the trial is repeated with the same stimuli.
"""
import math
import tempfile
import time

import numpy
from google.protobuf import text_format

from haptic_client import Client, Closed, Conflict, NotLeading, Refused, Rejected, StateLost
from haptic_experiment.design import Press
from haptic_experiment.felt import Felt
from haptic_hand import xyz
from haptic_text import printable
from haptics.v1 import scene_pb2, telemetry_pb2

SAMPLES_HZ = 1000.0
CLEAR_M = 0.01          # above the surface, between intervals
ENOUGH_SAMPLES = 0.05   # of those asked for, below which an interval is not judged
WHOLE = 0.97            # of the computed force is written, or an interval of the led hand is void
TICKS = 10              # of an in-process hand's command, 10 ms
COMMAND = numpy.linspace(0, 1, TICKS)[:, None]
APPROACH_M = 0.003      # of an in-process hand, above the surface at first
ATTACH_TICKS = 600      # in which the force of a device that was just attached rises
STIFFEST_N_PER_M = 2000  # on which an in-process hand still presses without overshoot
LANDED_SHARE = 0.995    # of the force, from which on an in-process hand has landed
LONGEST_LANDING = 150   # commands


class Interrupted(Exception):
    """The interval is void: why. `lost`: so is the connection, the hand's lead or the scene."""

    def __init__(self, why, lost=True):
        super().__init__(why)
        self.lost = lost


class SessionRefused(Exception):
    """The session cannot take place: what to change."""


def objects_of(scene):
    """Names of the objects that a transaction adds."""
    return [operation.add.name for operation in text_format.Parse(scene, scene_pb2.Transaction()).operations
            if operation.HasField("add")]


class ServerSession:
    """On a running server. `leads`: the simulated hand is led; else a person holds the device. The server's scene must be
    empty, or hold the experiment's objects alone. Raises SessionRefused."""

    def __init__(self, address, scene, leads, credentials=None):
        self._address, self._credentials, self._scene, self._leads = address, credentials, scene, leads
        self._client = self._hand = None
        try:
            self._connect()
        except Refused as error:
            raise SessionRefused(str(error)) from None
        except BaseException:
            self.close()
            raise

    @property
    def device(self):
        """What the server drives, in its words."""
        return printable(self._client.device)

    def _connect(self):
        self._client = Client(self._address, "haptic_experiment", self._credentials, every_tick=True)
        self._client.wait_live()
        names = objects_of(self._scene)
        there = self._client.objects()
        if others := [name for name in there if name not in names]:
            raise SessionRefused(printable(f"the server's scene holds {', '.join(others)}; an experiment needs the scene for "
                                           "itself: start a server without --scene"))
        removals = "".join(f'operations {{ remove {{ object {{ name: "{name}" }} }} }}\n' for name in names if name in there)
        try:
            self._revision = self._client.apply(removals + self._scene)[0].revision
            if self._leads:
                self._hand = self._client.hand().__enter__()
        except NotLeading as error:
            raise SessionRefused(f"a simulated participant needs the server's simulated hand: {error}") from None
        except (Rejected, Conflict) as error:
            raise SessionRefused(f"the server refuses the experiment's scene: {error}") from None

    def close(self):
        if self._hand:
            self._hand.__exit__()
            self._hand = None
        if self._client:
            self._client.close()

    def recover(self, timeout_s):
        """Connects anew and puts the scene in place. Raises SessionRefused when that does not succeed in time."""
        end = time.monotonic() + timeout_s
        while True:
            self.close()
            try:
                return self._connect()
            except (Refused, TimeoutError, StateLost, Closed, SessionRefused) as error:
                if time.monotonic() > end:
                    raise SessionRefused(f"the server has not come back within {timeout_s:g} s: {error}") from None
                time.sleep(0.5)

    def apply(self, transaction):
        """Presents a stimulus: returns once it is felt. Raises Interrupted, SessionRefused."""
        try:
            self._revision = self._client.apply(transaction, timeout_s=10)[0].revision
        except (Closed, StateLost, TimeoutError, Conflict) as error:
            raise Interrupted(f"the server did not take the stimulus: {error}") from None
        except Rejected as error:
            raise SessionRefused(f"the server refuses the stimulus: {error}") from None

    def explore(self, exploration):
        """The led hand presses or strokes, and lifts: what it Felt. Raises Interrupted."""
        place, normal = exploration.place, exploration.normal
        above = [p + CLEAR_M * n for p, n in zip(place, normal)]
        try:
            self._hand.move_to(above)
            list(self._client.samples(0))
            if isinstance(exploration, Press):
                samples = self._hand.press(place, normal, exploration.force_N, exploration.seconds)
                end, seconds = above, exploration.seconds
            else:
                samples = self._hand.stroke([place, exploration.end], normal, exploration.force_N, exploration.speed)
                end = [p + CLEAR_M * n for p, n in zip(exploration.end, normal)]
                seconds = numpy.linalg.norm(numpy.subtract(exploration.end, place)) / exploration.speed
            self._hand.move_to(end)
        except (NotLeading, Closed, TimeoutError) as error:
            raise Interrupted(f"the hand was lost: {error}") from None
        felt = self._judged(samples, seconds)
        if any(math.hypot(*xyz(sample.force.written)) < WHOLE * math.hypot(*xyz(sample.force.contact)) for sample in samples):
            raise Interrupted("the force was limited, or still rose after a fault", lost=False)
        return felt

    def feel(self, seconds):
        """A person feels the stimulus: what was Felt. Raises Interrupted."""
        try:
            return self._judged(list(self._client.samples(seconds)), seconds)
        except Closed as error:
            raise Interrupted(str(error)) from None

    def samples(self, seconds):
        """Telemetry of some seconds, as it comes. Raises Interrupted where the server has gone."""
        came = False
        try:
            for sample in self._client.samples(seconds):
                came = True
                yield sample
        except Closed as error:
            raise Interrupted(str(error)) from None
        if not came and seconds >= 0.5:
            raise Interrupted("the server sends no samples")

    def _judged(self, samples, seconds):
        if len(samples) < ENOUGH_SAMPLES * seconds * SAMPLES_HZ:
            raise Interrupted(f"{len(samples)} samples came in {seconds:g} s", lost=not samples)
        if faults := [sample.fault for sample in samples if sample.fault]:
            fault = telemetry_pb2.Fault.Name(faults[0]).removeprefix("FAULT_").lower()
            raise Interrupted(f"the force was taken away: {fault}", lost=False)
        if samples[-1].scene_revision != self._revision:
            raise Interrupted("another client changed the scene")
        touching = [sample for sample in samples if sample.object]
        def column(of, width):
            return numpy.array([of(sample) for sample in touching], float).reshape(-1, *width)
        return Felt(numpy.array([sample.tick for sample in touching], numpy.int64), column(lambda s: xyz(s.hip), (3,)),
                    column(lambda s: xyz(s.force.written), (3,)), column(lambda s: xyz(s.surface_normal), (3,)),
                    column(lambda s: s.penetration_m, ()), len(samples) / seconds)


class WorldSession:
    """In this process, by haptics.SceneWorld: the server's step, as fast as it goes. The hand is a command of depth each 10 ms,
    which approaches the force asked for, and holds its depth along a stroke. Needs a simulated participant."""

    device = "Phantom Omni (in process)"

    def __init__(self, scene, device="omni"):
        import haptics
        if not hasattr(haptics, "SceneWorld"):
            raise SessionRefused("this Python client was built without the module that computes forces in this process; build it "
                                 "(cmake --build --preset release --target python_world), or give a server (--connect)")
        with tempfile.NamedTemporaryFile("w", suffix=".scene") as file:
            file.write(scene)
            file.flush()
            self._world = haptics.SceneWorld(file.name, haptics.Device.named(device))
        self._ticks = 0

    def close(self):
        pass

    def recover(self, timeout_s):
        pass

    def apply(self, transaction):
        """Presents a stimulus. Raises SessionRefused."""
        try:
            self._world.apply(transaction)
        except ValueError as error:
            raise SessionRefused(f"the stimulus is refused: {error}") from None

    def explore(self, exploration):
        """The hand presses or strokes, and lifts: what it Felt."""
        place, normal = numpy.array(exploration.place, float), numpy.array(exploration.normal, float)
        depth = self._land(place, normal, exploration.force_N)
        if isinstance(exploration, Press):
            positions = numpy.repeat([place - depth * normal], round(exploration.seconds * SAMPLES_HZ), 0)
        else:
            end = numpy.array(exploration.end, float)
            count = round(numpy.linalg.norm(end - place) / exploration.speed * SAMPLES_HZ)
            positions = numpy.linspace(place, end, count) - depth * normal
        felt = self._felt(positions)
        last = positions[-1]
        self._step(numpy.linspace(last, last + (depth + APPROACH_M) * normal, 3 * TICKS))
        return felt

    def _land(self, place, normal, force_N):
        """Presses until the force is there: the depth. Depth += (force wanted - force) / (stiffest surface), a command."""
        if not self._ticks:
            self._step(numpy.repeat([place + APPROACH_M * normal], ATTACH_TICKS, 0))
        self._step(numpy.linspace(place + APPROACH_M * normal, place, 3 * TICKS))
        depth = force = 0.0
        for _ in range(LONGEST_LANDING):
            deeper = depth + (force_N - force) / STIFFEST_N_PER_M
            samples = self._step(place - (depth + (deeper - depth) * COMMAND) * normal)
            depth, force = deeper, float(samples["force_N"][-1] @ normal)
            if force >= LANDED_SHARE * force_N:
                break
        return depth

    def _step(self, positions):
        self._ticks += len(positions)
        return self._world.run(numpy.ascontiguousarray(positions))

    def _felt(self, positions):
        first = self._ticks + 1
        samples = self._step(positions)
        touching = samples["body"] != 0
        return Felt(numpy.arange(first, first + len(samples))[touching], positions[touching], samples["force_N"][touching],
                    samples["normal"][touching], samples["penetration_m"][touching], SAMPLES_HZ)
