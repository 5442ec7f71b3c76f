"""The Python client and its examples: the same promises as the C++ client's, with hashes computed independently."""
import contextlib
import csv
import math
import re
import signal
import socket
import sys
import threading
import time
import unittest

import harness
import haptic_assets
import haptic_scene
from haptic_client import Client, Conflict, Refused, Rejected
from haptics.v1 import scene_pb2

EXAMPLES = harness.Path(__file__).resolve().parents[2] / "graphics_client/script/python/examples"
BALL = 'operations { add { name: "ball" mesh { sphere { radius_m: 0.01 segments: 4 } } pose { position { z: 0.2 } } } }'


def increment(client, name):
    """Read, add 1 N/m, write if nobody else did in between, else read again. The number of tries."""
    tries = 0
    while True:
        tries += 1
        known = client.objects()[name]
        try:
            client.submit(f'preconditions {{ object {{ id: {known.id} }} expected_revision: {known.revision} }} operations {{ '
                          f'set_material {{ object {{ id: {known.id} }} material {{ '
                          f'stiffness_N_per_m: {known.stiffness_N_per_m + 1} }} }} }}').result(30)
            return tries
        except Conflict:
            time.sleep(0.001)  # until the commit that came between is here


class DeafRelay:
    """Forwards to the server; while `deaf`, what the server answers is lost. cut() ends all connections."""

    def __init__(self, server):
        self.server, self.deaf, self.pairs = server.host_and_port(), False, []
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self.listener.getsockname()[1]}"
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            try:
                client = self.listener.accept()[0]
            except OSError:
                return
            pair = client, socket.create_connection(self.server)
            self.pairs.append(pair)
            threading.Thread(target=self.pump, args=(*pair, False), daemon=True).start()
            threading.Thread(target=self.pump, args=(*reversed(pair), True), daemon=True).start()

    def pump(self, source, target, answers):
        try:
            while data := source.recv(1 << 16):
                if not (answers and self.deaf):
                    target.sendall(data)
        except OSError:
            pass

    def cut(self):
        pairs, self.pairs = self.pairs, []
        for pair in pairs:
            for end in pair:
                with contextlib.suppress(OSError):
                    end.shutdown(socket.SHUT_RDWR)
                end.close()

    def close(self):
        self.listener.close()
        self.cut()


