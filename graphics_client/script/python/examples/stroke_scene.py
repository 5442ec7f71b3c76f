"""Leads the simulated hand over the objects of a scene: down until it touches one, along its surface, and to and fro
there with a set force. A line for each visit says what the strokes felt.

    stroke_scene.py                                 every object once
    stroke_scene.py --force 2 torus box             these, pressed with 2 N
    stroke_scene.py --seconds 600                   all in turn for ten minutes, or until Ctrl-C

It knows where objects are, and feels the rest. "contact" is the share of ticks that touch the object, "force" the mean,
"step" the largest change of the force from one tick to the next.
"""
import argparse
import itertools
import math
import statistics
import sys
import time

from haptic_client import Client, Closed, NotLeading, Refused
from haptic_hand import xyz
from haptic_text import printable

VISIT_S = 3                   # of strokes on an object
CLEAR_M = 0.12                # above the highest object's position: the hand crosses there
DOWN_SPEED, DOWN_STEP_M = 0.1, 0.002  # m/s; between two looks whether it touches
RINGS_M = (0.04, 0.08, 0.02)  # around an object's position, where it is sought too
BELOW_M = 0.02                # an object's position: sought down to there
LIFT_M = 0.01                 # at the end of the line
LANDED_S = 0.2                # of pressing, until what is touched counts
STEP_M, STEPS = 0.006, 6      # of feeling along the surface, each way
EDGE_M = 0.003                # left of the line at its ends: an edge may be near
STEEPEST = 0.5                # z of a normal below which it turns back


class Surface:
    """A line on an object, found by the hand, and strokes along it. Places are (position, normal)."""

    def __init__(self, client, hand, name, force_N):
        self._client, self._hand, self._name, self._force_N = client, hand, name, force_N
        self._object = client.objects()[name].id

    def find(self, top):
        """Comes down on the object from the height `top`: the line, or None where nothing or something else is met."""
        x, y, z = self._position()
        for dx, dy, r in ((1, 0, 0), *((*way, r) for way in ((1, 0), (-1, 0), (0, 1), (0, -1)) for r in RINGS_M)):
            self._hand.move_to((*self._hand.position[:2], top))
            self._hand.move_to((x + r * dx, y + r * dy, top))
            if place := self._come_down(x + r * dx, y + r * dy, top, z - BELOW_M):
                return self._trace(place)
        return None

    def stroke(self, line, seconds):
        """To and fro: what was felt."""
        if len(line) == 1:
            return self._hand.press(*line[0], self._force_N, seconds)
        felt, end = [], time.monotonic() + seconds
        while time.monotonic() < end:
            felt += self._hand.stroke([position for position, _ in line], [normal for _, normal in line], self._force_N)
            line = line[::-1]
        return felt

    def report(self, felt):
        contact = statistics.mean(sample.object == self._object for sample in felt)
        forces = [xyz(sample.force.written) for sample in felt]
        mean = statistics.mean(math.hypot(*force) for force in forces)
        step = max(math.dist(f, g) for f, g, a, b in zip(forces, forces[1:], felt, felt[1:]) if b.tick == a.tick + 1)
        return f"contact {100 * contact:.1f} %  force {mean:.3f} N  step {step:.3f} N"

    def _position(self):
        body = self._client.bodies().get(self._name)
        return xyz((body or self._client.objects()[self._name]).pose.position)

    def _come_down(self, x, y, top, bottom):
        for step in range(1, math.ceil((top - bottom) / DOWN_STEP_M)):
            felt = self._hand.move_to((x, y, top - step * DOWN_STEP_M), DOWN_SPEED)
            if felt and felt[-1].object:
                place, normal = xyz(felt[-1].ihip), xyz(felt[-1].surface_normal)
                return self._touched(self._hand.press(place, normal, self._force_N, LANDED_S))
        return None

    def _trace(self, place):
        """Along x to one end, and from there to the other: places in order."""
        for direction, steps in ((1, STEPS), (-1, 2 * STEPS)):
            line = [place]
            while len(line) <= steps:
                at, normal = line[-1]
                ahead = [p + STEP_M * t for p, t in zip(at, tangent(normal, direction))]
                place = self._touched(self._hand.stroke([at, ahead], normal, self._force_N))
                if not place or place[1][2] < STEEPEST:
                    break
                line.append(place)
            line = [p for p in line if math.dist(p[0], line[-1][0]) > EDGE_M] or line[:1]
            self._hand.move_to([p + LIFT_M * n for p, n in zip(ahead, normal)])
            place = line[-1]
        return line

    def _touched(self, felt):
        last = felt[-1] if felt else None
        return (xyz(last.ihip), xyz(last.surface_normal)) if last and last.object == self._object else None


def tangent(normal, direction):
    """Unit: the part of the x axis along the surface."""
    x, y, z = normal
    length = math.sqrt(max(1 - x * x, 1e-6))
    return [direction * part / length for part in (1 - x * x, -x * y, -x * z)]


def stroke_scene(client, hand, arguments):
    objects = client.objects()
    names = arguments.objects or list(objects)
    if unknown := set(names) - set(objects):
        sys.exit(printable(f"stroke_scene: there is no {', '.join(unknown)}; there are {', '.join(objects)}"))
    top = CLEAR_M + max((state.pose.position.z for state in objects.values()), default=0)
    end = time.monotonic() + (arguments.seconds or math.inf)
    for name in itertools.cycle(names) if arguments.seconds else names:
        surface = Surface(client, hand, name, arguments.force)
        line = surface.find(top)
        seconds = min(VISIT_S, end - time.monotonic())
        if seconds <= 0:
            break
        felt = surface.report(surface.stroke(line, seconds)) if line else "not met from above"
        print(f"{printable(name)}: {felt}", flush=True)
    hand.move_to((*hand.position[:2], top))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--connect", default="127.0.0.1:7654", metavar="HOST:PORT")
    parser.add_argument("--credentials", metavar="FILE")
    parser.add_argument("--force", type=float, default=1, metavar="N", help="that the hand presses with (1)")
    parser.add_argument("--seconds", type=float, metavar="S", help="in all; else every object once")
    parser.add_argument("objects", nargs="*", metavar="NAME", help="objects to stroke (all)")
    arguments = parser.parse_args()
    try:
        with Client(arguments.connect, "stroke_scene", arguments.credentials, 1000) as client, client.hand() as hand:
            stroke_scene(client, hand, arguments)
    except (Refused, NotLeading, Closed) as error:
        sys.exit(f"stroke_scene: {error}")
    except KeyboardInterrupt:
        pass  # the hand is let go of


if __name__ == "__main__":
    main()
