"""Advice on the scene, asked for in the viewer's window: said beside each object, until the object is another one."""
import os
import unittest

import harness
from haptic_client import Client
from viewer_window import MessageBus, ReadableWindow

SCENE = """operations { add { name: "ball" mesh { sphere { radius_m: 0.05 segments: 96 } } pose { position { z: 0.05 } } } }"""
ADVISED_WITHIN_S = 400
IN_LIST = (30, 74)


class AdviceInViewer(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.server = self.start_server(scene=SCENE)
        bus = MessageBus()
        self.addCleanup(bus.close)
        self.window = ReadableWindow(self.server.address, self.start_display(), bus, folder=self.folder)
        self.addCleanup(self.window.kill)
        self.window.focus()

    def advice(self):
        return [each["name"] for each in self.window.widgets() if each["role"] == "label" and each["showing"]
                and "feel the same" in each["name"]]

    def ask(self):
        self.window.do("key", "ctrl+shift+a")
        self.window.said("^.*advice: meshes of ball")

    def test_advice_that_is_under_way_is_cancelled(self):
        self.ask()
        self.window.do("key", "ctrl+alt+a")
        self.window.said("advice was cancelled")
        self.ask()
        self.window.do("key", "q")
        self.assertEqual(self.window.wait(), 0, self.window.text())

    @unittest.skipUnless("HAPTICS_LONG" in os.environ, "takes minutes")
    def test_advice_is_beside_the_object_until_it_is_another_one(self):
        self.ask()
        self.window.click(*IN_LIST)
        advice = harness.wait_until(self.advice, ADVISED_WITHIN_S, lambda: f"no advice:\n{self.window.text()}")
        print(f"\n{advice[0]}", end="", flush=True)
        self.assertRegex(advice[0], r"^110,592 triangles; [0-9,]+ feel the same\.")
        with Client(self.server.address, "editor") as editor:
            editor.wait_live()
            editor.apply('operations { set_material { object { name: "ball" } material { stiffness_N_per_m: 300 } } }')
            harness.wait_until(lambda: not self.advice(), 20, "the advice is not on this object any more")


if __name__ == "__main__":
    unittest.main()
