"""Moves an object by a physics engine of its own, 20 lines of Python: the hand pushes it, and it slides and comes to rest.

    slide_block.py --seconds 10 block

The engine knows a mass that slides on a level table with dry friction, and does not turn. The force of the hand comes three
exchanges late; the damper of that times the object's stiffness takes out what this would give (guest_port.h).
"""
import argparse
import collections
import math
import sys

from animate_object import MAX_UNANSWERED, pose_edit
from haptic_client import Client, Refused, Rejected

GRAVITY_M_PER_S2, FRICTION, TICKS_EACH, TICK_S = 9.81, 0.3, 5, 1e-3
STEP_S = TICKS_EACH * TICK_S


def step(at, velocity, push_N, mass_kg, damping_Ns_per_m):
    """Place and velocity (x, y) a step later: implicit in the damping, and friction stops what it can."""
    share = 1 / (1 + damping_Ns_per_m * STEP_S / mass_kg)
    velocity = [share * (v + STEP_S / mass_kg * f) for v, f in zip(velocity, push_N)]
    speed, stopped = math.hypot(*velocity), FRICTION * GRAVITY_M_PER_S2 * STEP_S
    velocity = [v * max(0.0, 1 - stopped / speed) if speed > 0 else 0.0 for v in velocity]
    return [x + STEP_S * v for x, v in zip(at, velocity)], velocity


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--connect", default="127.0.0.1:7654", metavar="HOST:PORT")
    parser.add_argument("--credentials", metavar="FILE")
    parser.add_argument("--mass", type=float, default=0.1, metavar="KG")
    parser.add_argument("--seconds", type=float, default=10, metavar="S")
    parser.add_argument("object", metavar="NAME")
    arguments = parser.parse_args()
    try:
        with Client(arguments.connect, "slide_block", arguments.credentials, telemetry_hz=1000) as client:
            state = client.objects()[arguments.object]
            start, at, velocity, ticks = state.pose.position, [0.0, 0.0], [0.0, 0.0], []
            unanswered = collections.deque()
            for sample in client.samples(arguments.seconds):
                force = sample.force.written
                ticks.append((-force.x, -force.y) if sample.object == state.id else (0.0, 0.0))
                if len(ticks) < TICKS_EACH:
                    continue
                push_N = [sum(tick[axis] for tick in ticks) / TICKS_EACH for axis in (0, 1)]
                damping = 3 * STEP_S * state.stiffness_N_per_m if any(push_N) else 0.0
                at, velocity = step(at, velocity, push_N, arguments.mass, damping)
                ticks.clear()
                while unanswered and (unanswered[0].reply.done() or len(unanswered) >= MAX_UNANSWERED):
                    unanswered.popleft().result(10)
                unanswered.append(client.submit(pose_edit(state.id, start.x + at[0], start.y + at[1], start.z)))
            print(f"{arguments.object} is {1e3 * math.hypot(*at):.1f} mm from where it was")
    except KeyError as error:
        sys.exit(f"slide_block: there is no object {error}")
    except (Refused, Rejected) as error:
        sys.exit(f"slide_block: {error}")
    except KeyboardInterrupt:
        pass  # the object stays where it was pushed


if __name__ == "__main__":
    main()
