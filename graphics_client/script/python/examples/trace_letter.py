"""Lets the guidance of trace_letter.scene fade as the hand gets better at the letter, and come back where it gets worse.

    trace_letter.py                    until the letter is traced without guidance, or Ctrl-C
    trace_letter.py --passes 3         three times along the letter
    trace_letter.py --lead             leads the simulated hand along it, where nobody holds a device

The hand traces the letter from its upper end to its lower one, again and again. After each pass a line says how far the hand was
from it, and how stiff the guide is for the next: 30 % less after a pass within --good, 40 % more after another one, up to what the
scene has. Below 20 N/m there is none, and the letter is only seen. At the end the scene has its own again.
"""
import argparse
import contextlib
import math
import sys

from haptic_client import Client, Closed, NotLeading, Refused, Rejected
from haptics.v1 import scene_pb2

LESS, MORE, NONE_BELOW_N_PER_M = 0.7, 1.4, 20
UNFELT_N_PER_M = 0.01  # the least that a guide may have
END_M = 0.004    # so near its upper end a pass begins, and likewise ends
NEAR_M = 0.015   # what is farther from the letter is no tracing
ABOVE_M, PRESSED_N = 0.03, 0.5  # on the way back to its upper end, and on the letter, of a hand that is led


def nearest(points, x):
    """(distance, progress in points) of the nearest place on a path."""
    best = (math.inf, 0.0)
    for i, (a, b) in enumerate(zip(points, points[1:])):
        way = [q - p for p, q in zip(a, b)]
        part = sum((v - p) * w for v, p, w in zip(x, a, way)) / sum(w * w for w in way)
        part = min(max(part, 0.0), 1.0)
        best = min(best, (math.dist(x, [p + part * w for p, w in zip(a, way)]), i + part))
    return best


class Passes:
    """Of the hand along a path: None, or the mean distance from it where a pass has just ended."""

    def __init__(self, points):
        self._points, self._distances = points, None

    def add(self, place):
        distance, progress = nearest(self._points, place)
        if math.dist(place, self._points[0]) < END_M:
            self._distances = []
        if self._distances is None or distance > NEAR_M:
            return None
        self._distances.append(distance)
        if math.dist(place, self._points[-1]) > END_M or progress < len(self._points) / 2:
            return None
        mean, self._distances = sum(self._distances) / len(self._distances), None
        return mean


def guide_of(client, name):
    """(the object's state, which of its effects is the guide)"""
    state = client.objects().get(name)
    kinds = [effect.kind for effect in state.effects] if state else []
    if scene_pb2.EFFECT_KIND_GUIDE not in kinds:
        sys.exit(f'trace_letter: no object "{name}" has a guide; open trace_letter.scene')
    return state, kinds.index(scene_pb2.EFFECT_KIND_GUIDE)


def edit(state, which, stiffness_N_per_m):
    """With the guide as stiff, or as a line that is not felt."""
    transaction = scene_pb2.Transaction()
    operation = transaction.operations.add().set_effects
    operation.object.id = state.id
    operation.effects.extend(state.effects)
    guide = operation.effects[which]
    guide.stiffness_N_per_m = stiffness_N_per_m
    if stiffness_N_per_m < NONE_BELOW_N_PER_M:
        guide.stiffness_N_per_m, guide.damping_Ns_per_m = UNFELT_N_PER_M, 0
    return transaction


def in_world(state, path_m):
    """Of an object that is not turned."""
    at = (state.pose.position.x, state.pose.position.y, state.pose.position.z)
    return [[p + q for p, q in zip(path_m[i:i + 3], at)] for i in range(0, len(path_m), 3)]


def led(hand, letter):
    """What it feels, for ever."""
    while True:
        x, y, z = letter[0]
        hand.move_to((*hand.position[:2], z + ABOVE_M))
        hand.move_to((x, y, z + ABOVE_M))
        yield from hand.stroke(letter, (0, 0, 1), PRESSED_N)


def trace(client, hand, state, which, arguments):
    guide = state.effects[which]
    letter = in_world(state, guide.path_m)
    passes, stiffness, done = Passes(letter), guide.stiffness_N_per_m, 0
    for sample in led(hand, letter) if hand else client.samples():
        mean = passes.add((sample.hip.x, sample.hip.y, sample.hip.z))
        if mean is None:
            continue
        done += 1
        was, stiffness = stiffness, min(stiffness * (LESS if mean < arguments.good else MORE), guide.stiffness_N_per_m)
        print(f"pass {done}: {1000 * mean:.1f} mm from the letter under {was:.0f} N/m", flush=True)
        if was < NONE_BELOW_N_PER_M and mean < arguments.good:
            print("traced without guidance")
            return
        client.apply(edit(state, which, stiffness))
        if done == arguments.passes:
            return


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--connect", default="127.0.0.1:7654", metavar="HOST:PORT")
    parser.add_argument("--credentials", metavar="FILE")
    parser.add_argument("--passes", type=int, metavar="N")
    parser.add_argument("--lead", action="store_true", help="lead the simulated hand along the letter")
    parser.add_argument("--good", type=float, default=0.002, metavar="M", help="mean distance of a good pass; default 0.002")
    parser.add_argument("object", nargs="?", default="sheet", metavar="NAME")
    arguments = parser.parse_args()
    try:
        with Client(arguments.connect, "trace_letter", arguments.credentials, telemetry_hz=200) as client:
            state, which = guide_of(client, arguments.object)
            try:
                with client.hand() if arguments.lead else contextlib.nullcontext() as hand:
                    trace(client, hand, state, which, arguments)
            finally:
                client.apply(edit(state, which, state.effects[which].stiffness_N_per_m))
    except (Closed, NotLeading, Refused, Rejected) as error:
        sys.exit(f"trace_letter: {error}")
    except KeyboardInterrupt:
        pass  # the guide is the scene's again


if __name__ == "__main__":
    main()
