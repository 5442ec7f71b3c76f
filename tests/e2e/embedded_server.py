"""Server and viewer in one process: the same scene, the same hashes, no socket."""
import json
import time
import unittest

import harness

NEVER_CONNECTED = 3  # exit code
ENDS_WITHIN_S = 15  # of a run of 3 s; the scene takes longer


class EmbeddedServer(harness.EndToEnd):
    def test_the_viewer_mirrors_and_shows_the_server_inside(self):
        scene, viewer, server = (self.folder / name for name in ("inside.scene", "viewer.json", "server.json"))
        scene.write_text(harness.SCENE + 'operations { add { name: "mesh" mesh { file: "here.off" } '
                                         'pose { position { y: -0.1 } } } }')
        (self.folder / "here.off").write_text(harness.TETRAHEDRON_OFF)
        process = harness.Process(
            [harness.BIN / "graphics_client", "--embedded-server", "--scene", scene, "--server-summary", server,
             "--offscreen", "--size", "320x256", "--seconds", "6", "--summary", viewer],
            env={"DISPLAY": self.start_display().name, "LP_NUM_THREADS": "1", **harness.FOREIGN_CODE})
        self.addCleanup(process.kill)
        self.assertEqual(process.wait(), 0, process.text())
        self.assertTrue(process.find(r"^scene revision 1 root [0-9a-f]{64} equal$"), process.text())
        viewer, server = json.loads(viewer.read_text()), json.loads(server.read_text())
        self.assertEqual(viewer["client_scene_hash"], server["scene_hash"])
        self.assertTrue(viewer["hashes_equal"])
        self.assertGreater(server["ticks"], 1000)
        self.assertGreater(viewer["viewer_frames"], 1)
        self.assertEqual(server["allocations_in_servo"], 0)

    def test_the_viewer_draws_and_ends_in_time_while_the_server_inside_loads(self):
        scene, viewer = self.folder / "large.scene", self.folder / "viewer.json"
        scene.write_text('operations { add { name: "fine" mesh { sphere { radius_m: 0.05 segments: 900 } } } }')
        display = self.start_display()
        began_s = time.monotonic()
        process = harness.Process(
            [harness.BIN / "graphics_client", "--embedded-server", "--scene", scene, "--offscreen", "--size", "320x256",
             "--seconds", "3", "--summary", viewer],
            env={"DISPLAY": display.name, "LP_NUM_THREADS": "1", **harness.FOREIGN_CODE})
        self.addCleanup(process.kill)
        self.assertEqual(process.wait(), NEVER_CONNECTED, process.text())
        self.assertLess(time.monotonic() - began_s, ENDS_WITHIN_S)
        self.assertIn("the server in this process is still loading its scene", process.text())
        self.assertGreater(json.loads(viewer.read_text())["viewer_frames"], 1)

    def test_a_scene_that_cannot_be_loaded_is_named(self):
        process = harness.Process([harness.BIN / "graphics_client", "--embedded-server", "--scene", "nowhere.scene",
                                   "--offscreen", "--seconds", "5"], env={"DISPLAY": self.start_display().name})
        self.addCleanup(process.kill)
        self.assertEqual(process.wait(), 1)
        self.assertIn("nowhere.scene", process.text())

    def test_a_display_without_opengl_is_refused_with_a_reason(self):
        display = self.start_display(["-extension", "GLX"])
        for window in ([], ["--offscreen"]):
            with self.subTest(window=window):
                process = harness.Process([harness.BIN / "graphics_client", "--embedded-server", "--seconds", "5", *window],
                                          env={"DISPLAY": display.name})
                self.addCleanup(process.kill)
                self.assertEqual(process.wait(), 1, process.text())
                self.assertIn(f'DISPLAY: "{display.name}" has no OpenGL', process.text())

    def test_a_display_that_goes_away_ends_both_in_order(self):
        scene, server = self.folder / "inside.scene", self.folder / "server.json"
        scene.write_text(harness.SCENE)
        for window in ([], ["--offscreen"]):
            with self.subTest(window=window):
                server.unlink(missing_ok=True)
                display = self.start_display()
                process = harness.Process(
                    [harness.BIN / "graphics_client", "--embedded-server", "--scene", scene, "--server-summary", server,
                     *window], env={"DISPLAY": display.name, "LP_NUM_THREADS": "1", **harness.FOREIGN_CODE}, cwd=self.folder)
                self.addCleanup(process.kill)
                harness.wait_until(lambda: process.find(r"^scene revision 1 "), harness.START_TIMEOUT_S, process.text)
                time.sleep(1)  # it draws
                display.process.kill()
                self.assertEqual(process.wait(), 1, process.text())
                self.assertIn("DISPLAY: the X server has gone away", process.text())
                self.assertGreater(json.loads(server.read_text())["ticks"], 100)
                self.assertEqual([], list(self.folder.glob("*crash*")))

    def test_it_has_no_address_to_connect_to(self):
        process = harness.Process([harness.BIN / "graphics_client", "--embedded-server", "--connect", "127.0.0.1:1"])
        self.addCleanup(process.kill)
        self.assertEqual(process.wait(), 2)


if __name__ == "__main__":
    unittest.main()
