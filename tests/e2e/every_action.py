"""Every action of the viewer's menus does what it says, by its menu with the pointer and by its key; and none has no key."""
import contextlib
import re
import time
import unittest

import harness
from haptic_client import Client
from viewer_window import HEIGHT, WIDTH, MessageBus, ReadableWindow

SCENE = """operations { add { name: "box" mesh { box { size_m { x: 0.07 y: 0.07 z: 0.05 } segments: 12 } }
                              pose { position { z: 0.025 } }
                              deformation { softness { stiffness_N_per_m: 400 radius_m: 0.02 } } } }"""
PICTURE = (360, 30, 1262, 735)     # of the screen, between the panels: left, top, right, bottom
BOX = (790, 420)                   # where the box is seen
IN_LIST = (30, 74)                 # its line in the list
Z_HANDLES = (42, 84, 252)          # as the screen shows them
PLOTS = (360, 770, 1262, 915)
ON_BOX_M = (0.02, 0.01, 0.048)     # where the hand is held
TIMEOUT_S = 15


def differing_bytes(a, b):
    difference = (int.from_bytes(a, "little") ^ int.from_bytes(b, "little")).to_bytes(len(a), "little")
    return len(difference) - difference.count(0)


def plain(title):
    """Without what would be undone."""
    return re.sub("^(Undo|Redo) .*", r"\1", title)


