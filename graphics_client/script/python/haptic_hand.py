"""A simulated hand, led by a script: Client.hand(). One client at a time leads it; a real device is nobody's but its user's.

    with Client(telemetry_hz=100) as client, client.hand() as hand:
        hand.move_to((0, 0, 0.08))
        felt = hand.stroke([(0, 0, 0.05), (0.02, 0, 0.05)], normal=(0, 0, 1), force_N=1.5)

Metres, newtons, seconds; world frame. A method returns the telemetry samples of the time that it took: what was felt. The
hand is let go of at the end of the block, or when the connection ends. Where the server has two hands, one client may lead
both, hand(1) and hand(2), each with aim(); felt by the second is what a sample's second_hand says.
"""
import math
import time

from haptic_edits import Closed
from haptic_text import printable
from haptics.v1 import envelope_pb2, scene_pb2

TARGET_S = 0.01          # between two targets of a movement
REPEAT_S = 0.03          # between repetitions of one
TRAVEL_SPEED = 0.2       # m/s
LANDING_SPEED = 0.05     # m/s, on a surface
SAME_PLACE_M = 0.005     # of a surface: pressed on without a lift in between
CONTACT_SHARE = 0.9      # of the force, from which on a stroke starts
CONTACT_WITHIN_S = 1.5


class NotLeading(Exception):
    """Another client leads the hand, there is none to lead, or the connection was lost: what the server said."""


class HandLead:
    """Whether this client leads, what it has to send for that, and where the hand is. `changed`: the client's condition,
    which its thread holds; `state`: (live, why there is no more to wait for, trouble); `hand`: 0 or 1; `has_second`: whether
    the server has a second one."""

    def __init__(self, changed, wake, state, hand, has_second):
        self._changed, self._wake, self._state, self.hand, self._has_second = changed, wake, state, hand, has_second
        self.position = None  # of the device in the newest sample
        self.leader = None    # the server's last word since the client asked
        self._request = self._target = None
        self._moves = []      # of the workspace
        self._wrench, self._wrench_due = None, 0.0
        self._asks = None     # for the lead, or to give it back; None: answered
        self._due = 0.0       # of the target's next repetition

    def lead(self, lead, timeout_s=5.0):
        """Asks for the lead and waits for the answer, or gives it back. Raises NotLeading, Closed, TimeoutError."""
        with self._changed:
            if lead and self.hand and not self._has_second():
                raise NotLeading("there is no second hand: this server has one")
            self._request, self._asks, self.leader, self._target = lead, lead, None, None
            self._wake()
            answered = self._changed.wait_for(lambda: self.leader or self._end() or not self._state()[0], timeout_s)
            if lead and not self.leader:  # nobody waits for the lead any more
                self._request, self._asks = (False, False) if self._state()[0] else (None, None)
            if not lead:
                return
            if self._end():
                raise Closed(self._end())
            if not answered:
                raise TimeoutError("the server has not said who leads the hand")
            self._check()

    def command(self, target):
        """Sends a target, again and again."""
        with self._changed:
            self._check()
            self._target, self._due = target, 0.0
        self._wake()

    def move_workspace(self, move):
        with self._changed:
            self._moves.append(move)
        self._wake()

    def add_wrench(self, force_N, torque_Nm):
        wrench = envelope_pb2.AddWrench(hand=self.hand, force_N=vector(force_N), torque_Nm=vector(torque_Nm))
        with self._changed:
            self._wrench, self._wrench_due = wrench, 0.0
        self._wake()

    def where(self, timeout_s=5.0):
        with self._changed:
            if not self._changed.wait_for(lambda: self.position or self._end(), timeout_s):
                raise TimeoutError("the server has sent no telemetry")
            return self.position

    def _end(self):
        return self._state()[1]

    def _check(self):
        if not self.leader:
            raise NotLeading(f"the hand is let go of: {self._state()[2]}")
        if not self.leader.you:
            raise NotLeading(printable(self.leader.refused or f"the hand is led by {self.leader.client_name}"))

    # ---- the client's thread ----

    def answered(self, leader):
        if self._asks is not None and self._asks != leader.you and not leader.refused:
            return  # of a change before the answer
        self._asks = None
        self.leader = leader
        if not leader.you:
            self._target = None

    def connection_lost(self):
        self.leader = self._target = self._wrench = self._request = self._asks = None

    def take_unsent(self):
        """Bodies of envelopes."""
        bodies, now = [{"set_workspace": move} for move in self._moves], time.monotonic()
        self._moves.clear()
        if self._request is not None:
            bodies.append({"lead_hand": envelope_pb2.LeadHand(lead=self._request, hand=self.hand)})
            self._request = None
        if self._target and now >= self._due:
            bodies.append({"hand_target": self._target})
            self._due = now + REPEAT_S
        if self._wrench and now >= self._wrench_due:
            bodies.append({"add_wrench": self._wrench})
            self._wrench_due = now + REPEAT_S
            if not any(xyz(self._wrench.force_N) + xyz(self._wrench.torque_Nm)):
                self._wrench = None
        return bodies


