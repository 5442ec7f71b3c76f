"""A soft sphere that the simulated hand dents, and a bar bent by a lattice: server and viewer have them in the same shape.
Clay keeps its dents, whoever is killed, and shows them to whoever comes late."""
import unittest

import harness

SCENE = """
operations { add { name: "sphere" mesh { sphere { radius_m: 0.05 segments: 30 } } pose { position { z: 0.05 } }
  deformation { softness { stiffness_N_per_m: 250 radius_m: 0.02 return_s: 0.2 } } } }
operations { add { name: "bar" mesh { box { size_m { x: 0.02 y: 0.02 z: 0.1 } segments: 8 } } pose { position { x: 0.2 z: 0.05 } }
  deformation { lattice { points_x: 2 points_y: 2 points_z: 2 control_m: [
    -0.01, -0.01, -0.05,  0.01, -0.01, -0.05,  -0.01, 0.01, -0.05,  0.01, 0.01, -0.05,
     0.01, -0.01,  0.05,  0.03, -0.01,  0.05,   0.01, 0.01,  0.05,  0.03, 0.01,  0.05] } } } }
"""
CLAY = """
operations { add { name: "clay" mesh { sphere { radius_m: 0.05 segments: 30 } } pose { position { z: 0.05 } }
  deformation { softness { stiffness_N_per_m: 250 radius_m: 0.015 plastic: 0.9 } } } }
"""
# Nothing below it can be reached from above: the hand lets the sphere go.
ROOF = """operations { add { name: "roof" mesh { box { size_m { x: 0.8 y: 0.8 z: 0.01 } } } pose { position { z: 0.25 } } } }"""


class SoftBodies(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.server = self.start_server(scene=SCENE)

    def samples(self, seconds):
        lines = self.server.ctl("watch", "--rate", "100", "--seconds", str(seconds)).output.splitlines()
        return [harness.json.loads(line) for line in lines if line.startswith("{")]

    def test_viewer_and_server_see_the_same_dents_and_the_same_shape_after_them(self):
        viewer = self.start_viewer(self.server.address, self.start_display())
        dented = harness.wait_until(lambda: [s for s in self.samples(1) if s.get("dent")], 90, "the hand dents the sphere")
        pressed = max(dented, key=lambda s: sum(float(x) ** 2 for d in s["dent"] for x in d["displacement"]))
        self.assertEqual(int(pressed["dent"][0]["object"]), 1)
        self.assertGreater(int(pressed["deformation_revision"]), 0)
        harness.time.sleep(5)
        self.server.ctl("apply", "-", text=ROOF).json()

        def quiet():
            heard = self.samples(0.5)
            return heard and not any(s.get("dent") or int(s.get("object", 0)) == 1 for s in heard)
        harness.wait_until(quiet, 60, "the sphere is let go and back in its shape")
        status = self.server.status()
        viewer.wait_for(status["revision"], status["root"])
        harness.time.sleep(1)  # the viewer's telemetry
        self.assertEqual(viewer.stop(), 0, viewer.text())
        ours, shown = self.stop_and_check(self.server), viewer.summary()
        self.assertEqual((ours["dents"], shown["client_dents"]), (0, 0))
        self.assertEqual(shown["client_deformed_hash"], ours["deformed_hash"])
        self.assertLess(shown["contact_error_mm"]["p99"], 1)
        self.assertEqual(ours["allocations_in_servo"], 0)


class PlasticBodies(harness.EndToEnd):
    def start(self):
        return self.start_server(scene=CLAY, options=["--state", self.folder / "state"])

    def residue(self, server):
        """Hash of the clay's moved vertices, None while there are none."""
        return server.ctl("get", "clay").json()["object"][0].get("deformation", {}).get("residue", {}).get("asset")

    def test_dents_that_stay_outlive_the_server_and_reach_late_clients(self):
        server = self.start()
        first = harness.wait_until(lambda: self.residue(server), 60, server.text)
        harness.wait_until(lambda: self.residue(server) != first, 60, "more dents")
        server.ctl("apply", "-", text=ROOF).json()  # nobody presses any more
        last = [self.residue(server)]

        def quiet():
            harness.time.sleep(2)
            last.append(self.residue(server))
            return last[-1] == last[-2]
        harness.wait_until(quiet, 90, "the hand has let go")
        verified = server.ctl("verify").json()
        self.assertEqual(verified["own_deformed_hash"], verified["server_deformed_hash"])
        self.assertEqual(int(server.status()["allocations_in_servo"]), 0)

        server.kill()
        again = self.start()
        self.assertEqual(self.residue(again), last[-1])
        late = again.ctl("verify").json()
        self.assertEqual(late["server_deformed_hash"], verified["server_deformed_hash"])
        self.assertEqual(late["own_deformed_hash"], late["server_deformed_hash"])
        again.ctl("apply", "-", text='operations { set_deformation { object { name: "clay" } deformation { residue {} } } }').json()
        self.assertIsNone(self.residue(again))
        self.assertNotEqual(again.ctl("verify").json()["server_deformed_hash"], late["server_deformed_hash"])
        self.stop_and_check(again)


if __name__ == "__main__":
    unittest.main()