class EveryAction(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.server = self.start_server(scene=SCENE)
        self.display = self.start_display()
        self.watcher = Client(self.server.address, "watcher", telemetry_hz=200)
        self.watcher.wait_live()
        self.addCleanup(self.watcher.close)
        bus = MessageBus()
        self.addCleanup(bus.close)
        self.window = ReadableWindow(self.server.address, self.display, bus, folder=self.folder)
        self.addCleanup(self.window.kill)
        self.window.focus()
        self.tried = set()

    # ---- what is done ----

    def by_key(self, menu, title, key):
        self.window.focus()
        self.window.do("key", key)

    def by_menu(self, menu, title, key):
        self.window.focus()
        x, y, _, height = self.menus["", menu[0]]
        self.window.click(x + 10, y + height // 2)
        for inner, name in enumerate([*menu[1:], title]):
            time.sleep(0.3)
            if inner:  # where it opens changes with the words before it
                self.window.click(*self.window.middle(self.seen_item(name)))
            else:
                _, down, _, line = self.menus[menu[0], name]
                self.window.click(x + 40, y + height + down + line // 2)

    def read_menus(self):
        """Boxes of all items by menu and title: on the screen those of the menu bar, in their menus the others."""
        items = [each for each in harness.wait_until(self.window.widgets, TIMEOUT_S, "no widgets")
                 if "menu item" in each["role"] and each["name"]]
        boxes, open_menus = {}, {}
        for item in items:
            title = plain(item["name"])
            boxes[open_menus.get(item["depth"] - 2, ""), title] = item["box"]
            open_menus[item["depth"]] = title
        return boxes

    def seen_item(self, name):
        def find():
            return next((each for each in self.window.widgets() if "menu item" in each["role"] and each["showing"] and
                         plain(each["name"]) == name), None)
        return harness.wait_until(find, TIMEOUT_S, f"no {name!r} in an open menu")

    # ---- what it changes ----

    def wait(self, condition, what):
        return harness.wait_until(condition, TIMEOUT_S, lambda: f"{what}:\n{self.window.text()}")

    @contextlib.contextmanager
    def opens(self, title):
        yield
        dialog = self.wait(lambda: self.window.windows(title), f"no dialog {title!r}")[0]
        self.window.do("windowfocus", "--sync", dialog, "key", "Escape")
        self.wait(lambda: not self.window.windows(title), f"{title!r} stays open")

    @contextlib.contextmanager
    def writes(self, pattern):
        before = len(list(self.folder.glob(pattern)))
        yield
        self.wait(lambda: len(list(self.folder.glob(pattern))) > before, f"no new {pattern}")

    @contextlib.contextmanager
    def changes(self, of, to=lambda before, after: before != after):
        before = of()
        yield
        self.wait(lambda: to(before, of()), f"{of} stays {before}")

    @contextlib.contextmanager
    def says(self, pattern):
        def times():
            return sum(bool(re.search(pattern, line)) for line in [*self.window.lines, *self.window.errors])
        before = times()
        yield
        self.wait(lambda: times() > before, f"does not say {pattern!r}")

    @contextlib.contextmanager
    def ends(self):
        yield
        self.assertEqual(self.window.wait(), 0, self.window.text())

    def picture(self):
        return self.window.part_of_screen(*PICTURE)

    @contextlib.contextmanager
    def redraws(self):
        """The picture, which stands still before."""
        self.window.move_to(1200, 760)
        before = self.picture()

        def stands_still():
            nonlocal before
            last, before = before, self.picture()
            return differing_bytes(last, before) < 20_000
        harness.wait_until(stands_still, TIMEOUT_S, "the picture does not stand still", pause_s=0.5)
        yield
        self.window.move_to(1200, 760)
        self.wait(lambda: differing_bytes(before, self.picture()) > 40_000, "the picture stays as it is")

    def names(self):
        return set(self.watcher.objects())

    def place(self):
        place = self.watcher.objects()["box"].pose.position
        return place.x, place.y, place.z

    def hint(self):
        return [each["name"] for each in self.window.widgets() if each["role"] == "label" and "touch" in each["name"]]

    def panels(self):
        """Bytes of the screen that have the colour of panels."""
        return self.window.part_of_screen(0, 0, WIDTH, HEIGHT).count(b"\xef\xef\xef")

    @contextlib.contextmanager
    def stops_the_plots(self):
        def runs():
            before = self.window.part_of_screen(*PLOTS)
            time.sleep(0.5)
            return self.window.part_of_screen(*PLOTS) != before
        self.wait(runs, "the plots stand still")
        yield
        self.wait(lambda: not runs(), "the plots go on")

    def force_N(self):
        """With which the pointer presses on the box."""
        self.window.move_to(*BOX)
        self.window.do("mousedown", 1)
        time.sleep(1.5)
        list(self.watcher.samples(0))
        force = next(self.watcher.samples()).force.written
        self.window.do("mouseup", 1)
        return (force.x ** 2 + force.y ** 2 + force.z ** 2) ** 0.5

    def shown(self, role, pattern=""):
        return next((each for each in self.window.widgets() if each["role"] == role and each["showing"] and
                     re.search(pattern, each["name"])), {})

    def plays(self):
        return self.shown("push button", "^(Play|Stop)$").get("name")

    def time(self):
        return self.shown("slider", "^time").get("value", 0)

    def speed(self):
        return self.shown("combo box", "x$").get("name")

    # ---- all of them ----

    def act(self, menu, title, key, effect):
        with self.subTest(action=title), effect:
            self.do(menu.split(" > "), title, key)
        self.tried.add((menu.split(" > ")[-1], title))

    def toggle(self, menu, title, key, effect):
        self.act(menu, title, key, effect)
        self.window.focus()
        self.window.do("key", key)

    def look(self):
        with self.watcher.hand() as hand:
            hand.move_to(ON_BOX_M)
            self.window.click(*IN_LIST)
            for title, key in [("Overlay", "o"), ("Follow the contact", "f"), ("Close-up", "c"), ("Wireframe", "w"),
                               ("Polygon edges", "e"), ("Displacement", "d"), ("Names", "n"), ("Details", "shift+o")]:
                self.toggle("View", title, key, self.redraws())
            self.toggle("Help", "Keys", "h", self.redraws())
            self.window.do("mousemove", *BOX, "click", "--repeat", 5, 5)  # the wheel: farther away
            for number, title in enumerate(["Front", "Right", "Back", "Left", "Top", "Three quarters"], 1):
                self.act("View > Look from", title, str(number), self.redraws())
            for number in range(1, 5):
                self.act("View > Kept views", f"Keep view {number}", f"shift+F{4 + number}", self.says(f"view {number} is kept"))
            self.window.do("key", "1")
            self.act("View > Kept views", "View 1", "F5", self.redraws())
            for number in range(2, 5):
                self.window.do("key", str(number))
                self.act("View > Kept views", f"View {number}", f"F{4 + number}", self.redraws())
            self.act("View", "Cut", "x", self.redraws())
            self.act("View", "Cut deeper", "shift+x", self.changes(self.picture))
            self.act("View", "Cut less deep", "ctrl+shift+x", self.changes(self.picture))
            self.window.do("key", "x")
            self.window.do("mousemove", *BOX, "click", "--repeat", 5, 5)
            self.act("View", "Show all", "r", self.redraws())
            self.toggle("View", "Dark panels", "ctrl+shift+d", self.changes(self.panels, lambda a, b: b < 0.5 * a))
            self.act("View", "Hide or show the object", "ctrl+h", self.redraws())
            self.act("View", "Show hidden objects", "ctrl+shift+h", self.redraws())
            for number, title in enumerate(["Objects", "Properties", "Plots"], 1):
                self.toggle("View", title, f"alt+{number}", self.changes(self.panels, lambda a, b: abs(b - a) > 0.03 * a))
            self.toggle("Plots", "Pause", "space", self.stops_the_plots())
            self.toggle("Edit", "Move and turn", "g", self.changes(lambda: bool(self.window.pixels(*Z_HANDLES))))

    def edit(self):
        for number, title in enumerate(["Sphere", "Box", "Cylinder", "Torus"], 1):
            self.act("Edit > Add", title, f"ctrl+{number}", self.changes(self.names, lambda a, b: len(b) == len(a) + 1))
        self.act("Edit", "Undo", "ctrl+z", self.changes(self.names, lambda a, b: len(b) == len(a) - 1))
        self.act("Edit", "Redo", "ctrl+y", self.changes(self.names, lambda a, b: len(b) == len(a) + 1))
        self.act("Edit", "Duplicate", "ctrl+d", self.changes(self.names, lambda a, b: len(b) == len(a) + 1))
        self.act("Edit", "Delete", "Delete", self.changes(self.names, lambda a, b: len(b) == len(a) - 1))
        self.window.click(*IN_LIST)
        self.window.do("key", "g")
        self.window.click(*BOX)
        for title, key in [("Left", "Left"), ("Right", "Right"), ("Up", "Up"), ("Down", "Down"), ("Away", "Prior"),
                           ("Nearer", "Next")]:
            self.act("Edit > Step", title, key, self.changes(self.place))
        self.window.do("key", "g")

    def touch(self):
        self.toggle("View", "Measure", "m", self.changes(self.hint))
        self.act("Hand", "On surfaces, or in space", "t", self.changes(self.hint))
        self.window.do("key", "t")
        self.act("Hand", "Press harder", "plus", self.changes(self.force_N, lambda a, b: b > 1.1 * a))
        self.act("Hand", "Press less", "minus", self.changes(self.force_N, lambda a, b: b < 0.95 * a))

    def keep(self):
        self.act("File", "Open scene...", "ctrl+o", self.opens("Open scene"))
        self.act("File", "Import mesh...", "ctrl+i", self.opens("Import mesh"))
        self.act("File", "Open recording...", "ctrl+shift+o", self.opens("Open recording"))
        self.act("File", "Save scene", "ctrl+s", self.opens("Save scene as"))
        self.act("File", "Save scene as...", "ctrl+shift+s", self.opens("Save scene as"))
        self.act("File", "Save picture as...", "ctrl+p", self.opens("Save picture as"))
        self.act("Help", "All keys", "F1", self.opens("Keys"))
        self.act("Help", "Guide", "shift+F1", self.opens("Guide"))
        self.act("Help", "About", "ctrl+F1", self.opens("About"))
        self.act("File", "Save picture", "s", self.writes("haptic_view_*.png"))
        self.toggle("File", "Film the window", "ctrl+shift+f", self.writes("haptic_film_*.webm.part"))
        self.act("File", "Save plots", "ctrl+l", self.writes("haptic_plots.pdf"))
        self.act("Session", "Save the last 10 seconds", "ctrl+r", self.writes("recordings/*.haptics"))

    def replay(self):
        self.window.focus()
        self.window.do("key", "ctrl+shift+o")
        self.window.type_into_dialog("Open recording", str(next((self.folder / "recordings").glob("*.haptics"))))
        self.window.said(r"replay of .*every force is the same")
        self.act("File", "Save video...", "ctrl+shift+v", self.opens("Save video"))
        self.act("Session > Replay", "Play or stop", "space", self.changes(self.plays))
        self.window.do("key", "space")
        self.act("Session > Replay", "One sample forward", "period", self.changes(self.time, lambda a, b: b > a))
        self.act("Session > Replay", "One sample back", "comma", self.changes(self.time, lambda a, b: b < a))
        self.act("Session > Replay", "Slower", "bracketleft", self.changes(self.speed))
        self.act("Session > Replay", "Faster", "bracketright", self.changes(self.speed))
        self.act("Session > Replay", "Back to the server", "ctrl+b", self.says("back to the server"))

    def leave(self):
        self.window.do("key", "ctrl+s")
        self.window.type_into_dialog("Save scene as", str(self.folder / "kept.scene"))
        self.wait((self.folder / "kept.scene").exists, "the scene is not saved")
        self.act("Session", "Connect...", "ctrl+k", self.opens("Connect"))
        self.act("Session", "Disconnect", "ctrl+shift+k", self.changes(lambda: self.server.status()["clients"]))
        self.act("File", "Quit", "q", self.ends())

    def try_all(self, do):
        self.do = do
        self.menus = self.read_menus()
        self.look()
        self.edit()
        self.touch()
        self.keep()
        self.replay()
        self.leave()
        menus = {menu for menu, _ in self.menus}
        actions = {(menu, title) for menu, title in self.menus if title not in menus or menu == "View"}
        elsewhere = {("File", "Cancel import"), ("Hand", "Let go"),  # edit_with_mouse.py, touch_with_mouse.py
                     ("Edit", "Ask for advice"), ("Edit", "Cancel advice")}  # advice_in_viewer.py
        self.assertEqual(actions - self.tried, elsewhere)

    def test_by_key(self):
        self.try_all(self.by_key)

    def test_by_menu(self):
        self.try_all(self.by_menu)


if __name__ == "__main__":
    unittest.main()
