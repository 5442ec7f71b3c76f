"""A session in ROS 2: haptic_ros2 beside another maker's DDS (ros2_peer, by Fast DDS), as nodes would use it.

HAPTICS_SECONDS: how long every tick is read (4). usage: ros2.py [-v]
"""
import itertools
import json
import os
import shlex
import signal
import subprocess
import time
import unittest

import harness
from haptic_client import Client

SECONDS = float(os.environ.get("HAPTICS_SECONDS", "4"))
EVERY_TICK = ("/pose", "/ihip", "/twist", "/wrench", "/contact", "/joy")
LATEST_DISCOVERY_MS = 2000


def before_other_work():
    """A prefix for what reads or writes every tick: a reader that other programs hold up for seconds loses some, as it may."""
    ahead = ["chrt", "--rr", "1"]
    return ahead if subprocess.run([*ahead, "true"], capture_output=True).returncode == 0 else []


class Ticks(harness.EndToEnd):
    @staticmethod
    def reports(lines):
        """What ros2_peer says: {topic: its report}, and the messages."""
        said = [json.loads(line) for line in lines]
        return {line["topic"]: line for line in said if "topic" in line}, [line for line in said if "topic" not in line]

    def check_every_tick(self, reports, namespace="/haptics", ticks=EVERY_TICK):
        for topic in (namespace + name for name in ticks):
            with self.subTest(topic):
                report = reports[topic]
                self.assertGreater(report["count"], 0)
                self.assertEqual((report["lost"], report["out_of_order"], report["differing"]), (0, 0, 0))


class BadNetwork(Ticks):
    LOST = 0.05

    def test_a_network_that_loses_packets_loses_no_message(self):
        if os.geteuid() != 0:
            self.fail("network namespaces need root: run the tests as root, or leave this one out with ctest -LE root")
        (self.folder / "test.scene").write_text(harness.SCENE)
        programs = [["haptic_server", "--listen", "127.0.0.1:7654", "--scene", self.folder / "test.scene", "--recordings", self.folder],
                    ["haptic_ros2", "--interface", "haptics"], ["ros2_peer", "read", 0, "/haptics", SECONDS]]
        server, bridge, peer = (shlex.join(map(str, [*before_other_work(), harness.BIN / program[0], *program[1:]]))
                                for program in programs)
        run = harness.Process([harness.BIN / "haptic_stress", "programs", "--loss-pct", 100 * self.LOST, "--server-side", server,
                               "--server-side", bridge, "--client-side", f"env ROS_LOCALHOST_ONLY=0 {peer}", "--out", self.folder],
                              prefix=before_other_work())
        self.addCleanup(run.kill)
        self.assertEqual(run.wait(SECONDS + harness.STOP_TIMEOUT_S), 0, run.text())
        network = json.loads((self.folder / "programs.json").read_text())
        self.assertGreater(network["packets_lost"], self.LOST / 2 * network["packets"])
        reports, _ = self.reports((self.folder / "client_side.log").read_text().splitlines())
        self.check_every_tick(reports)