class PythonClient(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.server = self.start_server()

    def client(self, address=None, **options):
        client = Client(address or self.server.address, **options)
        self.addCleanup(client.close)
        client.wait_live(30)
        return client

    def example(self, name, *arguments):
        process = harness.Process([sys.executable, EXAMPLES / f"{name}.py", "--connect", self.server.address, *arguments])
        self.addCleanup(process.kill)
        return process

    def assert_in_step(self, client):
        status = self.server.status()
        held = status["revision"], status["root"]
        harness.wait_until(lambda: client.revision_and_root() == held, 30, lambda: f"{client.revision_and_root()} {held}")
        self.assertEqual(client.resyncs, 0)

    def test_it_computes_the_servers_root_at_every_revision(self):
        client = self.client()
        self.assert_in_step(client)
        client.apply(BALL)
        client.apply('operations { set_pose { object { name: "ball" } pose { position { x: -0.0 y: 1e-300 } '
                     'rotation { w: 0.6 z: 0.8 } } } } operations { remove { object { name: "box" } } }')
        client.apply('operations { set_material { object { name: "ball" } material { color { red: 0.1 } } } }')
        self.assert_in_step(client)
        self.assertEqual(set(client.objects()), {"torus", "ball"})

    def test_it_hashes_surface_properties_as_the_server_does(self):
        client = self.client()
        client.apply(BALL)
        wave = "fourier { terms { direction { x: 1 } wavelength_m: 2e-3 } terms { amplitude: -0.5 direction { z: 1 } " \
               "wavelength_m: 3e-3 phase_rad: 1 } }"
        scalars = " ".join(f"{name}: 0.25" for name in haptic_scene.SCALARS)
        for properties in (f"shading {{ crease_rad: 0.5 }} {scalars}", "friction { mu_static: 0.6 mu_dynamic: 0.3 }",
                           f"texture {{ amplitude_m: 5e-4 gain_K: 1 literal: true field {{ {wave} }} }}",
                           "texture { amplitude_m: 5e-4 field { noise { wavelength_m: 2e-3 octaves: 3 } } }",
                           "texture { amplitude_m: 5e-4 law: TEXTURE_LAW_BUMP field { cellular { cell_m: 2e-3 } } }",
                           f"texture {{ amplitude_m: 5e-4 field {{ layers {{ layer {{ field {{ {wave} }} }} layer {{ weight: -2 "
                           "field { mapped { spot_noise { cells: 3 resolution: 32 } mapping { shape: MAPPING_SHAPE_PLANE "
                           "tile_m: 0.01 } } } } } } }",
                           "texture { amplitude_m: 5e-4 field { layers { combination: LAYER_COMBINATION_PRODUCT layer { field { "
                           "grain { grain_m: 1e-3 } } } layer { field { cellular { cell_m: 2e-3 } } } } } }",
                           "texture { amplitude_m: 5e-4 field { grown { reaction_diffusion { wavelength_m: 4e-3 } } } }",
                           "friction { mu_static: 1 dynamic_variation: 0.3 dynamic_field { noise { wavelength_m: 2e-3 } } }",
                           "friction { mu_static: 1 variation: 0.3 field { grain { grain_m: 1e-3 seed: 9 } } dynamic_field { "
                           "grain { grain_m: 2e-3 } } }",
                           "friction { mu_static: 1 variation: 0.3 field { grain { grain_m: 1e-3 seed: 9 } } }",
                           f"stiffness_over {{ variation: 0.3 field {{ {wave} }} }} softness_over {{ variation: 1 field {{ noise "
                           "{ wavelength_m: 2e-3 } } }",
                           "softness_over { variation: -0.5 field { grain { grain_m: 1e-3 } } } stiffness_over {}",
                           "shading {} texture {}"):
            with self.subTest(properties=properties):
                client.apply('operations { set_material { object { name: "ball" } material { %s } } }' % properties)
                self.assert_in_step(client)
        ball = client.objects()["ball"]
        self.assertEqual(ball.friction.field.grain.seed, 9)
        self.assertFalse(ball.HasField("texture") or ball.HasField("shading"))

    def test_it_hashes_deformations_as_the_server_does(self):
        client = self.client()
        client.apply(BALL)
        corners = " ".join(f"control_m: {x}" for x in range(24))
        for given in ("softness { stiffness_N_per_m: 200 radius_m: 0.01 }",
                      "softness { stiffness_N_per_m: 0.1 radius_m: 0.015 degree: 5 return_s: 0.3 }",
                      "softness { stiffness_N_per_m: 0.1 radius_m: 0.015 plastic: 0.6 }",
                      f"lattice {{ points_x: 2 points_y: 2 points_z: 2 {corners} }}", "softness {}", "lattice {}"):
            with self.subTest(given=given):
                client.apply('operations { set_deformation { object { name: "ball" } deformation { %s } } }' % given)
                self.assert_in_step(client)
        self.assertFalse(client.objects()["ball"].HasField("deformation"))

    def test_it_hashes_effects_as_the_server_does(self):
        client = self.client()
        client.apply(BALL)
        every = harness.effects_of_every_kind()
        self.assertEqual(len(every), len(scene_pb2.EffectKind.keys()) - 1)
        for given in (*every, " ".join(every), ""):
            with self.subTest(given=given):
                client.apply('operations { set_effects { object { name: "ball" } %s } }' % given)
                self.assert_in_step(client)
        self.assertFalse(client.objects()["ball"].effects)

    def test_it_gives_an_object_a_residue_of_its_own_and_takes_it_away(self):
        client = self.client()
        client.apply(BALL)
        dent = client.upload(haptic_assets.MOVED_VERTICES,
                             haptic_assets.moved_vertices({5: (0.001, 0, 0.009), 2: (0, -0.0, 0.008)}))
        edit = scene_pb2.Transaction()
        change = edit.operations.add().set_deformation
        change.object.name = "ball"
        change.deformation.residue.asset = dent
        client.apply(edit)
        self.assert_in_step(client)
        self.assertEqual(client.objects()["ball"].deformation.residue.asset, dent)
        verified = self.server.ctl("verify").json()
        self.assertEqual(verified["own_deformed_hash"], verified["server_deformed_hash"])
        client.apply('operations { remesh { object { name: "ball" } mesh { sphere { radius_m: 0.02 segments: 3 } } } }')
        self.assert_in_step(client)
        self.assertFalse(client.objects()["ball"].HasField("deformation"), "it was of the old mesh")
        beyond = client.upload(haptic_assets.MOVED_VERTICES, haptic_assets.moved_vertices({4000: (0, 0, 0)}))
        change.deformation.residue.asset = beyond
        with self.assertRaises(Rejected) as rejected:
            client.apply(edit)
        self.assertEqual(rejected.exception.field, "operations[0].set_deformation.deformation.residue")
        self.assertIn("vertex 4000", str(rejected.exception))

    def test_it_hashes_motions_as_the_server_does(self):
        client = self.client()
        client.apply(BALL)
        for motion in ("mass_kg: 0.3", "mass_kg: 0.1 gravity_m_per_s2 {} linear_damping_per_s: 0.5 angular_damping_per_s: 2",
                       "mass_kg: 1 inertia { centre_m { x: 0.01 } moments { x: 1e-3 y: 2e-3 z: 2.5e-3 } products { y: 1e-4 } }",
                       "mass_kg: 1 spring { stiffness_N_per_m: 100 damping_Ns_per_m: 1 stiffness_Nm_per_rad: 0.1 }",
                       "mass_kg: 1 hinge { anchor_m { x: 0.1 } axis { z: 1 } lowest: -1 highest: 0.5 }",
                       "mass_kg: 1 slider { axis { x: 0.6 y: 0.8 } }",
                       "mass_kg: 1 planes { normal { z: 1 } } planes { normal { x: -1 } offset_m: -0.5 friction: 0 "
                       "rolling_m: 1e-3 }", "mass_kg: 0.1 collision { friction: 0.4 }", "fixed: true collision {}",
                       "tool { spacing_m: 0.02 torsion_Nm_per_rad: 0.5 }", ""):
            with self.subTest(motion=motion):
                client.apply('operations { set_motion { object { name: "ball" } motion { %s } } }' % motion)
                self.assert_in_step(client)
        self.assertFalse(client.objects()["ball"].HasField("motion"))

    def test_it_hears_where_bodies_are(self):
        client = self.client(telemetry_hz=100)
        client.apply(BALL)
        client.apply('operations { set_motion { object { name: "ball" } motion { mass_kg: 0.1 } } }')
        first = harness.wait_until(lambda: client.bodies().get("ball"), 20, "the ball is told of")
        harness.wait_until(lambda: client.bodies()["ball"].pose.position.z < first.pose.position.z - 0.05, 20,
                           "the ball falls")

    def test_it_brings_height_maps_and_values_per_vertex_of_its_own(self):
        client = self.client()
        client.apply(BALL.replace("sphere { radius_m: 0.01 segments: 4 }", "box { size_m { x: 0.1 y: 0.1 z: 0.1 } }"))
        ridges = [[0.5 + 0.5 * math.cos(2 * math.pi * x / 16) for x in range(64)] for _ in range(32)]
        texture = client.upload(haptic_assets.FIELD, haptic_assets.field(ridges))
        scale = client.upload(haptic_assets.VERTEX_VALUES, haptic_assets.vertex_values([1, 0, 2, 0.5, 1, 1, 1, 1]))
        transaction = scene_pb2.Transaction()
        change = transaction.operations.add().set_material
        change.object.name = "ball"
        mapped = change.material.texture.field.mapped
        mapped.asset, mapped.mapping.shape, mapped.mapping.tile_m = texture, scene_pb2.MAPPING_SHAPE_CUBE, 0.02
        change.material.texture.amplitude_m = 1e-3
        change.material.friction.mu_static = change.material.friction.mu_dynamic = 0.5
        change.material.friction.per_vertex.asset = scale
        points = client.upload(haptic_assets.POINT_FIELD,
                               haptic_assets.point_field([(0.05, 0, -0.0, 1), (0.05, 0.01, 0, -1)], 0.02))
        change.material.stiffness_over.field.grown.asset, change.material.stiffness_over.variation = points, 0.5
        client.apply(transaction)
        self.assert_in_step(client)
        self.assertEqual(client.objects()["ball"].stiffness_over.field.grown.asset, points)
        self.assertAlmostEqual(client.objects()["ball"].texture.field.mapped.mapping.size_m.x, 0.1, 6)
        self.server.ctl("verify").json()
        with self.assertRaises(haptic_assets.UploadRefused) as refused:
            client.upload(haptic_assets.FIELD, b"no field")
        self.assertEqual(refused.exception.field, "chunk.data")

    def test_it_raises_what_is_wrong_and_where(self):
        client = self.client()
        with self.assertRaises(Rejected) as rejected:
            client.apply('operations { set_material { object { name: "box" } material { damping_Ns_per_m: -1 } } }')
        self.assertEqual(rejected.exception.field, "operations[0].set_material.material.damping_Ns_per_m")
        stale = client.objects()["box"]
        increment(client, "box")
        with self.assertRaises(Conflict) as conflict:
            client.apply(f'preconditions {{ object {{ name: "box" }} expected_revision: {stale.revision} }}' + BALL)
        self.assertEqual(conflict.exception.current[0].stiffness_N_per_m, stale.stiffness_N_per_m + 1)

    def test_it_says_what_is_wrong_with_an_address_and_names_it(self):
        for address, wrong in [("localhost", "has no port"), ("127.0.0.1:port", '"port" is not a port'),
                               ("127.0.0.1:99999", '"99999" is not a port'), ("::1:7654", "needs brackets"),
                               ("", "has no port"), ("no host:7654", '"no host" is not a host')]:
            with self.assertRaisesRegex(Refused, f"^{re.escape(address)}: .*{wrong}.*; give HOST:PORT"):
                Client(address)
        client = Client("127.0.0.1:1")  # where nobody listens
        self.addCleanup(client.close)
        harness.wait_until(lambda: "cannot connect" in client._trouble, 20, lambda: client._trouble)
        with self.assertRaisesRegex(Refused, "^127.0.0.1:1: cannot connect: .*is haptic_server running there"):
            client.wait_live(0.1)

    def test_increments_of_clients_at_once_are_all_there(self):
        clients = [self.client() for _ in range(4)]
        start = clients[0].objects()["box"].stiffness_N_per_m
        threads = [threading.Thread(target=lambda c=client: [increment(c, "box") for _ in range(25)])
                   for client in clients]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(300)
        for client in clients:
            self.assert_in_step(client)
        self.assertEqual(clients[0].objects()["box"].stiffness_N_per_m, start + 100)

    def test_an_edit_whose_answer_was_lost_is_applied_once(self):
        relay = DeafRelay(self.server)
        self.addCleanup(relay.close)
        client = self.client(relay.address)
        start = self.server.status()["revision"]
        relay.deaf = True
        edit = client.submit(BALL)
        harness.wait_until(lambda: self.server.status()["revision"] == start + 1, 30, "the edit is applied")
        self.assertFalse(edit.reply.done())
        relay.cut()
        relay.deaf = False
        self.assertEqual(edit.result(30).revision, start + 1)
        self.assertGreater(edit.live_since_tick(30), 0)
        self.assertEqual(client.connections, 2)
        self.assert_in_step(client)
        self.assertEqual(self.server.status()["revision"], start + 1)

    def test_it_outlives_a_restart_of_the_server(self):
        client = self.client()
        client.apply(BALL)
        self.server.kill()
        late = client.submit('operations { remove { object { name: "box" } } }')
        self.server = self.start_server(listen=self.server.address)
        late.result(30)
        self.assert_in_step(client)
        self.assertEqual(set(client.objects()), {"torus"})

    def test_it_speaks_tls_with_a_token(self):
        self.server.kill()
        self.server = self.start_server(credentials=harness.make_credentials(self.folder / "keys"))

        class HeldUp(Client):
            def _lost(self, error):
                time.sleep(0.3)
                super()._lost(error)

        client = HeldUp(self.server.address)
        time.sleep(0.2)  # it has been refused, and is held up before it says why
        with self.assertRaises(Refused) as refusal, client:
            pass
        self.assertIn("--credentials", str(refusal.exception))
        editor = self.folder / "keys" / "editor.credentials"
        saved = self.folder / "saved.credentials"
        saved.write_bytes(("\ufeff# für\r\n" + editor.read_text().replace("\n", " \r\n")).encode())
        saved.chmod(0o600)
        self.client(credentials=saved).apply(BALL)
        with self.assertRaises(Rejected) as rejected:
            self.client(credentials=self.folder / "keys" / "viewer.credentials").apply(BALL)
        self.assertEqual(rejected.exception.field, "role")

    def test_example_pushes_a_scene_change(self):
        scene = self.folder / "ball.scene"
        scene.write_text(BALL)
        pushed = self.example("push_scene_change", scene)
        self.assertEqual(pushed.wait(), 0, pushed.text())
        status = self.server.status()
        said = pushed.find(r"^revision (\d+), live since tick \d+, root ([0-9a-f]{64})$")
        self.assertEqual((int(said[1]), said[2]), (status["revision"], status["root"]))
        changed = self.example("push_scene_change", "--stiffness", "321", "ball")
        self.assertEqual(changed.wait(), 0, changed.text())
        self.assertEqual(self.server.ctl("get", "ball").json()["object"][0]["stiffness_N_per_m"], 321)
        refused = self.example("push_scene_change", "--stiffness", "-1", "ball")
        self.assertEqual(refused.wait(), 1)
        self.assertIn("operations[0].set_material.material.stiffness_N_per_m", refused.text())

    def test_example_says_in_one_line_which_scene_file_it_cannot_read(self):
        absent, unreadable = self.folder / "absent.scene", self.folder / "unreadable.scene"
        unreadable.write_text("operations { ad { } }")
        for file, reason in ((absent, "No such file or directory"), (unreadable, "ad")):
            pushed = self.example("push_scene_change", file)
            self.assertEqual(pushed.wait(), 1)
            self.assertRegex(pushed.text(), rf"\Apush_scene_change: {file}: .*{reason}.*\Z")

    def test_example_streams_forces_to_csv(self):
        file = self.folder / "forces.csv"
        streaming = self.example("stream_forces", "--rate", "200", "--out", file)

        def rows():
            with file.open() as lines:
                return list(csv.DictReader(lines))

        def touches():  # the last row may be half written
            return file.exists() and any(row["object"] and float(row["force_z_N"]) != 0 for row in rows()[:-1])
        harness.wait_until(lambda: streaming.alive() and touches() and file.stat().st_size > 20_000, 60, streaming.text)
        streaming.send(signal.SIGINT)
        self.assertEqual(streaming.wait(), 0, streaming.text())
        ticks = [int(row["tick"]) for row in rows()]
        self.assertEqual(ticks, sorted(set(ticks)))

    def test_example_animates_an_object_at_60_hz(self):
        before = self.server.status()["revision"]
        home = self.server.ctl("get", "torus").json()["object"][0]["pose"]["position"]
        for _ in range(5):  # a loaded machine leaves some out, not most every time
            animation = self.example("animate_object", "--seconds", "3", "torus")
            self.assertEqual(animation.wait(), 0, animation.text())
            poses, left_out = map(int, animation.find(r"^(\d+) poses in 3 s, (\d+) left out$").groups())
            self.assertEqual(poses + left_out, 180)
            self.assertEqual(self.server.status()["revision"], before + 1, "a motion makes no revision, putting it back one")
            before += 1
            if poses > 90:
                break
        self.assertGreater(poses, 90)
        self.assertEqual(self.server.ctl("get", "torus").json()["object"][0]["pose"]["position"], home)

    def test_example_strokes_an_object_until_ctrl_c_and_lets_the_hand_go(self):
        stroking = self.example("stroke_scene", "--seconds", "600", "box")
        harness.wait_until(lambda: stroking.find(r"^box: contact [\d.]+ %  force [\d.]+ N  step [\d.]+ N$"), 120, stroking.text)
        self.assertEqual(self.server.status()["hand_leader"], "stroke_scene")
        stroking.send(signal.SIGINT)
        self.assertEqual(stroking.wait(), 0, stroking.text())
        self.assertEqual(stroking.errors, [])
        harness.wait_until(lambda: not self.server.status()["hand_leader"], 10, "the hand is led still")
        unknown = self.example("stroke_scene", "lid")
        self.assertEqual(unknown.wait(), 1)
        self.assertRegex(unknown.text(), "there is no lid; there are .*box")

    def test_example_twists_a_bar_and_takes_the_lattice_away(self):
        self.server.ctl("apply", "-", text='operations { add { name: "bar" mesh { box { size_m { x: 0.04 y: 0.04 z: 0.16 } '
                        'segments: 8 } } pose { position { x: 0.3 } } } }').json()
        client = self.client()
        twisting = self.example("twist_bar", "--seconds", "2", "bar")
        harness.wait_until(lambda: len(client.objects()["bar"].deformation.lattice.control_m) == 96, 20, twisting.text)
        self.assertEqual(twisting.wait(), 0, twisting.text())
        lattices, left_out = map(int, twisting.find(r"^(\d+) lattices in 2 s, (\d+) left out$").groups())
        self.assertEqual(lattices + left_out, 60)
        harness.wait_until(lambda: not client.objects()["bar"].HasField("deformation"), 10, twisting.text)
        self.assert_in_step(client)

    def test_example_lets_the_guidance_along_a_letter_fade_and_puts_it_back(self):
        self.server = self.start_server(scene=(harness.PROJECT / "deploy/scenes/trace_letter.scene").read_text())
        client = Client(self.server.address, telemetry_hz=200)
        self.addCleanup(client.close)
        client.wait_live()
        guide = client.objects()["sheet"].effects[0]
        tracing = self.example("trace_letter", "--lead", "--passes", "2")
        stiffness = set()

        def watch():
            while tracing.alive():
                stiffness.update(effect.stiffness_N_per_m for effect in client.objects()["sheet"].effects)
                time.sleep(0.02)
        watching = threading.Thread(target=watch)
        watching.start()
        self.assertEqual(tracing.wait(), 0, tracing.text())
        watching.join()
        self.assertRegex(tracing.text(), r"pass 1: [0-2]\.\d mm from the letter under 200 N/m\npass 2: .* under 140 N/m")
        self.assertIn(140, stiffness)
        harness.wait_until(lambda: client.objects()["sheet"].effects[0] == guide, 10, "the scene's own guide")
        self.assert_in_step(client)


if __name__ == "__main__":
    unittest.main()