class Hand:
    """`felt`: the samples that come within some seconds. The Client's."""

    def __init__(self, felt, lead):
        self._felt, self._lead = felt, lead
        self._at, self._presses = None, False  # position of the last target, and whether it presses there
        self._normal, self._force_N = (0, 0, 0), 0  # of the last target
        self._rotation, self._buttons, self._gripper_rad = None, 0, None

    def __enter__(self):
        self._lead.lead(True)
        self._at = self._lead.where()
        return self

    def __exit__(self, *_):
        self._lead.lead(False)

    @property
    def position(self):
        """Where the device is, as measured last."""
        return self._lead.where()

    def move_to(self, position, speed=TRAVEL_SPEED):
        """In a straight line, pressing nowhere. `speed` in m/s, at most 0.6."""
        return self._follow([self._at, position], speed, None, 0)

    def turn(self, rotation, seconds=0.5):
        """A device that senses how it is turned, to the quaternion (w, x, y, z) from upright, from now on; the hand stays where
        it is, and goes on pressing. At most 2 rad/s."""
        self._rotation = scene_pb2.Quaternion(**dict(zip("wxyz", rotation)))
        return self._hold(self._at, self._normal, self._force_N, seconds)

    def hold_buttons(self, bits, seconds=0.1):
        """Presses these buttons (bits as in device_buttons) and lets go of all others, from now on; 0: none. The hand stays where
        it is, and goes on pressing. What a button does: Client.move_workspace()."""
        self._buttons = bits
        return self._hold(self._at, self._normal, self._force_N, seconds)

    def open_gripper(self, angle_rad, seconds=0.5):
        """Of a device that has a gripper, so far (0: closed; at most as far as it goes), from now on; the hand stays where it is,
        and goes on pressing. At most 2 rad/s."""
        self._gripper_rad = angle_rad
        return self._hold(self._at, self._normal, self._force_N, seconds)

    def aim(self, position, normal=(0, 0, 0), force_N=0):
        """Sends where the hand is to be and returns at once; it is sent again until another one is. With a force: a place of a
        surface, pressed against its normal."""
        self._target(position, normal, force_N)

    def press(self, position, normal, force_N, seconds=1.0):
        """On a place of a surface, against its normal."""
        self._land(position, normal, force_N)
        return self._hold(position, normal, force_N, seconds)

    def stroke(self, points, normal, force_N, speed=0.08):
        """Along points of a surface. `normal`: of all of them, or one for each. It starts once the hand presses."""
        normals = normal if hasattr(normal[0], "__len__") else [normal] * len(points)
        if len(normals) != len(points):
            raise ValueError(f"{len(points)} points have {len(normals)} normals")
        self._land(points[0], normals[0], force_N)
        return self._follow(points, speed, normals, force_N)

    def _land(self, position, normal, force_N):
        """Slowly, until it presses; a hand that presses there already does not lift. Not a part of what was felt."""
        if not self._presses or math.dist(self._at, position) > SAME_PLACE_M:
            self._follow([self._at, position], LANDING_SPEED, None, 0)
        self._hold(position, normal, force_N, CONTACT_WITHIN_S, until_N=CONTACT_SHARE * force_N)

    def _hold(self, position, normal, force_N, seconds, until_N=math.inf):
        felt, end = [], time.monotonic() + seconds
        while time.monotonic() < end:
            self._target(position, normal, force_N)
            felt += self._felt(TARGET_S)
            if felt and self._force(felt[-1]) >= until_N:
                break
        return felt

    def _follow(self, points, speed, normals, force_N):
        """Along the line through the points, at this speed."""
        felt = []
        for index, (begin, end) in enumerate(zip(points, points[1:])):
            began, seconds, share = time.monotonic(), math.dist(begin, end) / speed, 0
            while share < 1:
                share = min((time.monotonic() - began) / seconds, 1) if seconds else 1
                normal = unit(mix(*normals[index:index + 2], share)) if normals else (0, 0, 0)
                self._target(mix(begin, end, share), normal, force_N)
                felt += self._felt(TARGET_S)
        return felt

    def _force(self, sample):
        of = sample.second_hand if self._lead.hand else sample
        return math.hypot(*xyz(of.force.written))

    def _target(self, position, normal, force_N):
        self._at, self._presses = tuple(position), force_N > 0
        self._normal, self._force_N = normal, force_N
        self._lead.command(envelope_pb2.HandTarget(
            position=vector(position), normal=vector(normal), press_N=force_N, rotation=self._rotation,
            buttons=self._buttons, gripper_rad=self._gripper_rad, hand=self._lead.hand))


def mix(a, b, share):
    return [x + (y - x) * share for x, y in zip(a, b)]


def unit(numbers):
    length = math.hypot(*numbers)
    return [number / length for number in numbers]


def vector(numbers):
    x, y, z = numbers
    return scene_pb2.Vector3(x=x, y=y, z=z)


def xyz(message):
    return message.x, message.y, message.z
