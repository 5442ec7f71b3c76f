"""Scenes as files: what viewer, `hapticctl get`, `haptic_eval advise` and Python write of a demo scene is opened by
haptic_server, SceneWorld, `hapticctl apply` and viewer, each with an empty scene: the root is the same in all of them, and,
but for advice, that of the demo scene. HAPTICS_LONG: of every demo scene; else of one, without advice, and only what the
viewer wrote is opened in it.
"""
import os
import re
import subprocess
import time
import unittest
from pathlib import Path

import haptic_assets
import haptics
import harness
from haptic_client import Client
from haptics.scene import Scene
from viewer_window import Window

SCENES = harness.PROJECT / "deploy" / "scenes"
SCANS = Path("/usr/share/inventor/data")
ASSETS = ["--assets", SCANS]
LONG = "HAPTICS_LONG" in os.environ
os.environ.setdefault("HAPTICS_PROGRAMS", str(harness.BIN))


def root_of(server):
    """With its revision."""
    scene = server.ctl("get").json()
    return scene["revision"], scene["root"]


class SceneRoundTrips(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.count = 0

    def server(self, scene=None):
        """With a scene file where it lies; None: with an empty scene, and no folder that it could read."""
        self.count += 1
        folder = self.folder / f"server{self.count}"
        folder.mkdir()
        server = harness.Server(folder, scene=scene, options=ASSETS if scene else [])
        self.addCleanup(server.kill)
        return server

    def answer_in_window(self, server, keys, title, file, said):
        """Of a viewer of this server: a dialog that the keys open is given a file."""
        window = Window(server.address, self.display, folder=self.folder)
        try:
            def is_asked():  # keys are lost that come before the window listens
                window.focus()
                window.do("key", keys)
                time.sleep(1)
                return window.windows(title)
            harness.wait_until(is_asked, harness.START_TIMEOUT_S, f"{keys} opens no dialog")
            window.type_into_dialog(title, str(file))
            window.said(said)
        finally:
            window.stop()

    # ---- what writes ----

    def by_get(self, server, scene, file):
        with file.open("wb") as out:
            subprocess.run([harness.BIN / "hapticctl", "--connect", server.address, "get"], stdout=out, check=True)

    def by_viewer(self, server, scene, file):
        self.answer_in_window(server, "ctrl+shift+s", "Save scene as", file, r"saved .*\.scene")

    def by_python(self, server, scene, file):
        Scene.load(scene).save(file)

    def by_advise(self, server, scene, file):
        advised = subprocess.run([harness.BIN / "haptic_eval", "advise", scene, *ASSETS, "--out", file.parent / "advice",
                                  "--apply", file.parent / "advised"], capture_output=True, text=True)
        written = file.parent / "advised" / scene.name
        self.assertTrue(written.exists(), advised.stdout + advised.stderr)
        return written

    # ---- what reads, and tells its root ----

    def in_server(self, file):
        server = self.server(file)
        root = root_of(server)[1]
        server.stop()
        return root

    def in_world(self, file):
        return haptics.SceneWorld(str(file), folders=[str(SCANS)]).root()

    def by_apply(self, file):
        server = self.server()
        answer = server.ctl("apply", file)
        self.assertEqual(answer.code, 0, answer.errors)
        root = root_of(server)[1]
        server.stop()
        return root

    def by_client(self, file):
        server = self.server()
        with Client(server.address) as client:
            client.apply(Scene.load(file))
            root = client.revision_and_root()[1]
        server.stop()
        return root

    def in_viewer(self, file):
        server = self.server()
        self.answer_in_window(server, "ctrl+o", "Open scene", file, r"opened .*\.scene")
        root = root_of(server)[1]
        server.stop()
        return root

    def round_trip(self, scene, writers):
        original = self.server(scene)
        first = root_of(original)
        for writer in writers:
            with self.subTest(scene=scene.stem, writer=writer.__name__):
                file = self.folder / scene.stem / writer.__name__ / "written.scene"
                file.parent.mkdir(parents=True)
                file = writer(original, scene, file) or file
                names_scans = "CyberHeads" in file.read_text()  # which lie in a folder of the server
                readers = [self.in_server, self.in_world] + ([] if names_scans else [self.by_apply])
                if not names_scans and (LONG or writer == self.by_viewer):
                    readers.append(self.in_viewer)
                if writer in (self.by_get, self.by_viewer):
                    readers.append(self.by_client)
                roots = {reader.__name__: reader(file) for reader in readers}
                self.assertEqual(len(set(roots.values())), 1, roots)
                # A hand that leaves a dent makes another revision.
                if writer != self.by_advise and root_of(original) == first and first[0] == 1:
                    self.assertEqual(set(roots.values()), {first[1]})
        original.stop()

    def test_what_is_written_opens_everywhere(self):
        self.display = self.start_display()
        writers = [self.by_get, self.by_viewer, self.by_python] + ([self.by_advise] if LONG else [])
        for scene in sorted(SCENES.glob("*.scene")) if LONG else [SCENES / "doughnut.scene"]:
            if SCANS.exists() or "CyberHeads" not in scene.read_text():
                self.round_trip(scene, writers)

    def test_every_kind_of_asset_lies_beside_it(self):
        server = self.server()
        ball = {"name": "ball"}
        with Client(server.address) as client:
            values = client.upload(haptic_assets.VERTEX_VALUES, haptic_assets.vertex_values([1.0] * 97 + [0.5]))
            points = client.upload(haptic_assets.POINT_FIELD, haptic_assets.point_field([(0.0, 0.0, 0.02, 1.0)], reach_m=0.01))
            moved = client.upload(haptic_assets.MOVED_VERTICES, haptic_assets.moved_vertices({0: (0.0, 0.0, 0.021)}))
            scene = Scene()
            scene.add(name="ball", mesh={"sphere": {"radius_m": 0.02, "segments": 4}}, pose={"position": {"z": 0.5}})
            scene.set_material(object=ball, material={
                "friction": {"mu_static": 0.5, "mu_dynamic": 0.3, "per_vertex": {"asset": values}},
                "stiffness_over": {"variation": 0.5, "field": {"grown": {"asset": points}}}})
            scene.set_deformation(object=ball, deformation={"residue": {"asset": moved}})
            client.apply(scene)
        folder = self.folder / "written"
        folder.mkdir()
        file = folder / "ball.scene"
        self.by_get(server, None, file)
        self.assertEqual({each.name for each in folder.iterdir()},
                         {"ball.scene", "ball.values", "ball.points", "ball.moved"})
        roots = {reader.__name__: reader(file) for reader in (self.in_server, self.in_world, self.by_apply, self.by_client)}
        self.assertEqual(set(roots.values()), {root_of(server)[1]}, roots)
        of_its_own = self.folder / "of_its_own"
        of_its_own.mkdir()
        other = harness.Server(of_its_own, scene=None, options=["--assets", folder])
        self.addCleanup(other.kill)
        self.assertEqual(other.ctl("apply", "-", text=file.read_text()).code, 0)
        self.assertEqual(root_of(other), root_of(server))

    def test_files_that_it_lacks_are_said_by_name_and_field(self):
        server = self.server()
        file = self.folder / "plate.scene"
        (self.folder / "bad.mesh").write_bytes(b"HMSH\2" + bytes(60))
        for name, said in {"none.mesh": "none.mesh", "../bad.mesh": "..", "bad.mesh": "bad.mesh: version: is"}.items():
            file.write_text(f'operations {{ add {{ name: "plate" mesh {{ file: "{name}" }} }} }}')
            field = re.escape("operations[0].add.mesh.file: ") + ".*" + re.escape(said)
            answer = server.ctl("apply", file)
            self.assertEqual(answer.code, 1)
            self.assertRegex(answer.errors, field)
            with self.assertRaisesRegex(ValueError, field):
                haptics.SceneWorld(str(file))
            with self.assertRaises(harness.NotStarted) as refusal:
                self.server(file)
            self.assertRegex(str(refusal.exception), field)


if __name__ == "__main__":
    unittest.main()
