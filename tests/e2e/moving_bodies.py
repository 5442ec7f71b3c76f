"""Bodies on a table, pushed by the simulated hand: server, viewer and late clients have them in the same places."""
import unittest

import harness

TABLE = (harness.Path(__file__).resolve().parents[2] / "deploy/scenes/table.scene").read_text()
# Nothing below it can be reached from above: the hand lets the bodies come to rest.
ROOF = """operations { add { name: "roof" mesh { box { size_m { x: 0.6 y: 0.6 z: 0.01 } } }
                                 pose { position { z: 0.2 } } } }"""


class MovingBodies(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.server = self.start_server(scene=TABLE)
        self.started = {int(item["id"]): item for item in self.server.ctl("get").json()["object"]}
        self.moving = {number for number, item in self.started.items() if "motion" in item}

    def bodies(self):
        """As a client that joins now hears of them: {object: body}."""
        def heard():
            lines = self.server.ctl("watch", "--rate", "100", "--seconds", "0.3").output.splitlines()
            bodies = harness.json.loads(lines[-1]).get("body", []) if lines else []
            return {int(body["object"]): body for body in bodies}
        return harness.wait_until(lambda: (b := heard()) and b.keys() == self.moving and b, 20, "all bodies are told of")

    @staticmethod
    def place(pose):
        position = pose["position"]
        return [float(position.get(axis, 0)) for axis in "xyz"]

    def way(self, body):
        """How far a body has come from where the scene has it (m)."""
        was = self.place(self.started[int(body["object"])]["pose"])
        return sum((a - b) ** 2 for a, b in zip(self.place(body["pose"]), was)) ** 0.5

    def leave_at_rest(self):
        self.server.ctl("apply", "-", text=ROOF).json()

        def quiet():
            bodies = self.bodies().values()
            return all(body.get("condition") == "BODY_CONDITION_ASLEEP" for body in bodies) and list(bodies)
        return harness.wait_until(quiet, 60, lambda: f"all bodies rest: {self.bodies()}", pause_s=0.5)

    def test_the_hand_pushes_them_and_all_agree_where_they_come_to_rest(self):
        viewer = self.start_viewer(self.server.address, self.start_display())
        harness.wait_until(lambda: any(self.way(body) > 0.002 for body in self.bodies().values()), 90,
                           "the hand pushes a body", pause_s=0.5)
        late = self.leave_at_rest()
        status = self.server.status()
        viewer.wait_for(status["revision"], status["root"])
        harness.time.sleep(1)  # the viewer's telemetry
        self.assertEqual(viewer.stop(), 0, viewer.text())
        ours = self.stop_and_check(self.server)["bodies"]
        self.assertEqual(viewer.summary()["client_bodies"], ours)
        self.assertEqual({body["object"] for body in ours}, self.moving)
        self.assertEqual({body["condition"] for body in ours}, {"asleep"})
        for body, heard in zip(ours, sorted(late, key=lambda b: int(b["object"]))):
            self.assertEqual(body["position_m"], self.place(heard["pose"]))

    def test_setting_a_pose_also_to_the_same_puts_a_body_back(self):
        moved = harness.wait_until(lambda: next((b for b in self.bodies().values() if self.way(b) > 0.002), None), 90,
                                   "the hand pushes a body", pause_s=0.5)
        number = int(moved["object"])
        self.leave_at_rest()
        self.assertGreater(self.way(self.bodies()[number]), 1e-4, "the hand has pushed it back to where it was")
        x, y, z = self.place(self.started[number]["pose"])
        self.server.ctl("apply", "-", text=f'operations {{ set_pose {{ object {{ id: {number} }} pose {{ '
                        f'position {{ x: {x} y: {y} z: {z} }} }} }} }}').json()
        harness.wait_until(lambda: self.way(self.bodies()[number]) < 1e-4, 20,
                           lambda: f"it is back: {self.bodies()[number]}")


if __name__ == "__main__":
    unittest.main()
