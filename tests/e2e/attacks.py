"""Each attack is refused with a reason, and the server is unharmed: it ticks, its scene stands, others go on editing."""
import contextlib
import math
import os
import resource
import socket
import ssl
import struct
import time
import unittest

import harness
from attacker import INSTRUMENTED, Attacks, move

HALF_OPEN = 10_000
FLOOD = 3000
FORGED = 2000


class OnASecuredServer(Attacks):
    secured = True

    def tls(self, credentials=None):
        return harness.tls_context((credentials or self.credentials) / "viewer.credentials")

    def token(self, role):
        return harness.token_of(self.credentials / f"{role}.credentials")

    def test_no_token(self):
        client = self.raw(self.tls())
        client.send_envelope(harness.hello_envelope("nobody"))
        refusal = self.refusal(client)
        self.assertEqual(refusal.field, "hello.token")
        self.assertIn("is missing", refusal.reason)

    def test_a_wrong_token(self):
        for token in (os.urandom(32), b"x", self.token("editor")[:-1], self.token("editor") + b"\0", b"y" * 500):
            client = self.raw(self.tls())
            client.send_envelope(harness.hello_envelope("somebody", token=token))
            refusal = self.refusal(client)
            self.assertEqual(refusal.field, "hello.token")
            self.assertIn("is not one that this server knows", refusal.reason)

    def test_another_servers_credentials(self):
        other = harness.make_credentials(self.folder / "other")
        with self.assertRaises(ssl.SSLCertVerificationError):
            self.raw(self.tls(other))
        answer = self.server.ctl("status", credentials=other / "editor.credentials")
        self.assertEqual(answer.code, 3)
        self.assertIn("not the one that the credentials are of", answer.errors)

    def test_a_viewer_that_edits_is_answered_and_stays_connected(self):
        viewer = self.connect(tls=self.tls(), token=self.token("viewer"))
        self.assertFalse(viewer.welcome.may_edit)
        for _ in range(3):
            self.assertEqual(viewer.edit(move()).rejected.field, "role")
        self.assertEqual(viewer.upload(b"x" * 100, bytes(32)).field, "role")
        viewer.say(lambda envelope: envelope.status_request.SetInParent())
        self.assertGreater(viewer.answer("status").status.ticks, 0)
        answer = self.server.ctl("apply", "-", text='operations { remove { object { name: "box" } } }',
                                 credentials=self.credentials / "viewer.credentials")
        self.assertEqual(answer.code, 1)
        self.assertIn("role", answer.errors)

    def test_a_downgrade_to_an_older_tls(self):
        old = self.tls()
        old.maximum_version = ssl.TLSVersion.TLSv1_2
        with self.assertRaises(ssl.SSLError) as refused:
            self.raw(old)
        self.assertIn("PROTOCOL_VERSION", str(refused.exception))

    def test_a_downgrade_to_no_tls(self):
        client = self.raw()
        client.send_envelope(harness.hello_envelope("plain", token=self.token("editor")))
        self.assertIn("TLS only", self.refusal(client).reason)
        self.assertIn("TLS only", harness.ctl(self.server.address, "status").errors)

    def test_garbage_in_place_of_tls_and_within_it(self):
        for first in (b"\x16\x03\x01\xff\xff" + os.urandom(2000), os.urandom(500), b"\x16\x03\x01\x00\x00" * 100):
            client = self.raw()
            client.send(first)
            client.close()
        client = self.raw(self.tls())
        client.send(os.urandom(5000))
        client.until_closed()

    def test_a_handshake_that_never_ends(self):
        client = self.raw()
        start = time.monotonic()
        client.socket.settimeout(0.1)
        with self.assertRaises(ConnectionError):
            for byte in b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(500):
                client.send(bytes([byte]))
                with contextlib.suppress(TimeoutError):
                    if not client.socket.recv(100):
                        raise ConnectionError
        self.assertLess(time.monotonic() - start, 20)

    def test_udp_is_not_offered_where_there_is_tls(self):
        viewer = self.connect(tls=self.tls(), token=self.token("viewer"))
        self.assertEqual(viewer.welcome.datagram_port, 0)

    def test_10000_half_open_connections(self):
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, HALF_OPEN + 2000), hard))
        self.addCleanup(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        other = self.connect(tls=self.tls(), token=self.token("editor"))  # before, and meanwhile
        memory_kB, descriptors, most = self.memory_kB(), self.descriptors(), 0
        opened = []
        try:
            for number in range(HALF_OPEN):
                attack = socket.create_connection(self.server.host_and_port(), timeout=harness.START_TIMEOUT_S)
                opened.append(attack)
                if number % 3 == 1:
                    attack.setblocking(False)
                    attack.send(b"\x16\x03\x01\x02\x00\x01")  # the beginning of a handshake
                if number % 500 == 0:
                    most = max(most, self.descriptors())
                    self.assertTrue(other.edit(move(x=number * 1e-6), seq=number + 1).HasField("accepted"))
                    self.edits += 1
            self.assertGreater(self.server.status()["ticks"], 0)  # a newcomer gets in while they stay open
            print(f"{len(opened)} half-open connections: at most {most - descriptors} more descriptors, "
                  f"{self.memory_kB() - memory_kB} kB more")
            self.assertLess(most - descriptors, 300)
            self.assertLess(self.memory_kB() - memory_kB, 32 << 10)
        finally:
            for attack in opened:
                attack.close()
        harness.wait_until(lambda: self.descriptors() <= descriptors + 1, 20, "the descriptors are free again")
        self.assertGreater(self.server.status()["refused_connections"], HALF_OPEN - 1000)


class OnAnOpenServer(Attacks):
    def test_a_path_out_of_the_asset_folder(self):
        outside = self.folder.parent / f"{self.folder.name}.off"
        outside.write_text(harness.TETRAHEDRON_OFF)
        self.addCleanup(outside.unlink)
        (self.folder / "link.off").symlink_to(outside)
        (self.folder / "folder").symlink_to(self.folder.parent)
        client = self.connect()
        for path in (f"../{outside.name}", str(outside), "/etc/passwd", f"./x/../../{outside.name}", "link.off",
                     f"folder/{outside.name}", "a.off\0.png", "..", ""):
            def fill(operation, path=path):
                operation.add.name = "stolen"
                operation.add.mesh.file = path
            with self.subTest(path):
                reply = client.edit(fill)
                self.assertIn("mesh", reply.rejected.field, reply)
                self.assertNotIn("root:", reply.rejected.reason)

    def test_oversized_frames(self):
        for size, join in ((1025, self.raw), ((1 << 20) + 1, self.connect), (0x7FFFFFFF, self.connect),
                           (0xFFFFFFFF, self.raw), (0, self.raw)):
            with self.subTest(size):
                memory_kB = self.memory_kB()
                client = join()
                client.send(struct.pack("<I", size) + b"x" * 100)
                self.assertEqual(self.refusal(client).field, "frame.length")
                self.assertLess(self.memory_kB() - memory_kB, 8 << 10, "nothing is allocated for a claim")

    def test_an_edit_whose_commit_fits_no_frame(self):
        """Moving 200 objects with lattices takes 9 kB to ask for and 1.3 MB to tell."""
        count, side, at_once = 200, 8, 40
        editor, watcher = self.connect(), self.connect()

        def request(envelope, seq, fill):
            envelope.edit_request.client_seq = seq
            fill(envelope.edit_request.transaction)

        def ask(seq, fill):
            editor.say(lambda envelope: request(envelope, seq, fill))
            return editor.answer("edit_reply").edit_reply

        def add(transaction, first):
            for number in range(first, first + at_once):
                made = transaction.operations.add().add
                made.name = f"o{number}"
                made.mesh.box.size_m.x = made.mesh.box.size_m.y = made.mesh.box.size_m.z = 0.02
                made.pose.position.x = 0.03 * number
                lattice = made.deformation.lattice
                lattice.points_x = lattice.points_y = lattice.points_z = side
                places = [0.02 * (i / (side - 1) - 0.5) for i in range(side)]
                for z in places:
                    for y in places:
                        for x in places:
                            lattice.control_m.extend((x, y, z))

        for seq, first in enumerate(range(0, count, at_once), start=1):
            self.assertTrue(ask(seq, lambda t, first=first: add(t, first)).HasField("accepted"))
        self.edits = count
        revision = self.server.status()["revision"]

        def move_all(transaction):
            for number in range(count):
                move(f"o{number}", 0.04 * number)(transaction.operations.add())
        reply = ask(100, move_all)
        self.assertEqual(reply.rejected.field, "operations")
        self.assertIn("change fewer", reply.rejected.reason)

        def conflict_with_all(transaction):
            for number in range(count):
                never = transaction.preconditions.add(expected_revision=999999)
                never.object.name = f"o{number}"
            move("box")(transaction.operations.add())
        reply = ask(101, conflict_with_all)
        self.assertGreater(len(reply.conflict.current), 100)
        self.assertLess(len(reply.conflict.current), count)
        self.assertEqual(self.server.status()["revision"], revision)
        watcher.say(lambda envelope: envelope.status_request.SetInParent())
        self.assertEqual(watcher.answer("status").status.revision, revision)

    def test_nested_frames(self):
        groups = b"\xf3\x07" * 100_000  # field 126 begins a group, 100,000 deep
        fields = b""
        for _ in range(2000):
            fields = b"\x52" + self.varint(len(fields)) + fields  # Hello in Hello in Hello ...
        for content in (groups, fields, b"\x0a" * (1 << 20)):
            client = self.connect()
            client.send(struct.pack("<I", len(content)) + content)
            self.assertIn(self.refusal(client).field, ("frame", "body", "protocol_version"))

    @staticmethod
    def varint(value):
        out = b""
        while value >= 128:
            out += bytes([value & 127 | 128])
            value >>= 7
        return out + bytes([value])

    def test_numbers_that_are_none(self):
        client = self.connect()
        for bad in (math.nan, math.inf, -math.inf):
            def pose(operation):
                operation.set_pose.object.name = "box"
                operation.set_pose.pose.position.y = bad

            def rotation(operation):
                operation.set_pose.object.name = "box"
                operation.set_pose.pose.rotation.w = bad

            def material(operation):
                operation.set_material.object.name = "box"
                operation.set_material.material.stiffness_N_per_m = bad

            def color(operation):
                operation.set_material.object.name = "box"
                operation.set_material.material.color.red = bad

            def shape(operation):
                operation.add.name = "new"
                operation.add.mesh.sphere.radius_m = bad

            def scale(operation):
                operation.remesh.object.name = "box"
                operation.remesh.mesh.file = "test.scene"
                operation.remesh.mesh.unit_m = bad
            for fill in (pose, rotation, material, color, shape, scale):
                with self.subTest(f"{fill.__name__} {bad}"):
                    self.assertIn("operations[0]", client.edit(fill).rejected.field)
        client.say(lambda envelope: setattr(envelope.subscribe, "rate_hz", math.nan))
        self.assertEqual(self.refusal(client).field, "subscribe.rate_hz")

    def test_a_hash_that_does_not_match(self):
        from haptics.v1 import envelope_pb2
        client = self.connect()
        reply = client.upload(b"not what the hash says", bytes(range(32)))
        self.assertFalse(reply.accepted)
        self.assertTrue(reply.field.startswith("chunk."), reply)
        reply = client.upload(b"x", b"short")
        self.assertEqual(reply.field, "chunk.hash")
        envelope = envelope_pb2.Envelope(protocol_version=1)
        envelope.edit_request.client_seq = 9
        move(x=0.1)(envelope.edit_request.transaction.operations.add())
        precondition = envelope.edit_request.transaction.preconditions.add()
        precondition.object.name = "box"
        precondition.expected_revision = self.before["revision"]
        precondition.expected_hash = bytes(32)
        client.send_envelope(envelope)
        self.assertTrue(client.answer("edit_reply").edit_reply.HasField("conflict"))

    def test_an_enum_and_an_operation_that_nobody_knows(self):
        from haptics.v1 import scene_pb2
        client = self.connect()
        for kind in (77, -1, 2):
            self.assertEqual(client.upload(b"x" * 10, bytes(32), kind=kind).field, "chunk.kind")
        unknown = scene_pb2.Operation.FromString(b"\xfa\x07\x01x")  # field 127
        self.assertIn("operations[0]", client.edit(lambda operation: operation.CopyFrom(unknown)).rejected.field)

    def test_a_message_that_is_the_servers(self):
        client = self.connect()
        client.say(lambda envelope: envelope.commit.SetInParent())
        self.assertEqual(self.refusal(client).field, "body")

    def test_an_older_protocol_version(self):
        for version in (0, 2):
            client = self.raw()
            client.send_envelope(harness.hello_envelope("old", version=version))
            refusal = self.refusal(client)
            self.assertEqual((refusal.field, refusal.supported_version), ("protocol_version", 1))

    def test_an_edit_flood(self):
        client, other = self.connect(), self.connect()
        for seq in range(1, FLOOD + 1):
            def request(envelope):
                envelope.edit_request.client_seq = seq
                move("torus", seq * 1e-5)(envelope.edit_request.transaction.operations.add())
            client.say(request)
        start = time.monotonic()
        self.assertTrue(other.edit(move("box", 0.01)).HasField("accepted"))
        waited_s = time.monotonic() - start
        outcomes = [client.answer("edit_reply").edit_reply for _ in range(FLOOD)]
        limited = [reply for reply in outcomes if reply.rejected.field == "rate"]
        self.edits += FLOOD
        print(f"{FLOOD} edits at once: {len(limited)} turned away, another client's edit took {waited_s:.2f} s")
        self.assertGreater(len(limited), FLOOD // 4)
        self.assertIn("later", limited[0].rejected.reason)
        self.assertLess(waited_s, 10)

    def test_forged_udp(self):
        from haptics.v1 import envelope_pb2
        victim = self.connect()
        host, _ = self.server.host_and_port()
        server = (host, victim.welcome.datagram_port)
        self.assertNotEqual(server[1], 0)
        attacker = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        attacker.bind(("127.0.0.66", 0))  # knows the cookie, but is elsewhere
        neighbour = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)  # on the victim's host
        neighbour.bind((host, 0))
        for forger in (attacker, neighbour):
            self.addCleanup(forger.close)
            forger.settimeout(0.5)
        true = envelope_pb2.Datagram(cookie=victim.welcome.datagram_cookie).SerializeToString()
        forged = [os.urandom(20), b"", b"\xff" * 9000, os.urandom(60_000),
                  envelope_pb2.Datagram(cookie=os.urandom(16)).SerializeToString(), true + os.urandom(1300)]
        sent = 0
        for _ in range(FORGED // len(forged)):
            for content in forged:
                neighbour.sendto(content, server)
                sent += 1
            attacker.sendto(true, server)
            sent += 1
            time.sleep(0.001)
        for forger in (attacker, neighbour):
            with self.assertRaises(TimeoutError, msg="a forger gets no answer"):
                forger.recv(2000)
        counted = self.server.status()["forged_datagrams"]
        print(f"{sent} forged datagrams, {counted} counted (the system drops what it cannot hold)")
        self.assertGreater(counted, sent // 10)
        self.assertLessEqual(counted, sent)
        neighbour.settimeout(harness.START_TIMEOUT_S)
        neighbour.sendto(true, server)
        self.assertEqual(neighbour.recv(2000), true, "the cookie opens the path")

    def test_telemetry_over_udp_is_what_a_client_gets_that_asks(self):
        answer = self.server.ctl("watch", "--udp", "--rate", "50", "--seconds", "3")
        self.assertEqual(answer.code, 0, answer.errors)
        self.assertIn("telemetry over UDP", answer.errors)
        ticks = [int(line.split('"tick":')[1].split(",")[0]) for line in answer.output.splitlines()]
        self.assertGreater(len(ticks), 50)
        self.assertEqual(ticks, sorted(set(ticks)))


if __name__ == "__main__":
    unittest.main()
