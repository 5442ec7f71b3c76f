"""Bad input gets a message that names the field or file, a non-zero exit of the command, and a server that keeps running."""
import contextlib
import random
import struct
import time
import unittest

import harness

PLY_HEADER = """ply
format ascii 1.0
element vertex {vertices}
property float x
property float y
property float z
element face {faces}
property list uchar int vertex_indices
end_header
"""
THREE_CORNERS = "0 0 0\n1 0 0\n0 1 0\n"

# name of the file: (its content, what the message says of it)
BAD_MESHES = {
    "truncated.ply": (PLY_HEADER.format(vertices=3, faces=1) + "0 0 0\n1 0 0\n", "claims 3"),
    "huge.ply": (PLY_HEADER.format(vertices=300_000_000, faces=1) + THREE_CORNERS + "3 0 1 2\n", "claims 300000000"),
    "nan.ply": (PLY_HEADER.format(vertices=3, faces=1) + "0 0 0\nnan 0 0\n0 1 0\n3 0 1 2\n", "vertex 1"),
    "infinite.obj": ("v 0 0 0\nv inf 0 0\nv 0 1 0\nf 1 2 3\n", "vertex 1"),
    "out_of_range.off": ("OFF\n3 1 0\n" + THREE_CORNERS + "3 0 1 7\n", "vertex that is not there"),
    "empty.off": ("OFF\n0 0 0\n", "holds no face"),
    "nothing.stl": ("", "is empty"),
    "picture.png": ("not a mesh", ".ply, .stl, .off"),
}

BAD_SCENES = {
    "unknown field": ('operations { add { name: "a" colour: "red" } }', ("colour", "1:")),
    "ill-typed field": ('operations { set_material { object { name: "box" } material { stiffness_N_per_m: "hard" } } }',
                        ("stiffness_N_per_m", "1:")),
    "unknown object": ('operations { remove { object { name: "nobody" } } }', ("operations[0].remove.object", "nobody")),
    "negative stiffness": ('operations { set_material { object { name: "box" } material { stiffness_N_per_m: -1 } } }',
                           ("operations[0].set_material.material.stiffness_N_per_m",)),
    "infinite position": ('operations { set_pose { object { name: "box" } pose { position { x: inf } } } }',
                          ("operations[0].set_pose.pose.position",)),
    "name twice": ('operations { add { name: "box" mesh { sphere { radius_m: 0.01 } } } }', ("operations[0].add.name",)),
    "path out of the asset folder": ('operations { add { name: "a" mesh { file: "../../etc/passwd" } } }',
                                     ("operations[0].add.mesh.file",)),
    "missing file": ('operations { add { name: "a" mesh { file: "absent.ply" } } }',
                     ("operations[0].add.mesh.file", "absent.ply")),
}


def surface(properties):
    return 'operations { set_material { object { name: "box" } material { %s } } }' % properties


def mapped(source):
    return surface('texture { amplitude_m: 1e-3 field { mapped { %s mapping { shape: MAPPING_SHAPE_CUBE tile_m: 0.01 } } } }'
                   % source)


MATERIAL = "operations[0].set_material.material."
BAD_SCENES |= {
    "missing image": (mapped('image: "absent.png"'), (MATERIAL + "texture.field.mapped.image", "absent.png")),
    "no image": (mapped('image: "no_image.png"'), (MATERIAL + "texture.field.mapped.image", "no_image.png", "PNG or JPEG")),
    "image out of the asset folder": (mapped('image: "../x.png"'), (MATERIAL + "texture.field.mapped.image",)),
    "unknown field asset": (mapped(f'asset: "{"x" * 32}"'), (MATERIAL + "texture.field.mapped.asset",)),
    "unknown field asset of a layer": (
        surface('texture { amplitude_m: 1e-3 field { layers { layer { field { grain { grain_m: 1e-3 } } } layer { field { '
                'mapped { asset: "%s" mapping { shape: MAPPING_SHAPE_CUBE tile_m: 0.01 } } } } } } }' % ("x" * 32)),
        (MATERIAL + "texture.field.layers.layer[1].field.mapped.asset",)),
    "stiffness that varies by nothing": (
        surface("stiffness_over { variation: nan field { grain { grain_m: 1e-3 } } }"), (MATERIAL + "stiffness_over.variation",)),
    "too few values of softness": (
        surface("softness_over { per_vertex { values { value: [1, 0.5] } } }"),
        (MATERIAL + "softness_over.per_vertex", "has 2 values", "each wants one")),
    "layers within a layer": (
        surface("texture { amplitude_m: 1e-3 field { layers { layer { field { layers {} } } layer {} } } }"),
        (MATERIAL + "texture.field.layers.layer[0].field.layers", "layered within a layer")),
    "texture height of 0": (surface("texture { field { grain { grain_m: 1e-3 } } }"), (MATERIAL + "texture.amplitude_m",)),
    "infinite texture height": (surface("texture { amplitude_m: inf field { grain { grain_m: 1e-3 } } }"),
                                (MATERIAL + "texture.amplitude_m",)),
    "negative wavelength": (surface("texture { amplitude_m: 1e-3 field { noise { wavelength_m: -1 } } }"),
                            (MATERIAL + "texture.field.noise.wavelength_m",)),
    "friction that sliding increases": (surface("friction { mu_static: 0.3 mu_dynamic: 0.4 }"),
                                        (MATERIAL + "friction.mu_dynamic", "mu_static")),
    "crease angle out of range": (surface("shading { crease_rad: 4 }"), (MATERIAL + "shading.crease_rad", "3.14")),
    "crease that is no line": (surface("shading { crease_rad: 1 creases { first: 0 second: 99999 } }"),
                               (MATERIAL + "shading.creases", "99999")),
    "values for other vertices": (surface("friction { mu_static: 1 per_vertex { values { value: [1, 1, 1] } } }"),
                                  (MATERIAL + "friction.per_vertex", "has 3 values")),
}


