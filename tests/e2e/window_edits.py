"""Edits by the viewer's window: a slider that is dragged is felt at once, undo gives the first scene again beside another
editor, who is never overwritten, and a window in which nothing happens costs next to nothing."""
import copy
import os
import random
import re
import statistics
import time
import unittest
from pathlib import Path

import harness
from haptic_client import Client
from haptics.v1 import scene_pb2
from led_hand import GROUND
from viewer_window import RESTING, MessageBus, ReadableWindow, Window

EDITS = int(os.environ.get("HAPTICS_EDITS", "8"))
# On a quiet machine 30 ms and 0.05; beside others the clock says less.
MAX_FELT_MS = float(os.environ.get("HAPTICS_MAX_FELT_MS", "100"))
MAX_IDLE = float(os.environ.get("HAPTICS_MAX_IDLE", "0.1"))
SEED = int(os.environ.get("HAPTICS_SEED", "1"))
ON_GROUND = (760, 400)
Z_HANDLES = (42, 84, 252)  # as the screen shows them
WHEEL_PIXELS = 60          # by which a click of the wheel scrolls the properties


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
    def start(self, options=RESTING, telemetry_hz=0):
        self.server = self.start_server(scene=GROUND, options=options)
        bus = MessageBus()
        self.addCleanup(bus.close)
        self.window = ReadableWindow(self.server.address, self.start_display(), bus)
        self.addCleanup(self.window.kill)
        self.other = Client(self.server.address, "second editor", telemetry_hz=telemetry_hz)
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
        self.start(options=[], telemetry_hz=500)  # beside a hand that is drawn
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

    def test_what_is_chosen_together_is_duplicated_and_deleted_by_one_edit(self):
        self.start()
        self.other.apply('operations { add { name: "ball" mesh { sphere { radius_m: 0.01 } } pose { position { z: 0.1 } } } }')
        tree = self.window.middle(self.window.widget("tree", "^objects$"))
        for key, left in (("ctrl+d", {"ground", "ball", "ground-2", "ball-2"}), ("ctrl+z", {"ground", "ball"}), ("Delete", set())):
            time.sleep(0.5)  # the list follows the scene ten times a second
            self.window.click(*tree)
            before = self.revision()
            self.window.do("key", "ctrl+a", "key", key)
            self.wait_past(before, f"{key} is accepted")
            harness.wait_until(lambda left=left: set(self.other.objects()) == left, 20, lambda: f"{key}: {set(self.other.objects())}")
            self.assertEqual(self.revision(), before + 1)

    def in_panel(self, role, name):
        """A widget of the properties, once they are scrolled to where it is seen."""
        def find():
            all_of_them = self.window.widgets()

            def its(role, name):
                return next((each for each in all_of_them if each["role"] == role and re.search(name, each["name"])), None)
            title, widget, answer = its("label", "^ground$"), its(role, name), its("filler", "^answer of the server$")
            if not (title and widget and answer):
                return None
            top, bottom = title["box"][1] + 30, answer["box"][1]
            _, y, _, height = widget["box"]
            if top < y and y + height < bottom:
                return widget
            away = top - y if y <= top else y + height - bottom
            self.window.do("mousemove", 14, top + 60, "click", "--repeat", 1 + away // WHEEL_PIXELS, 4 if y <= top else 5)
            return None
        return harness.wait_until(find, 20, f"{name} is not seen", pause_s=0.1)

    def effects(self):
        return self.other.objects()["ground"].effects

    def test_an_effect_is_added_set_by_its_slider_moved_by_its_handles_and_removed(self):
        self.start()
        self.window.click(*ON_GROUND)
        self.window.click(*self.window.middle(self.in_panel("push button", "^add effect$")))
        self.window.do("key", "Down", "Down", "Return")  # the second kind
        harness.wait_until(self.effects, 20, "no effect")
        self.assertEqual(self.effects()[0].kind, scene_pb2.EFFECT_KIND_SPRING_TO_POINT)

        first = self.effects()[0].stiffness_N_per_m
        slider = self.in_panel("slider", "^effect stiffness slider$")
        x, y, width, height = slider["box"]
        handle = x + round(width * slider["value"] / slider["max"]), y + height // 2
        self.window.drag(handle, (handle[0] + width // 4, handle[1]))
        harness.wait_until(lambda: self.effects()[0].stiffness_N_per_m > 2 * first, 20, "the slider sets nothing")
        self.assertEqual(self.stiffness(), 400, "of the surface")

        self.window.do("key", "g")
        tip = harness.wait_until(lambda: min(self.window.pixels(*Z_HANDLES), key=lambda pixel: pixel[1], default=None), 20,
                                 "no handles")
        place = self.effects()[0].point_m.z
        self.window.drag((tip[0], tip[1] + 6), (tip[0], tip[1] - 50))
        harness.wait_until(lambda: self.effects()[0].point_m.z > place + 0.005, 20, "the handles do not move it")
        self.assertEqual(self.other.objects()["ground"].pose.position.z, -0.02, "not the object")

        for what, undone in (("the handles", lambda: self.effects()[0].point_m.z == place),
                             ("the slider", lambda: self.effects()[0].stiffness_N_per_m == first)):
            self.window.do("key", "ctrl+z")
            harness.wait_until(undone, 20, f"one undo does not take back {what}")
        for _ in range(2):  # lets go of it, and chooses it; its rows come and go
            self.window.click(*self.window.middle(self.in_panel("list item", "spring to point")))
            time.sleep(0.5)
        self.window.do("key", "Delete")
        harness.wait_until(lambda: not self.effects(), 20, "it is not removed")
        self.assertIn("ground", self.other.objects())

    def test_the_wheel_over_a_texture_that_was_chosen_scrolls_past_it(self):
        self.start()
        self.window.click(*ON_GROUND)
        gallery = self.window.middle(self.in_panel("combo box", "^none$"))
        self.window.click(*gallery)
        self.window.do("key", "Right", "Return")
        harness.wait_until(lambda: self.other.objects()["ground"].HasField("texture"), 20, "no texture")
        chosen = self.other.objects()["ground"].texture
        self.window.do("mousemove", *gallery, "click", 5)
        harness.wait_until(lambda: self.window.middle(self.window.widget("combo box", "^waves$")) != gallery, 20, "it does not scroll")
        self.assertEqual(self.other.objects()["ground"].texture, chosen)

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
        server = self.start_server(scene=GROUND, options=RESTING)
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
