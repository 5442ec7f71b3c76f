"""A session that haptic_relay publishes through a real NATS server: who watches holds what the server holds, whoever is
killed meanwhile, and whatever others say there."""
import json
import signal
import unittest

import harness
import nats_wire
from haptic_client import Client
from haptics.v1 import audience_pb2

# A body that falls and comes to rest, and a soft ball.
SCENE = harness.SCENE + """
operations { add { name: "ball" mesh { sphere { radius_m: 0.01 } } pose { position { x: 0.2 z: 0.03 } }
  motion { mass_kg: 0.1 planes { normal { z: 1 } friction: 0.5 rolling_m: 1e-3 } } } }
operations { add { name: "soft" mesh { sphere { radius_m: 0.05 segments: 30 } } pose { position { x: -0.3 z: 0.05 } }
  deformation { softness { stiffness_N_per_m: 250 radius_m: 0.02 return_s: 0.2 } } } }
"""
SESSION = "class"
STREAM = f"haptics-{SESSION}"
SOON_S = 60


class Relay(harness.Process):
    def __init__(self, server, nats, session=SESSION, credentials=None):
        secured = ["--nats-credentials", credentials] if credentials else []
        super().__init__([harness.BIN / "haptic_relay", "--connect", server.address, "--nats", nats.url, "--session", session,
                          *secured])


class Watcher(harness.Viewer):
    """Who has nothing but NATS: watch_session, or with a display graphics_client itself."""

    def __init__(self, folder, nats, display=None, credentials=None):
        self.summary_file = harness.Path(folder) / f"watcher-{id(self)}.json"
        if display:
            command = ["graphics_client", "--nats", nats.url, "--session", SESSION, "--offscreen", "--size", "320x256",
                       "--fps-limit", "20", "--summary", self.summary_file]
        else:
            command = ["watch_session", nats.url, SESSION, self.summary_file, *([credentials] if credentials else [])]
        harness.Process.__init__(self, [harness.BIN / command[0], *command[1:]],
                                 env={"DISPLAY": display.name, "LP_NUM_THREADS": "1", **harness.FOREIGN_CODE} if display else None)


class PublishedSession(harness.EndToEnd):
    """What the tests of an audience share."""

    def start_nats(self, **options):
        nats = nats_wire.NatsServer(self.folder, **options)
        self.addCleanup(nats.kill)
        return nats

    def start_relay(self, server, nats, **options):
        relay = Relay(server, nats, **options)
        self.addCleanup(relay.kill)
        return relay

    def start_watcher(self, nats, **options):
        watcher = Watcher(self.folder, nats, **options)
        self.addCleanup(watcher.kill)
        return watcher

    def client(self, server):
        client = Client(server.address, "editor", telemetry_hz=100)
        self.addCleanup(client.close)
        client.wait_live()
        return client

    @staticmethod
    def status(server):
        probe = harness.StatusProbe(server)
        status = probe.status()
        probe.close()
        return status

    @staticmethod
    def move(client, x):
        client.apply(f'operations {{ set_pose {{ object {{ name: "box" }} pose {{ position {{ x: {x} }} }} }} }}')