class Ros2(Ticks):
    domain = 40  # of the tests, one after another: what one has left does not reach the next

    def setUp(self):
        super().setUp()
        Ros2.domain += 1
        self.server = self.start_server()

    def start_bridge(self, *options):
        bridge = harness.Process([harness.BIN / "haptic_ros2", "--connect", self.server.address, "--domain", self.domain, *options],
                                 prefix=before_other_work())
        self.addCleanup(bridge.kill)
        harness.wait_until(lambda: "connected to" in bridge.text(), harness.START_TIMEOUT_S, bridge.text)
        return bridge

    def peer(self, *arguments):
        peer = harness.Process([harness.BIN / "ros2_peer", arguments[0], self.domain, *arguments[1:]],
                               prefix=before_other_work())
        self.addCleanup(peer.kill)
        return peer

    def read(self, seconds, *words, namespace="/haptics"):
        peer = self.peer("read", namespace, seconds, *words)
        self.assertEqual(peer.wait(seconds + harness.STOP_TIMEOUT_S), 0, peer.text()[-1000:])
        return self.reports(peer.lines)

    def test_every_tick_arrives_in_order_as_another_dds_writes_it(self):
        bridge = self.start_bridge()
        with Client(self.server.address, every_tick=True) as client:
            reports, said = self.read(SECONDS)
            hips = {(s.hip.x, s.hip.y, s.hip.z): s.time_ns for s in client.samples(0)}
        self.check_every_tick(reports)
        self.assertLess(max(report["matched_ms"] for report in reports.values()), LATEST_DISCOVERY_MS, reports)
        for report in reports.values():
            self.assertEqual(report["differing"], 0, report)
        self.assertNotIn("lost", bridge.text())

        poses = [line for line in said if line.get("pose_of") == "/haptics/pose"]
        self.assertEqual(poses[0]["frame"], "world")
        felt = [pose for pose in poses if tuple(pose["at"]) in hips]
        self.assertGreater(len(felt), 0.5 * min(len(poses), len(hips)), "the poses are those of the server's ticks")
        stamps = [pose["stamp_ns"] for pose in poses]
        self.assertTrue(all(a < b for a, b in zip(stamps, stamps[1:])))
        # The velocity is that of the poses: together with the time it leads from each to the next.
        twists = {line["stamp_ns"]: line["linear"] for line in said if line.get("twist_of")}
        pairs = [(a, b) for a, b in zip(poses, poses[1:]) if a["stamp_ns"] in twists]
        self.assertGreater(len(pairs), 0.5 * len(poses))
        for axis in range(3):
            way = sum(twists[a["stamp_ns"]][axis] * 1e-9 * (b["stamp_ns"] - a["stamp_ns"]) for a, b in pairs)
            self.assertAlmostEqual(way, sum(b["at"][axis] - a["at"][axis] for a, b in pairs), delta=0.005)

    def test_who_reads_ticks_as_sensor_data_is_served_too(self):
        self.start_bridge()
        time.sleep(2)
        reports, _ = self.read(2, "best_effort")
        for topic in EVERY_TICK:
            self.assertGreater(reports["/haptics" + topic]["count"], 500)
            self.assertLess(reports["/haptics" + topic]["first"], 500, "what nobody reads is not written")

    def test_the_scene_is_there_for_who_comes_late(self):
        self.start_bridge()
        _, said = self.read(3)
        markers = {line["object"]: line for line in said if "marker_of" in line and line["action"] == 0}
        self.assertEqual({name: marker["frame"] for name, marker in markers.items()},
                         {"torus": "haptics/torus", "box": "haptics/box"})
        self.assertEqual(markers["box"]["points"], 3 * 12 * 4 * 4)
        still = {line["frame"]: line["at"] for line in said if line.get("frame_of") == "/tf_static"}
        self.assertEqual(still, {"haptics/torus": [-0.06, 0, 0.018], "haptics/box": [0.06, 0, 0.025]})
        self.assertLessEqual({"haptics/hip", "haptics/ihip"}, {line["frame"] for line in said if line.get("frame_of") == "/tf"})

    def test_crtks_names_and_a_namespace(self):
        self.start_bridge("--crtk", "--namespace", "/lab/left")
        reports, _ = self.read(3, "crtk", namespace="/lab/left")
        self.check_every_tick(reports, "/lab/left", ("/measured_cp", "/measured_cv", "/measured_cf"))

    def test_poses_from_ros_move_an_object(self):
        self.start_bridge()
        for rate_hz in (50, 10_000):
            with self.subTest(rate_hz=rate_hz):
                mover = self.peer("move", "/haptics", "haptics/box", rate_hz, 2, "circle")
                with Client(self.server.address, telemetry_hz=100) as client:
                    places = []
                    for _ in itertools.takewhile(lambda _: mover.alive(), client.samples()):
                        box = client.bodies().get("box")
                        if box:
                            places.append((box.pose.position.x, box.pose.position.y))
                self.assertEqual(mover.wait(), 0, mover.text())
                radii = [(x * x + y * y) ** 0.5 for x, y in places[len(places) // 2:]]
                self.assertTrue(radii and all(abs(radius - 0.05) < 0.002 for radius in radii), places[-5:])
                self.assertGreater(max(y for _, y in places) - min(y for _, y in places), 0.03)
        self.assertEqual(self.server.status()["fault"], "FAULT_NONE")

    def test_a_wrench_from_ros_is_added_to_the_hands_force(self):
        bridge = self.start_bridge("--crtk")
        for rate_hz in (50, 10_000):
            with self.subTest(rate_hz=rate_hz), Client(self.server.address, telemetry_hz=100) as client:
                adder = self.peer("add", "/haptics/servo_cf", 0.5, 0, -0.25, rate_hz, 2)
                felt = [(s.force.added.x, s.force.added.y, s.force.added.z)
                        for s in itertools.takewhile(lambda _: adder.alive(), client.samples())]
                self.assertEqual(adder.wait(), 0, adder.text())
                self.assertIn((0.5, 0, -0.25), felt)
                self.assertEqual(list(client.samples(1))[-1].force.added.x, 0)
        for wrench, word in ((("nan", 0, 0), "force_N"), ((0, 0, 101), "force_N"), ((1, 0, 0), 'its frame has to be "world"')):
            with self.subTest(wrench=wrench):
                frame = ["base"] if "frame" in word else []
                self.assertEqual(self.peer("add", "/haptics/servo_cf", *wrench, 1000, 1.5, *frame).wait(), 0)
                harness.wait_until(lambda word=word: word in bridge.text(), 5, bridge.text)
        self.assertLess(len(bridge.text().splitlines()), 20, "a flood is not a flood of words")
        self.assertTrue(bridge.alive(), bridge.text())

    def call(self, scene, caller=7, times=1):
        """Replies to the edit, in order."""
        peer = self.peer("call", "/haptics/edit", caller, scene, times)
        self.assertEqual(peer.wait(40), 0, peer.text())
        return [json.loads(line) for line in peer.lines]

    def test_a_service_edits_the_scene(self):
        bridge = self.start_bridge()
        with Client(self.server.address) as client:
            client.wait_live()
            ball = 'operations { add { name: "ball" mesh { sphere { radius_m: 0.02 } } pose { position { z: 0.2 } } } }'
            [reply] = self.call(ball)
            self.assertEqual((reply["caller"], reply["number"], reply["success"], reply["differing"]), (7, 1, True, 0), reply)
            harness.wait_until(lambda: client.revision_and_root()[0] >= reply["revision"], 5, "the edit is in no revision")
            self.assertEqual(client.revision_and_root()[0], reply["revision"])
            self.assertIn("ball", client.objects())
            self.assertGreater(reply["tick"], 0)
            for scene, words in ((ball, "ball"), ("operations { ad", "scene"),
                                 ('operations { remove { object { name: "nobody" } } }', "nobody")):
                with self.subTest(scene=scene[:60]):
                    [reply] = self.call(scene)
                    self.assertFalse(reply["success"])
                    self.assertIn(words, reply["message"])
            stiffer = 'operations { set_material { object { name: "ball" } material { stiffness_N_per_m: 300 } } }'
            replies = self.call(stiffer, caller=2**63, times=50)
            self.assertEqual([(r["caller"], r["number"], r["success"]) for r in replies], [(2**63, n, True) for n in range(1, 51)])
        self.server.stop()
        harness.wait_until(lambda: len(bridge.errors) > 2, 10, bridge.text)
        [reply] = self.call(stiffer)
        self.assertEqual((reply["success"], reply["revision"]), (False, 0), reply)
        self.assertEqual(bridge.stop(), 0, bridge.text())

    def test_what_is_no_pose_is_refused_and_said(self):
        bridge = self.start_bridge()
        for thing, motion, word in (("haptics/box", "nan", "finite numbers"), ("box", "zero_rotation", "a rotation other than 0"),
                                    ("haptics/box", "frame", 'its frame has to be "world"'), ("nobody", "circle", "no such object")):
            with self.subTest(motion=motion, thing=thing):
                self.assertEqual(self.peer("move", "/haptics", thing, 1000, 1.5, motion).wait(), 0)
                harness.wait_until(lambda word=word: word in bridge.text(), 5, bridge.text)
        self.assertLess(len(bridge.text().splitlines()), 30, "a flood is not a flood of words")
        with Client(self.server.address, telemetry_hz=100) as client:
            next(client.samples())
            self.assertNotIn("box", client.bodies())

    def test_other_types_under_its_topics_disturb_nobody(self):
        bridge = self.start_bridge()
        disturber = self.peer("disturb", "/haptics", 3)
        reports, _ = self.read(3)
        self.assertEqual(disturber.wait(), 0)
        self.check_every_tick(reports)
        self.assertTrue(bridge.alive(), bridge.text())

    def test_a_reader_that_stands_still_holds_up_nobody(self):
        bridge = self.start_bridge()
        held = self.peer("read", "/haptics", 15)
        harness.wait_until(lambda: "pose_of" in held.text(), 10, "no pose")
        held.send(signal.SIGSTOP)
        reports, _ = self.read(6)  # longer than ticks are kept
        self.check_every_tick(reports)
        held.send(signal.SIGCONT)
        time.sleep(2)
        reports, said = self.read(3)
        self.check_every_tick(reports)
        self.assertEqual(held.wait(), 0)
        for topic in ("pose_of", "twist_of", "wrench_of"):
            stamps = {(line[topic], line["stamp_ns"]) for line in said if topic in line}
            again = {(line[topic], line["stamp_ns"]) for line in map(json.loads, held.lines) if topic in line}
            self.assertEqual(len(stamps - again), 0, "the one that stood still is not served again as the other is")
        self.assertNotIn("lost", bridge.text())

    def test_it_goes_on_with_a_server_that_comes_back_and_ends_when_told(self):
        bridge = self.start_bridge()
        address = self.server.address
        self.server.stop()
        harness.wait_until(lambda: len(bridge.errors) > 2, 10, bridge.text)
        self.server = self.start_server(listen=address)
        reports, _ = self.read(3)
        self.check_every_tick(reports)
        self.assertEqual(bridge.stop(), 0, bridge.text())

    def test_what_cannot_be_is_named(self):
        for options, env, word in ((["--namespace", "haptics"], {}, "--namespace"), (["--namespace", "/a b"], {}, "--namespace"),
                                   (["--interface", "nowhere0"], {}, "--interface"), (["--domain", "233"], {}, "--domain"),
                                   (["--interface", '"/><'], {}, "--interface"), ([], {"ROS_DOMAIN_ID": "x"}, "ROS_DOMAIN_ID")):
            with self.subTest(options=options, env=env):
                done = subprocess.run([harness.BIN / "haptic_ros2", "--connect", self.server.address, *options], text=True,
                                      env={**os.environ, **env}, capture_output=True, timeout=harness.STOP_TIMEOUT_S)
                self.assertIn(done.returncode, (1, 2), done.stderr)
                self.assertIn(word, done.stderr)


if __name__ == "__main__":
    unittest.main()