def deformation(text):
    return 'operations { set_deformation { object { name: "box" } deformation { %s } } }' % text


GIVES = "operations[0].set_deformation.deformation."
BAD_SCENES |= {
    "falloff radius of 0": (deformation("softness { stiffness_N_per_m: 100 }"), (GIVES + "softness.radius_m",)),
    "falloff beyond the object": (deformation("softness { stiffness_N_per_m: 100 radius_m: 9 }"),
                                  (GIVES + "softness.radius_m", "beyond the object")),
    "tissue that pulls": (deformation("softness { stiffness_N_per_m: -1 radius_m: 0.01 }"),
                          (GIVES + "softness.stiffness_N_per_m",)),
    "time constant that is no number": (deformation("softness { stiffness_N_per_m: 9 radius_m: 0.01 return_s: nan }"),
                                        (GIVES + "softness.return_s",)),
    "dent that stays deeper than it was": (deformation("softness { stiffness_N_per_m: 9 radius_m: 0.01 plastic: 1.5 }"),
                                           (GIVES + "softness.plastic", "1.5")),
    "residue that nobody has": (deformation('residue { asset: "%s" }' % ("7" * 32)), (GIVES + "residue.asset", "upload")),
    "lattice of the wrong size": (deformation("lattice { points_x: 2 points_y: 2 points_z: 2 control_m: [0, 0, 0] }"),
                                  (GIVES + "lattice.control_m", "24")),
}


def effect(text):
    return 'operations { set_effects { object { name: "box" } effects { %s } } }' % text


EFFECT = "operations[0].set_effects.effects[0]."
BAD_SCENES |= {
    "force in no direction": (effect("kind: EFFECT_KIND_CONSTANT amplitude_N: 1"), (EFFECT + "direction", "length 0")),
    "spring that reaches nowhere": (effect("kind: EFFECT_KIND_SPRING_TO_POINT stiffness_N_per_m: 9 reach_m: 0"),
                                    (EFFECT + "reach_m", "more than 0")),
    "guide that stands still": (effect("kind: EFFECT_KIND_GUIDE stiffness_N_per_m: 9 path_m: [0, 0, 0, 0, 0, 0]"),
                                (EFFECT + "path_m", "same place")),
    "damping that is no number": (effect("kind: EFFECT_KIND_VISCOSITY damping_Ns_per_m: nan"),
                                  (EFFECT + "damping_Ns_per_m", "nan")),
    "texture that does not die away": (effect("kind: EFFECT_KIND_RECORDED_TEXTURE amplitude_N: 1 sample_rate_Hz: 1e4 "
                                              "speeds_m_per_s: 0.1 forces_N: 1 models: [1, -1.01]"), (EFFECT + "models[1]", "poles")),
    "magnet that reaches anywhere": (effect("kind: EFFECT_KIND_MAGNET stiffness_N_per_m: 9"), (EFFECT + "reach_m", "missing")),
}


def add(file_name):
    return f'operations {{ add {{ name: "bad" mesh {{ file: "{file_name}" }} }} }}'


