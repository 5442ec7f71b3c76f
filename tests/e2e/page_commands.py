"""What the pages tell a reader to type is typed here, word for word and in order, in a folder that looks like a built clone,
while a server has the demo scene as deploy/run starts it. Commands are the lines that begin with "$ "; where a page shows
what one prints, that is compared ("..." stands for what varies).

usage: page_commands.py [-v]
"""
import contextlib
import re
import unittest

import harness
import pages

USUAL = "127.0.0.1:7654"
COMMAND_TIMEOUT_S = 900


class Page(harness.EndToEnd):
    def follow(self, path, device=None):
        """`device` is the name of a program that the page starts as a device: nothing holds up a real one."""
        page = (harness.PROJECT / path).read_text()
        commands = [found for block in pages.blocks(page) if block.startswith("$ ") for found in pages.commands_in(block)]
        self.assertTrue(commands, f"{path} has no commands")
        clone = self.folder / "clone"
        pages.lay_out_clone(clone)
        scene = (harness.PROJECT / "deploy/scenes/demo.scene").read_text()
        self.start_server(scene=scene, listen=USUAL,
                          options=["--assets", "/usr/share/inventor/data", "--recordings", clone])
        shell = pages.Shell(clone, {"DISPLAY": self.start_display().name, "LP_NUM_THREADS": "1", **harness.FOREIGN_CODE})
        self.addCleanup(shell.close)
        for command, shown in commands:
            with self.subTest(command):
                with harness.Cyclictest() if device else contextlib.nullcontext() as stall:
                    status, output = shell.run(command, COMMAND_TIMEOUT_S)
                if device:
                    shell.hurry(device)
                    if re.findall("^BAD +(a fault in)?", output, re.M) == ["a fault in"] and stall.late:
                        print(f"\n{command}: not judged, cyclictest woke up {stall.longest_us} us late", end="", flush=True)
                        continue
                self.assertEqual(status, 0, output)
                if shown:
                    self.assertTrue(pages.is_as_shown(output, shown), "\n".join(["shown:", *shown, "printed:", output]))


class PageCommandsInTime(Page):
    """What they print depends on whether the servo keeps up."""

    def test_clients(self):
        self.follow("graphics_client/README.md")


class DevicePageCommands(Page):
    """They fail where the device's replies, which the kernel carries at no real-time priority, are 3 ms late."""

    def test_device_plugin(self):
        self.follow("haptic_server/device/plugin/README.md", device="udp_arm")


class PageCommands(Page):
    def test_the_front_pages_tour(self):
        self.follow("README.md")

    @unittest.skipUnless((harness.BIN / "haptic_ros2").exists(), "built without Cyclone DDS")
    def test_ros2(self):
        self.follow("graphics_client/ros2/README.md")

    def test_openigtlink(self):
        self.follow("graphics_client/openigtlink/README.md")

    def test_analyse_a_session(self):
        self.follow("graphics_client/export/README.md")

    def test_experiments(self):
        self.follow("graphics_client/script/python/haptic_experiment/README.md")

    def test_server(self):
        self.follow("haptic_server/README.md")

    def test_surfaces(self):
        self.follow("haptic_server/engine/surface/README.md")

    def test_motion(self):
        self.follow("haptic_server/engine/motion/README.md")

    def test_world(self):
        self.follow("haptic_server/world/README.md")

    def test_evaluate_on_many_machines(self):
        self.follow("tests/eval/sweep/README.md")

    def test_step(self):
        self.follow("haptic_server/engine/step/README.md")


class Shown(unittest.TestCase):
    """The judgement itself."""

    def test_commands_are_taken_whole_with_what_they_print(self):
        self.assertEqual(pages.commands_in("$ a \\\n  b\n$ c <<'END'\n$ d\nEND\nout\n$ e\n"),
                         [("a \\\n  b", []), ("c <<'END'\n$ d\nEND", ["out"]), ("e", [])])

    def test_dots_stand_for_what_varies(self):
        for output, shown, same in [
                ("tick 5 of 7\n", ["tick ... of 7"], True), ("tick 5 of 8\n", ["tick ... of 7"], False),
                ("a\nb\nc\n", ["a", "...", "c"], True), ("a\nb\nx\nc\n", ["a", "...", "c"], True),
                ("a\nb\nd\n", ["a", "...", "c"], False), ("a\nb\n", ["a"], False), ("a\nb\n", ["a..."], False),
                ("x\ny\nc\n", ["...", "c"], True), ("a 1\nb 2\n", ["a ...", "..."], True)]:
            with self.subTest(output=output, shown=shown):
                self.assertEqual(pages.is_as_shown(output, shown), same)


if __name__ == "__main__":
    pages.enter_own_network()
    unittest.main()
