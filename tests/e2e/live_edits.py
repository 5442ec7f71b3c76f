"""Edits from hapticctl to a running server: each is felt from a tick that the reply names, and the viewer follows."""
import concurrent.futures
import re
import unittest

import harness

BALL = """operations { add { name: "ball" mesh { sphere { radius_m: 0.03 segments: 8 } }
                                 pose { position { y: 0.1 z: 0.03 } } } }"""


class LiveEdits(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.server = self.start_server()
        self.viewer = self.start_viewer(self.server.address, self.start_display())
        start = self.server.status()
        self.viewer.wait_for(start["revision"], start["root"])
        self.revision, self.tick = start["revision"], 0

    def apply(self, text, *options):
        """Applies, checks the reply and that the viewer's own hash becomes the server's."""
        reply = self.server.ctl("apply", "-", *options, text=text).json()
        self.assertEqual(reply["revision"], self.revision + 1)
        self.assertGreater(reply["live_since_tick"], self.tick)
        self.revision, self.tick = reply["revision"], reply["live_since_tick"]
        self.viewer.wait_for(reply["revision"], reply["root"])
        status = self.server.status()
        self.assertEqual((status["revision"], status["root"]), (reply["revision"], reply["root"]))
        self.assertGreaterEqual(status["adopted_revision"], reply["revision"])
        return reply

    def object_under_stylus(self):
        """(name, sample) of an object that the hand is touching now."""
        names = {str(item["id"]): item["name"] for item in self.server.ctl("get").json()["object"]}

        def touched():
            samples = self.server.ctl("watch", "--rate", "100", "--seconds", "0.2")
            lines = [harness.json.loads(line) for line in samples.output.splitlines()]
            return next(((names[str(line["object"])], line) for line in reversed(lines) if line["object"]), None)
        return harness.wait_until(touched, harness.START_TIMEOUT_S, "the simulated hand touches something")

    def test_each_reply_names_revision_and_tick_and_the_viewer_follows(self):
        added = self.apply(BALL)
        self.assertEqual([item["name"] for item in added["object"]], ["ball"])
        self.assertTrue(any("768" in line for line in added["report"]), added["report"])  # 12 * 8^2 triangles

        name, _ = self.object_under_stylus()
        held = {item["name"]: item for item in self.server.ctl("get").json()["object"]}
        position = held[name]["pose"]["position"]
        self.apply(f'operations {{ set_pose {{ object {{ name: "{name}" }} pose {{ position {{ x: {position["x"]} '
                   f'y: {position["y"]} z: {position["z"] + 0.002} }} }} }} }}')

        name, _ = self.object_under_stylus()
        changed = self.apply(f'operations {{ set_material {{ object {{ name: "{name}" }} '
                             f'material {{ stiffness_N_per_m: 400 }} }} }}')
        self.assertEqual(changed["object"][0]["stiffness_N_per_m"], 400)

        self.apply('operations { remesh { object { name: "torus" } mesh { torus { major_radius_m: 0.042 '
                   'minor_radius_m: 0.018 major_segments: 48 minor_segments: 24 } } } }')
        self.apply('operations { remove { object { name: "ball" } } }')

        self.assertEqual(self.server.ctl("verify").code, 0)
        self.assertEqual(self.viewer.stop(), 0, self.viewer.text())
        viewer = self.viewer.summary()
        server = self.stop_and_check(self.server)
        self.assertEqual(viewer["client_scene_hash"], server["scene_hash"])
        self.assertEqual(viewer["resyncs"], 0)
        self.assertEqual(server["allocations_in_servo"], 0)

    def test_a_stiffness_beyond_what_the_device_bears_is_answered_with_what_is_felt(self):
        changed = self.apply('operations { set_material { object { name: "box" } '
                             'material { stiffness_N_per_m: 90000 } } }')
        self.assertEqual(changed["object"][0]["stiffness_N_per_m"], 90000)
        warnings = [re.search(r"warning: stiffness_N_per_m is felt as (\d+) instead of 90000", line)
                    for line in changed["report"]]
        self.assertIsNotNone(warnings[0], changed["report"])
        self.assertEqual(["one step of the device's encoder" in line for line in changed["report"][1:]], [True])
        self.assertLess(float(warnings[0][1]), 25e3)  # half of what the default device bears at 1 kHz
        self.assertGreater(float(warnings[0][1]), 10e3)

    def test_a_mesh_file_beside_the_scene_can_be_added(self):
        (self.folder / "tetrahedron.off").write_text(harness.TETRAHEDRON_OFF)
        added = self.apply('operations { add { name: "tetrahedron" mesh { file: "tetrahedron.off" } '
                           'pose { position { y: -0.1 } } } }')
        self.assertTrue(any("4" in line for line in added["report"]), added["report"])

    def test_a_mesh_of_the_clients_machine_is_sent_along(self):
        local = self.folder / "only here" / "tetrahedron.off"
        local.parent.mkdir()
        local.write_text(harness.TETRAHEDRON_OFF)
        reply = self.apply('operations { add { name: "sent" mesh { file: "mine" unit_m: 0.5 } } }',
                           "--upload", f"mine={local}")
        self.assertEqual([item["name"] for item in reply["object"]], ["sent"])
        unused = self.server.ctl("apply", "-", "--upload", f"other={local}", text=BALL)
        self.assertEqual(unused.code, 1)
        self.assertIn("other", unused.errors)

    def test_an_image_of_the_clients_machine_is_sent_along_for_a_layer(self):
        image = 'layer { field { mapped { image: "mine" mapping { shape: MAPPING_SHAPE_CUBE tile_m: 0.02 } } } }'
        layers = "layers { layer { field { grain { grain_m: 2e-3 } } } %s }" % image
        picture = harness.Path(__file__).resolve().parents[2] / "deploy/scenes/sprinkles.png"
        reply = self.apply('operations { set_material { object { name: "box" } material { texture { amplitude_m: 5e-4 '
                           'field { %s } } friction { mu_static: 1 dynamic_variation: 1 dynamic_field { %s } } } } }'
                           % (layers, layers), "--upload", f"mine={picture}")
        self.assertEqual(len(reply["object"][0]["texture"]["field"]["layers"]["layer"]), 2)

    def test_a_transaction_is_applied_as_a_whole_or_not_at_all(self):
        refused = self.server.ctl("apply", "-", text=BALL + 'operations { remove { object { name: "nobody" } } }')
        self.assertEqual(refused.code, 1)
        self.assertIn("operations[1]", refused.errors)
        self.assertEqual(self.server.status()["revision"], self.revision)

    def test_edits_of_many_clients_at_once_are_all_applied_in_one_order(self):
        texts = [f'operations {{ set_pose {{ object {{ name: "{name}" }} pose {{ position {{ x: {0.01 * i} }} }} }} }}'
                 for i in range(20) for name in ("torus", "box")]
        with concurrent.futures.ThreadPoolExecutor(4) as clients:
            replies = list(clients.map(lambda text: self.server.ctl("apply", "-", text=text).json(), texts))
        replies.sort(key=lambda reply: reply["revision"])
        self.assertEqual([reply["revision"] for reply in replies],
                         list(range(self.revision + 1, self.revision + 1 + len(texts))))
        ticks = [reply["live_since_tick"] for reply in replies]
        self.assertEqual(ticks, sorted(ticks))
        self.viewer.wait_for(replies[-1]["revision"], replies[-1]["root"])

    def test_what_get_prints_can_be_applied_again(self):
        shown = harness.subprocess.run([str(harness.BIN / "hapticctl"), "--connect", self.server.address, "get", "box"],
                                       capture_output=True, text=True, check=True).stdout
        self.apply(shown.replace('"box"', '"copy"'))


if __name__ == "__main__":
    unittest.main()
