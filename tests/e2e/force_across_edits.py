"""Edits under the stylus of a running server do not kick: every tick is recorded, and the ticks that adopted an edit are
compared with all others.

The simulated hand strokes for ever, so the ticks without an edit show what the trajectory itself does to the force. The
same trajectory with and without an edit, from one state, is compared in tests/haptic_server/servo.
"""
import math
import subprocess
import time
import unittest

import harness

FADE_TICKS = 300  # after an adoption while which a fade, and a hand that has lost its surface, are still its doing
MARGIN_N = 0.05
MOVE_TICKS = 80  # 2 mm at 30 mm/s take 67 ms


def read_recording(file):
    """What was felt in each tick; the replay must come to the recorded forces."""
    import haptic_recording
    felt = file.with_suffix(".felt")
    subprocess.run([harness.BIN / "haptic_eval", "replay", file, "--telemetry", felt, "--out", file.parent], check=True)
    return list(haptic_recording.telemetry(felt))


def difference(a, b):
    return math.dist((a.x, a.y, a.z), (b.x, b.y, b.z))


class ForceAcrossEdits(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.recording = self.folder / "ticks"
        self.server = self.start_server(options=["--record", self.recording])

    def touched(self, name):
        """Waits until the hand strokes the object."""
        objects = {item["name"]: str(item["id"]) for item in self.server.ctl("get").json()["object"]}

        def pressed():
            lines = self.server.ctl("watch", "--rate", "100", "--seconds", "0.1").output.splitlines()
            last = harness.json.loads(lines[-1]) if lines else {}
            return str(last.get("object", 0)) == objects[name] and last.get("penetration_m", 0) > 0.001
        harness.wait_until(pressed, harness.START_TIMEOUT_S, f"the hand touches the {name}")

    def apply(self, text):
        reply = self.server.ctl("apply", "-", text=text).json()
        time.sleep(0.4)
        return reply["live_since_tick"]

    def test_the_force_has_no_step_where_an_edit_was_adopted(self):
        adopted = []
        for stiffness in (1600, 400, 800):
            self.touched("torus")
            adopted.append(self.apply('operations { set_material { object { name: "torus" } material { '
                                      f'stiffness_N_per_m: {stiffness} }} }} }}'))
        for segments in (96, 160, 128):
            self.touched("torus")
            adopted.append(self.apply('operations { remesh { object { name: "torus" } mesh { torus { major_radius_m: 0.042 '
                                      f'minor_radius_m: 0.018 major_segments: {segments} minor_segments: 64 }} }} }} }}'))
        self.touched("torus")
        adopted.append(self.apply('operations { add { name: "ball" mesh { sphere { radius_m: 0.01 } } '
                                  'pose { position { y: 0.3 } } } }'))
        self.touched("torus")
        moved = self.apply('operations { set_pose { object { name: "torus" } pose { position { x: -0.06 z: 0.020 } } } }')
        self.touched("torus")
        adopted.append(self.apply('operations { remove { object { name: "torus" } } }'))
        self.stop_and_check(self.server)

        samples = read_recording(self.recording)
        index = {sample.tick: i for i, sample in enumerate(samples)}
        near = {tick + i for tick in [*adopted, moved] for i in range(FADE_TICKS)}
        # A tick after missed ones may differ by as far as the hand went meanwhile; it says nothing of an edit.
        contact = {b.tick: difference(b.force.contact, a.force.contact)
                   for a, b in zip(samples, samples[1:]) if b.tick == a.tick + 1}
        own = max(step for tick, step in contact.items() if tick not in near)
        judged = [tick for tick in [*adopted, moved] if tick in contact]
        self.assertGreater(len(judged), len(adopted) // 2, "the server missed the ticks of most of the edits")
        for tick in judged:
            print(f"tick {tick}: contact force steps by {contact[tick]:.3f} N; without an edit by up to {own:.3f} N")
            self.assertLessEqual(contact[tick], 1.1 * own + MARGIN_N)
        for tick in [*adopted, moved]:
            self.assertEqual(samples[index[tick]].adoption_tick, tick)
        at = index[moved]
        step = max(contact.get(tick, 0) for tick in range(moved, moved + MOVE_TICKS))
        print(f"tick {moved}: the surface moves 2 mm through the stylus: contact force steps by up to {step:.3f} N")
        self.assertLessEqual(step, 1.1 * own + MARGIN_N)
        self.assertGreater(samples[at].penetration_m, 0.0005, "the move must be one that matters")


if __name__ == "__main__":
    unittest.main()
