"""A viewer outlives the server and ends in step with the one that takes its place."""
import unittest

import harness


class ServerRestart(harness.EndToEnd):
    def test_viewer_survives_it_and_takes_over_the_new_state(self):
        display = self.start_display()
        first = self.start_server()
        before = first.ctl("apply", "-", text='operations { remove { object { name: "box" } } }').json()
        viewer = self.start_viewer(first.address, display)
        viewer.wait_for(before["revision"], before["root"])

        first.kill()
        second = self.start_server(listen=first.address)
        after = second.status()
        self.assertNotEqual(after["root"], before["root"])
        viewer.wait_for(after["revision"], after["root"])

        self.assertEqual(viewer.stop(), 0, viewer.text())
        summary = viewer.summary()
        self.assertEqual(summary["client_scene_hash"], after["root"])
        self.assertGreaterEqual(summary["state_resets"], 1)
        self.stop_and_check(second)


if __name__ == "__main__":
    unittest.main()
