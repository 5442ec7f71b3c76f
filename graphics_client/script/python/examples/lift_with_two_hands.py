"""Pinches an object between two simulated hands, lifts it, holds it and puts it down. The server needs two hands:

    haptic_server --scene deploy/scenes/pinch.scene --hand nominal --hand nominal
    lift_with_two_hands.py --lift 0.05 --seconds 5 brick

The hands come from both sides along x. Each is led to a place inside the object, so that its spring presses; friction does the
rest. Says how high the object was, and how far it slid between the hands.
"""
import argparse
import sys
import time

from haptic_client import Client, NotLeading, Refused, Rejected
from haptic_text import printable
from haptics.v1 import scene_pb2

STEP_S = 0.01
BESIDE_M = 0.02  # of the object's side, where the hands come down
SECONDS_TO_CLOSE, SECONDS_TO_LIFT = 1.0, 1.5
HELD_UP_S = 0.4  # between two targets; a hand that hears of none for half a second lets go


class HeldUp(Exception):
    """The hands may have let go: this program did not get to lead them."""


def lead(client, hands, begin, end, seconds):
    """Leads both hands on straight ways, in a time. Raises HeldUp."""
    began = last = time.monotonic()
    share = 0
    while share < 1:
        now = time.monotonic()
        if now - last > HELD_UP_S:
            raise HeldUp(f"this machine held the program up for {now - last:.1f} s, and the hands let go")
        last, share = now, min((now - began) / seconds, 1)
        for hand, a, b in zip(hands, begin, end):
            hand.aim([x + (y - x) * share for x, y in zip(a, b)])
        time.sleep(STEP_S)


def height_of(client, name):
    return client.bodies()[name].pose.position.z


def grip_of(client, name):
    """Of the places where friction sticks, above the object's middle: it changes where the object slides."""
    list(client.samples(0))  # what came meanwhile is old
    return next(client.samples()).sticking_point.z - height_of(client, name)


def back_to_its_place(state):
    transaction = scene_pb2.Transaction()
    set_pose = transaction.operations.add().set_pose
    set_pose.object.id = state.id
    set_pose.pose.CopyFrom(state.pose)
    return transaction


def lift(client, state, arguments):
    """(height at which the object was held, how far it slid there), m. Raises HeldUp."""
    at = state.pose.position
    grip_z = at.z + arguments.above
    hands = [client.hand(1), client.hand(2)]
    with hands[0], hands[1]:
        beside = [(at.x + side * (arguments.half_width + BESIDE_M), at.y, grip_z) for side in (-1, 1)]
        above = [(x, y, z + 0.06) for x, y, z in beside]
        inside = [(at.x + side * (arguments.half_width - arguments.press), at.y, grip_z) for side in (-1, 1)]
        raised = [(x, y, z + arguments.lift) for x, y, z in inside]
        lead(client, hands, [hand.position for hand in hands], above, 2.0)
        client.apply(back_to_its_place(state))  # the hands may have pushed it before
        lead(client, hands, above, beside, 1.0)
        lead(client, hands, beside, inside, SECONDS_TO_CLOSE)
        lead(client, hands, inside, raised, SECONDS_TO_LIFT)
        lead(client, hands, raised, raised, 0.5)
        grip, height, slid = grip_of(client, state.name), height_of(client, state.name), 0
        end = time.monotonic() + arguments.seconds
        while time.monotonic() < end:
            lead(client, hands, raised, raised, 0.1)
            slid = max(slid, abs(grip_of(client, state.name) - grip))
        lead(client, hands, raised, inside, SECONDS_TO_LIFT)
        lead(client, hands, inside, beside, SECONDS_TO_CLOSE)
        lead(client, hands, beside, above, 0.5)
    return height - at.z, slid


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--connect", default="127.0.0.1:7654", metavar="HOST:PORT")
    parser.add_argument("--credentials", metavar="FILE")
    parser.add_argument("--half-width", type=float, default=0.025, metavar="M", help="of the object along x (0.025)")
    parser.add_argument("--press", type=float, default=0.006, metavar="M", help="how far inside the hands are led (0.006)")
    parser.add_argument("--above", type=float, default=0.003, metavar="M", help="of its middle they hold it (0.003)")
    parser.add_argument("--lift", type=float, default=0.05, metavar="M")
    parser.add_argument("--seconds", type=float, default=5, metavar="S", help="for which it is held")
    parser.add_argument("object", metavar="NAME")
    arguments = parser.parse_args()
    try:
        with Client(arguments.connect, "lift_with_two_hands", arguments.credentials, telemetry_hz=100) as client:
            client.wait_live()
            state = client.objects().get(arguments.object)
            if state is None:
                sys.exit(f'lift_with_two_hands: there is no object "{arguments.object}"; '
                         f'there are: {printable(", ".join(sorted(client.objects())))}')
            height, slid = lift(client, state, arguments)
    except (HeldUp, NotLeading, Refused, Rejected) as error:
        sys.exit(f"lift_with_two_hands: {error}")
    except KeyboardInterrupt:
        return  # the hands let go
    print(f"{printable(arguments.object)} was held {1e3 * height:.1f} mm above its place, and slid {1e3 * slid:.2f} mm "
          "meanwhile")


if __name__ == "__main__":
    main()
