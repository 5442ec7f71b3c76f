"""Server and viewer on two hosts: two network namespaces, joined by a cable, made and removed here. Needs root.

The addresses are of TEST-NET-1 (RFC 5737), which no network uses.
"""
import os
import subprocess
import time
import unittest

import harness

SERVER_HOST, CLIENT_HOST = "192.0.2.1", "192.0.2.2"


def ip(*arguments):
    done = subprocess.run(["ip", *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(f"ip {' '.join(arguments)}: {done.stderr.strip()}")


class TwoHosts(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        if os.geteuid() != 0:
            self.fail("network namespaces need root: run the tests as root, or leave this one out with ctest -LE root")
        self.spaces = [f"haptics-{side}-{os.getpid()}" for side in ("server", "client")]
        cable = [f"hs{os.getpid() % 10**8}", f"hc{os.getpid() % 10**8}"]
        for space in self.spaces:
            ip("netns", "add", space)
            self.addCleanup(ip, "netns", "del", space)
        ip("link", "add", cable[0], "netns", self.spaces[0], "type", "veth", "peer", "name", cable[1], "netns",
           self.spaces[1])
        for space, end, host in zip(self.spaces, cable, (SERVER_HOST, CLIENT_HOST)):
            ip("-n", space, "address", "add", f"{host}/30", "dev", end)
            ip("-n", space, "link", "set", end, "up")
            ip("-n", space, "link", "set", "lo", "up")

    def on(self, side):
        return ["ip", "netns", "exec", self.spaces[side]]

    def test_the_viewer_sees_over_the_cable_what_the_server_feels(self):
        server = self.start_server(listen=f"{SERVER_HOST}:0", options=["--allow-insecure-lan"], prefix=self.on(0))
        viewer = self.start_viewer(server.address, self.start_display(), prefix=self.on(1))
        from_there = self.on(1)
        start = server.ctl("status", prefix=from_there).json()
        viewer.wait_for(start["revision"], start["root"])

        reply = server.ctl("apply", "-", text='operations { set_pose { object { name: "torus" } '
                           'pose { position { x: -0.07 z: 0.018 } } } }', prefix=from_there).json()
        self.assertGreater(reply["live_since_tick"], 0)
        viewer.wait_for(reply["revision"], reply["root"])
        self.assertEqual(server.ctl("verify", prefix=from_there).code, 0)
        time.sleep(1)  # telemetry to measure

        self.assertEqual(viewer.stop(), 0, viewer.text())
        held, felt = viewer.summary(), self.stop_and_check(server)
        self.assertEqual(held["client_scene_hash"], felt["scene_hash"])
        self.assertTrue(held["hashes_equal"])
        self.assertGreater(held["viewer_frames"], 0)
        self.assertGreater(held["telemetry_age_ms"]["p99"], 0)

    def test_another_host_is_not_served_unless_it_was_allowed(self):
        with self.assertRaises(harness.NotStarted) as refusal:
            self.start_server(listen=f"{SERVER_HOST}:0", prefix=self.on(0))
        self.assertIn("--allow-insecure-lan", str(refusal.exception))


if __name__ == "__main__":
    unittest.main()