class Audience(PublishedSession):
    def commits(self, nats):
        """(epoch, revision) of all that the stream still has."""
        wire = nats_wire.NatsWire(nats.port)
        state = wire.state(STREAM)
        found = [wire.stored(STREAM, i) for i in range(state["first_seq"], state["last_seq"] + 1)]
        wire.close()
        read = [audience_pb2.PublishedCommit.FromString(data) for subject, data in found if subject.endswith("live.commit")]
        return [(message.epoch, message.commit.revision) for message in read]

    def assert_in_step(self, server, *watchers):
        status = self.status(server)
        for watcher in watchers:
            watcher.wait_for(status.revision, status.root.hex(), SOON_S)

    def test_who_comes_early_and_who_comes_late_hold_the_scene_with_its_bodies_and_dents(self):
        nats = self.start_nats()
        early = self.start_watcher(nats, display=self.start_display())  # before there is a session
        server = self.start_server(scene=SCENE)
        client = self.client(server)
        self.start_relay(server, nats)
        self.assert_in_step(server, early)
        for i in range(5):
            self.move(client, 0.06 + 0.001 * i)
        with client.hand() as hand:
            hand.move_to((-0.3, 0, 0.12))
            hand.press((-0.3, 0, 0.1), (0, 0, 1), 1.5, seconds=0.5)  # and on, until the block ends
            late = self.start_watcher(nats)
            self.assert_in_step(server, early, late)
            harness.time.sleep(1.5)  # the watchers' telemetry
            self.assertEqual(early.stop(), 0, early.text())
            self.assertEqual(late.stop(), 0, late.text())
        summaries = [early.summary(), late.summary()]
        bodies = self.stop_and_check(server)["bodies"]
        self.assertEqual(len(bodies), 1)
        for summary in summaries:
            self.assertEqual(summary["client_bodies"], bodies)
            self.assertEqual(summary["client_dents"], 1)
            self.assertEqual(summary["resyncs"], 0)
        self.assertEqual([revision for _, revision in self.commits(nats)], list(range(2, 7)))

    def test_no_commit_is_lost_or_doubled_whoever_is_killed(self):
        nats = self.start_nats()
        server = self.start_server(scene=harness.SCENE)
        client, relay = self.client(server), self.start_relay(server, nats)
        watcher = self.start_watcher(nats)
        self.assert_in_step(server, watcher)
        for kill in range(4):
            for i in range(15):
                self.move(client, 0.06 + 0.001 * i + 0.0001 * kill)
                if i == 7:
                    relay.kill()
                    relay = self.start_relay(server, nats)
        self.assert_in_step(server, watcher)
        commits = self.commits(nats)
        self.assertEqual([revision for _, revision in commits], list(range(2, 62)))
        self.assertEqual(len({epoch for epoch, _ in commits}), 1)

        nats.kill()  # and back
        self.move(client, 0.09)
        nats = self.start_nats(port=nats.port)
        self.assert_in_step(server, watcher)
        self.assertEqual([revision for _, revision in self.commits(nats)], list(range(2, 63)))

        client.close()
        address = server.address
        server.stop()
        server = self.start_server(scene=harness.SCENE, listen=address)  # another epoch
        self.move(self.client(server), 0.08)
        self.assert_in_step(server, watcher)
        self.assertEqual(watcher.stop(), 0, watcher.text())
        self.assertEqual(watcher.summary()["state_resets"], 1)
        self.assertTrue(relay.alive(), relay.text())
        self.assertEqual(relay.stop(), 0, relay.text())

    def test_what_needs_somebody_is_said_in_a_line(self):
        nats, server = self.start_nats(), self.start_server(scene=harness.SCENE)
        first = self.start_relay(server, nats)
        harness.wait_until(lambda: "connected to" in first.text(), SOON_S, first.text)
        second = self.start_relay(server, nats)
        self.assertEqual(second.wait(), 1)
        self.assertEqual(second.errors[-1], "haptic_relay: --session: another relay publishes under this name")
        self.assertTrue(first.alive())
        for name in ("two words", f"{SESSION}-assets"):
            self.assertEqual(Relay(server, nats, session=name).wait(), 2)
        first.stop()
        nats.stop()
        full = self.start_nats(store="1M")
        relay = self.start_relay(server, full, session="other")
        self.assertEqual(relay.wait(), 1)
        self.assertRegex(relay.errors[-1], r"^haptic_relay: JetStream stream haptics-other: is full, or JetStream has no room")
        full.stop()
        for options, reason in (({"config": "max_payload: 1024\n"}, "NATS: takes messages of 1024 bytes"),
                                ({"store": None}, "JetStream: is not on at this NATS server")):
            lacking = self.start_nats(**options)
            relay = self.start_relay(server, lacking)
            self.assertEqual(relay.wait(), 1)
            self.assertIn(reason, relay.errors[-1])
            lacking.stop()

    def test_forged_messages_change_nothing(self):
        nats = self.start_nats()
        server = self.start_server(scene=harness.SCENE)
        client = self.client(server)
        self.start_relay(server, nats)
        watcher = self.start_watcher(nats)
        self.assert_in_step(server, watcher)
        forger = nats_wire.NatsWire(nats.port)
        forged = audience_pb2.PublishedCommit(protocol_version=1, epoch=self.status(server).epoch)
        forged.commit.revision = 2
        forged.commit.root = forged.commit.prev_root = bytes(32)
        for subject in ("live.commit", "live.sample"):
            for payload in (b"", b"\xff" * 100, forged.SerializeToString()):
                forger.publish(f"haptics.{SESSION}.{subject}", payload)
        forger.flush()
        forger.close()
        self.move(client, 0.07)
        self.assert_in_step(server, watcher)
        self.assertEqual(watcher.stop(), 0, watcher.text())

    def test_a_flood_that_is_dear_to_read_leaves_the_memory_bounded(self):
        nats = self.start_nats()
        server = self.start_server(scene=harness.SCENE)
        client = self.client(server)
        self.start_relay(server, nats)
        watcher = self.start_watcher(nats)
        self.assert_in_step(server, watcher)
        held = audience_pb2.PublishedCommit(protocol_version=1, epoch=self.status(server).epoch)
        held.commit.revision = 1
        for _ in range(500_000):
            held.commit.put.add()
        payload, forger = held.SerializeToString(), nats_wire.NatsWire(nats.port)
        self.addCleanup(forger.close)
        most = 0
        for i in range(600):
            forger.publish(f"haptics.{SESSION}.live.commit", payload)
            if i % 10 == 0:
                forger.flush()
                most = max(most, self.resident_MB(watcher))
        self.assertLess(most, 400)
        self.move(client, 0.07)
        self.assert_in_step(server, watcher)
        self.assertEqual(watcher.stop(), 0, watcher.text())

    def test_a_stored_chunk_that_is_damaged_is_put_right(self):
        nats = self.start_nats()
        server = self.start_server(scene=harness.SCENE)
        relay = self.start_relay(server, nats)
        watcher = self.start_watcher(nats)
        self.assert_in_step(server, watcher)
        wire, stream = nats_wire.NatsWire(nats.port), f"{STREAM}-assets"
        self.addCleanup(wire.close)
        subject, right = wire.stored(stream, 1)

        def now():
            return wire.request(f"$JS.API.DIRECT.GET.{stream}.{subject}")[1]

        def damage():
            wire.request(subject, right[:-1])
            self.assertNotEqual(now(), right)
        damage()
        harness.wait_until(lambda: now() == right, SOON_S, "put right by the relay that runs")
        relay.stop()
        damage()
        self.start_relay(server, nats)
        harness.wait_until(lambda: now() == right, SOON_S, "put right by a new relay")

    def test_whatever_nats_does_a_signal_ends_relay_and_viewer_within_two_seconds(self):
        server = self.start_server(scene=harness.SCENE)
        client = self.client(server)
        silent = nats_wire.FakeNatsServer("nothing")
        self.addCleanup(silent.close)
        for one in (self.start_relay(server, silent), self.start_watcher(silent)):
            before = silent.connections
            harness.wait_until(lambda: silent.connections >= before + 2, SOON_S, "the attempt is given up, and another made")
            self.assert_ends_soon(one)
        nats = self.start_nats()
        relay, watcher = self.start_relay(server, nats), self.start_watcher(nats)
        self.assert_in_step(server, watcher)
        nats.process.send_signal(signal.SIGSTOP)
        self.addCleanup(nats.process.send_signal, signal.SIGCONT)
        for i in range(5):
            self.move(client, 0.07 + 0.001 * i)
        self.assert_ends_soon(relay)
        self.assert_ends_soon(watcher)

    def assert_ends_soon(self, process):
        begin = harness.time.monotonic()
        self.assertEqual(process.stop(), 0, process.text())
        self.assertLess(harness.time.monotonic() - begin, 2)

    def test_a_message_that_does_not_end_is_not_kept(self):
        flood = nats_wire.FakeNatsServer("floods")
        self.addCleanup(flood.close)
        relay = self.start_relay(self.start_server(scene=harness.SCENE), flood)
        most = 0
        while flood.connections < 2 and relay.alive():
            most = max(most, self.resident_MB(relay))
            harness.time.sleep(0.01)
        self.assertLess(most, 400)
        self.assertTrue(relay.alive(), relay.text())

    def test_a_password_is_for_the_servers_that_were_named(self):
        other = nats_wire.FakeNatsServer("nothing")
        named = nats_wire.FakeNatsServer("closes", connect_urls=[other.address])
        for each in (named, other):
            self.addCleanup(each.close)
        credentials = harness.Path(self.folder) / "relay.nats"
        credentials.write_text("user: relay\npassword: long-and-random\n")
        self.start_relay(self.start_server(scene=harness.SCENE), named, credentials=credentials)
        harness.wait_until(lambda: named.connections >= 2, SOON_S, "tried again")
        self.assertEqual(other.connections, 0, other.heard)

    @staticmethod
    def resident_MB(process):
        status = harness.Path(f"/proc/{process.process.pid}/status").read_text()
        found = harness.re.search(r"VmRSS:\s+(\d+)", status)
        return int(found[1]) / 1024 if found else 0

    def test_who_has_no_password_watches_and_publishes_nothing(self):
        """As deploy/nats.conf has it, over TLS."""
        server = self.start_server(scene=harness.SCENE)
        nats = nats_wire.SecuredNatsServer(self.folder)
        self.addCleanup(nats.kill)
        refused = self.start_relay(server, nats, credentials=nats.audience)
        self.assertEqual(refused.wait(), 1)
        self.assertRegex(refused.errors[-1], "refused: .*Permissions Violation")
        wrong = self.start_relay(server, nats, credentials=nats.credentials("relay", "guessed"))
        self.assertEqual(wrong.wait(), 1)
        self.assertIn("refused: ", wrong.errors[-1])
        self.start_relay(server, nats, credentials=nats.relay)
        watcher = self.start_watcher(nats, credentials=nats.audience)
        self.assert_in_step(server, watcher)
        for subject in (f"haptics.{SESSION}.live.commit", f"haptics.{SESSION}.live.sample", f"haptics.{SESSION}.latest",
                        f"haptics.{SESSION}.relay", f"$JS.API.STREAM.DELETE.{STREAM}", f"$JS.API.STREAM.PURGE.{STREAM}",
                        f"$JS.API.STREAM.UPDATE.{STREAM}", f"$JS.API.CONSUMER.CREATE.{STREAM}"):
            forger = nats_wire.NatsWire(nats.port, tls=nats.certificate)
            forger.publish(subject, b"{}")
            with self.assertRaisesRegex(nats_wire.Refused, "Permissions Violation for Publish", msg=subject):
                forger.flush()
            forger.close()
        self.assert_answers_go_only_to_who_asked(server, nats)
        for origin, answer in ((nats.PAGE, 101), ("https://evil.example", 403), ("https://localhost", 403)):
            self.assertEqual(nats.answer_to_page(origin), answer, origin)
        self.assert_in_step(server, watcher)
        self.assertEqual(watcher.stop(), 0, watcher.text())
        self.assertEqual(watcher.summary()["connections"], 1)

    def assert_answers_go_only_to_who_asked(self, server, nats):
        """JetStream sends what is stored wherever the asker says: nothing comes of it under a subject of the session."""
        def connect(*who):
            wire = nats_wire.NatsWire(nats.port, *who, tls=nats.certificate)
            self.addCleanup(wire.close)
            return wire
        owner = connect("relay", "long-and-random")
        before = owner.state(STREAM)["last_seq"]
        for subject in ("_INBOX.>", "haptics.>", f"haptics.{SESSION}.live.*", "_INBOX.*.*.*", ">"):
            with self.assertRaisesRegex(nats_wire.Refused, "Permissions Violation for Subscription", msg=subject):
                connect().subscribe(subject)
        listener, asker = connect(), connect()
        listener.subscribe(f"_R_.haptics.{SESSION}.live.*", 7)
        listener.subscribe("_INBOX.*.*", 8)
        listener.subscribe("_INBOX.*.>", 9)
        ask = f"$JS.API.DIRECT.GET.{STREAM}", json.dumps({"seq": before}).encode()
        for reply in (f"haptics.{SESSION}.latest", f"haptics.{SESSION}.live.sample", f"haptics.{SESSION}.live.commit"):
            asker.publish(*ask, reply)
        asker.flush()
        for reply in (f"_R_.haptics.{SESSION}.live.sample", "$JS.ACK.a"):
            stranger = connect()
            stranger.publish(*ask, reply)
            with self.assertRaisesRegex(nats_wire.Refused, "Permissions Violation for Publish with Reply"):
                stranger.flush()
        self.assert_in_step(server, self.start_watcher(nats, credentials=nats.audience))  # what it asks for
        listener.flush()
        self.assertEqual(owner.state(STREAM)["last_seq"], before)
        self.assertLessEqual({subject for subject, _, _ in listener.messages}, {f"_R_.haptics.{SESSION}.live.sample"})


if __name__ == "__main__":
    unittest.main()
