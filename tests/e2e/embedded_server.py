"""Server and viewer in one process: the same scene, the same hashes, no socket."""
import json
import unittest

import harness


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
        self.assertGreater(viewer["viewer_frames"], 10)
        self.assertEqual(server["allocations_in_servo"], 0)

    def test_a_scene_that_cannot_be_loaded_is_named(self):
        process = harness.Process([harness.BIN / "graphics_client", "--embedded-server", "--scene", "nowhere.scene",
                                   "--offscreen", "--seconds", "5"], env={"DISPLAY": self.start_display().name})
        self.addCleanup(process.kill)
        self.assertEqual(process.wait(), 1)
        self.assertIn("nowhere.scene", process.text())

    def test_it_has_no_address_to_connect_to(self):
        process = harness.Process([harness.BIN / "graphics_client", "--embedded-server", "--connect", "127.0.0.1:1"])
        self.addCleanup(process.kill)
        self.assertEqual(process.wait(), 2)


if __name__ == "__main__":
    unittest.main()
