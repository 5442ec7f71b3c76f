"""Edits by the viewer's window: a slider that is dragged is felt at once, undo gives the first scene again beside another
editor, who is never overwritten, and a window in which nothing happens costs next to nothing."""
import copy
import os
import random
import statistics
import time
import unittest
from pathlib import Path

import harness
from haptic_client import Client
from led_hand import GROUND
from viewer_window import MessageBus, ReadableWindow, Window

EDITS = int(os.environ.get("HAPTICS_EDITS", "8"))
# On a quiet machine 30 ms and 0.05; beside others the clock says less.
MAX_FELT_MS = float(os.environ.get("HAPTICS_MAX_FELT_MS", "100"))
MAX_IDLE = float(os.environ.get("HAPTICS_MAX_IDLE", "0.1"))
SEED = int(os.environ.get("HAPTICS_SEED", "1"))
ON_GROUND = (760, 400)


def content(client):
    """Of the scene, without what an object gets anew when it is added again: its id, and revisions."""
    kept = {}
    for name, state in client.objects().items():
        state = copy.copy(state)  # the client goes on with its own
        state.ClearField("id")
        state.ClearField("revision")
        kept[name] = state.SerializeToString(deterministic=True)
    return kept


class WindowEdits(harness.EndToEnd):
    def start(self, scene=GROUND, options=()):
        self.server = self.start_server(scene=scene, options=options)
        bus = MessageBus()
        self.addCleanup(bus.close)
        self.window = ReadableWindow(self.server.address, self.start_display(), bus)
        self.addCleanup(self.window.kill)
        self.other = Client(self.server.address, "second editor", telemetry_hz=1000)
        self.other.wait_live()
        self.addCleanup(self.other.close)

    def revision(self):
        return self.other.revision_and_root()[0]

    def stiffness(self):
        return self.other.objects()["ground"].stiffness_N_per_m

    def wait_past(self, revision, what):
        harness.wait_until(lambda: self.revision() > revision, 20, what, pause_s=0.005)

    def set_stiffness(self, place, value):
        """Types it into the panel's field, which is there."""
        self.window.click(*place)
        self.window.do("key", "ctrl+a")
        self.window.do("type", str(value))
        self.window.do("key", "Return")

    def test_a_dragged_slider_is_felt_at_once_and_its_last_value_arrives(self):
        self.start()
        self.window.click(*ON_GROUND)
        self.window.widget("label", "^ground$")
        slider = self.window.widget("slider", "^stiffness slider$")
        x, y, width, height = slider["box"]
        handle = x + round(width * slider["value"] / slider["max"]), y + height // 2
        self.window.move_to(*handle)
        self.window.do("mousedown", 1)
        waits_ms, draw = [], random.Random(SEED)
        for step in [*range(1, 21), *range(19, 0, -1), *range(2, 21)]:  # pixels, to and fro: the panel is narrow
            before = self.revision()
            at_ns = time.monotonic_ns()
            self.window.move_to(handle[0] - step, handle[1])
            felt = next(sample for sample in self.other.samples(5) if sample.scene_revision > before)
            waits_ms.append(1e-6 * (felt.time_ns - at_ns))
            time.sleep(draw.uniform(0.02, 0.08))
        self.window.do("mousemove_relative", "--", -12, 0, "mousemove_relative", 7, 0, "mouseup", 1)
        shown = self.window.widget("spin button", "^stiffness$")["value"]
        harness.wait_until(lambda: abs(self.stiffness() - shown) < 1, 5, "the server holds the slider's last value")
        waits_ms.sort()
        print(f"\n{len(waits_ms)} steps of a slider, felt after {statistics.median(waits_ms):.1f} ms (median), at most "
              f"{waits_ms[-1]:.1f} ms", end="", flush=True)
        self.assertLessEqual(statistics.median(waits_ms), MAX_FELT_MS)
        before = self.revision()
        self.window.do("key", "ctrl+z")  # the drag is one entry
        self.wait_past(before, "the drag is undone")
        self.assertEqual(self.stiffness(), 400)

    def test_undo_of_random_edits_gives_the_first_scene_and_leaves_the_others_alone(self):
        self.start()
        first = content(self.other)
        tree = self.window.middle(self.window.widget("tree", "^objects$"))
        self.window.click(*ON_GROUND)
        field = self.window.middle(self.window.widget("spin button", "^stiffness$"))
        draw, theirs = random.Random(SEED), 0
        for number in range(EDITS):
            if number % 10 == 5:
                theirs += 1
                add = 'add { name: "theirs" mesh { sphere { radius_m: 0.01 } } }'
                move = 'set_pose { object { name: "theirs" } pose { position { x: %f } } }' % (0.01 * theirs)
                self.other.apply("operations { %s }" % (add if theirs == 1 else move))
            time.sleep(0.2)  # the list follows the scene ten times a second
            states = sorted(self.other.objects().values(), key=lambda state: state.id)  # as it is listed
            row = draw.choice([row for row, state in enumerate(states) if state.name != "theirs"])
            before = self.revision()
            self.window.click(*tree)
            self.window.do("key", "Home", *["Down"] * row)
            kind = draw.choice(["duplicate", "duplicate", "delete", "stiffness", "stiffness"])
            if kind == "stiffness":
                time.sleep(0.2)
                self.set_stiffness(field, draw.randrange(100, 2000))
            elif kind == "delete" and len(states) > 3:
                self.window.do("key", "Delete")
            else:
                self.window.do("key", "ctrl+d")
            self.wait_past(before, f"edit {number} is accepted")
        his = content(self.other)["theirs"]
        self.window.click(*ON_GROUND)
        for _ in range(2 * EDITS):  # a key is in vain while the edit before it is under way
            left = content(self.other)
            self.assertEqual(left.pop("theirs"), his)
            if left == first:
                return
            self.window.do("key", "ctrl+z")
            time.sleep(0.15)
        self.assertEqual(left, first)

    def test_a_conflict_is_said_and_nothing_is_overwritten(self):
        self.start()
        self.window.click(*ON_GROUND)
        before = self.revision()
        self.set_stiffness(self.window.middle(self.window.widget("spin button", "^stiffness$")), 700)
        self.wait_past(before, "the stiffness is set")
        self.assertEqual(self.stiffness(), 700)
        self.other.apply('operations { set_material { object { name: "ground" } material { stiffness_N_per_m: 555 } } }')
        self.window.click(*ON_GROUND)
        self.window.do("key", "ctrl+z")
        self.window.widget("label", "^undo: .*ground")
        self.assertEqual(self.stiffness(), 555)

    def test_an_idle_window_costs_next_to_nothing(self):
        server = self.start_server(scene=GROUND, options=["--hand", "none"])
        window = Window(server.address, self.start_display())
        self.addCleanup(window.kill)

        def used_s():
            fields = Path(f"/proc/{window.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
            return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        time.sleep(3)
        used, since = used_s(), time.monotonic()
        time.sleep(10)
        share = (used_s() - used) / (time.monotonic() - since)
        print(f"\nan idle window takes {100 * share:.1f} % of a core", end="", flush=True)
        self.assertLessEqual(share, MAX_IDLE)


if __name__ == "__main__":
    unittest.main()