class AskedOfARunningServer(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.server = self.start_server()
        self.before = self.server.status()

    def tearDown(self):
        """Whatever it was: the servo ticks on, the scene is as it was, an edit still works, and the server ends well."""
        after = self.server.status()
        self.assertEqual((after["revision"], after["root"]), (self.before["revision"], self.before["root"]))
        harness.wait_until(lambda: self.server.status()["ticks"] > after["ticks"], 10, "the servo ticks on")
        self.server.ctl("apply", "-", text='operations { remove { object { name: "box" } } }').json()
        self.stop_and_check(self.server)
        super().tearDown()

    def connect(self):
        client = harness.WireClient(self.server)
        self.addCleanup(client.close)
        return client

    def assert_refused(self, answer, code, *words):
        self.assertEqual(answer.code, code, answer.output + answer.errors)
        for word in words:
            self.assertIn(word, answer.errors)

    def test_a_bad_mesh_file_is_refused_by_name(self):
        for name, (content, reason) in BAD_MESHES.items():
            with self.subTest(name):
                (self.folder / name).write_text(content)
                answer = self.server.ctl("apply", "-", text=add(name))
                self.assert_refused(answer, 1, "operations[0].add.mesh.file", name, reason)

    def test_a_bad_field_is_refused_by_its_path(self):
        (self.folder / "no_image.png").write_text("not an image")
        for name, (text, words) in BAD_SCENES.items():
            with self.subTest(name):
                self.assert_refused(self.server.ctl("apply", "-", text=text), 1, *words)

    def test_a_missing_scene_file_is_named(self):
        self.assert_refused(self.server.ctl("apply", "absent.scene"), 1, "absent.scene")

    def test_a_wrong_protocol_version_is_told_the_right_one(self):
        client = self.connect()
        client.send_envelope(harness.hello_envelope("from the future", version=99))
        refusals = [said.refusal for said in client.until_closed() if said.WhichOneof("body") == "refusal"]
        self.assertEqual([refusal.supported_version for refusal in refusals], [1])

    def test_random_bytes_close_only_their_own_connection(self):
        generator = random.Random(1)
        for _ in range(20):
            client = self.connect()
            try:
                client.send(struct.pack("<I", 300) + generator.randbytes(300))
                client.until_closed()
            except ConnectionError:
                pass
            client.close()

    def test_a_frame_that_claims_4_GB_is_refused(self):
        client = self.connect()
        client.send(struct.pack("<I", 0xFFFFFFFF) + b"x" * 100)
        said = client.until_closed()
        self.assertTrue(any(envelope.WhichOneof("body") == "refusal" for envelope in said), said)

    def test_a_client_that_says_nothing_is_let_go(self):
        client = self.connect()
        start = time.monotonic()
        client.until_closed()
        self.assertGreater(time.monotonic() - start, 1)


class AskedOfACommand(harness.EndToEnd):
    def server_refuses(self, **arguments):
        with self.assertRaises(harness.NotStarted) as refusal:
            self.start_server(**arguments)
        self.assertGreater(refusal.exception.code, 0, "ended as a command that failed, not by a signal")
        return str(refusal.exception)

    def test_the_server_does_not_start_with_a_bad_mesh_and_names_it(self):
        for name, (content, reason) in BAD_MESHES.items():
            with self.subTest(name):
                (self.folder / name).write_text(content)
                said = self.server_refuses(scene=add(name))
                self.assertIn(name, said)
                self.assertIn(reason, said)

    def test_the_server_does_not_start_with_a_bad_scene_and_names_the_field(self):
        said = self.server_refuses(scene='operations { add { name: "a" colour: "red" } }')
        self.assertIn("colour", said)
        self.assertIn("test.scene", said)

    def test_a_port_in_use_is_named(self):
        server = self.start_server()
        self.assertIn(server.address.rsplit(":", 1)[1], self.server_refuses(listen=server.address))
        self.stop_and_check(server)

    def test_a_bad_address_is_named(self):
        self.assertIn("localhost:http", self.server_refuses(listen="localhost:http"))

    def test_hapticctl_without_a_server_says_so(self):
        free = harness.socket.create_server(("127.0.0.1", 0))
        address = f"127.0.0.1:{free.getsockname()[1]}"
        free.close()
        answer = harness.ctl(address, "--timeout", "2", "status")
        self.assertEqual(answer.code, 3)
        self.assertIn(address, answer.errors)

    def test_hapticctl_misused_says_how_it_is_used(self):
        self.assertEqual(harness.ctl("127.0.0.1:1", "aply").code, 2)
        self.assertEqual(harness.ctl("nonsense", "status").code, 2)


if __name__ == "__main__":
    unittest.main()
