"""A client in another language, written from proto/README.md alone, holds what the server holds: stranger.js."""
import json
import re
import shlex
import shutil
import subprocess
import sys
import unittest

import haptic_assets
import haptic_scene
import harness
from haptic_client import Client

TOP = harness.Path(__file__).resolve().parents[2]
SKIPPED = 77  # as CMake is told
ROUNDS, EDITS_A_ROUND = 10, 4  # of stranger.js

FIELD = "fourier { terms { direction { x: 1 } wavelength_m: 2e-3 } terms { amplitude: -0.5 direction { z: 1 } " \
        "wavelength_m: 3e-3 phase_rad: 1 } }"
LAYERS = "layers { combination: LAYER_COMBINATION_PRODUCT layer { field { grain { grain_m: 1e-3 seed: 7 } } } " \
         "layer { weight: -2 field { cellular { cell_m: 2e-3 } } } }"
MAPPED = "mapped { spot_noise { cells: 3 resolution: 32 } mapping { shape: MAPPING_SHAPE_CUBE tile_m: 0.01 } }"
GROWN = "grown { reaction_diffusion { wavelength_m: 0.016 } }"
NOISE = "noise { wavelength_m: 4e-3 octaves: 3 persistence: 0.4 seed: 5 }"
CORNERS = " ".join(f"control_m: {0.02 * x}" for i in range(8) for x in (-1 + 2 * (i & 1), -1 + (i & 2), -1 + (i & 4) / 2))
INERTIA = "inertia { centre_m { x: 0.001 } moments { x: 1e-3 y: 2e-3 z: 2.5e-3 } products { y: 1e-4 } }"
SPRING = "spring { stiffness_N_per_m: 100 damping_Ns_per_m: 1 stiffness_Nm_per_rad: 0.1 damping_Nms_per_rad: 1e-3 }"

SCALARS = " ".join(f"{name}: 0.25" for name in haptic_scene.SCALARS)

# Each property and each family of fields at least once.
OBJECTS = (
    f"material {{ shading {{ crease_rad: 0.5 creases {{ first: 2 second: 0 }} creases {{ first: 0 second: 1 }} }} texture {{ amplitude_m: 5e-4 gain_K: 1 "
    f"literal: true field {{ {FIELD} }} }} friction {{ mu_static: 0.6 mu_dynamic: 0.3 variation: 0.2 field {{ {NOISE} }} "
    f"dynamic_variation: 0.1 dynamic_field {{ {LAYERS} }} }} }}",
    f"material {{ texture {{ law: TEXTURE_LAW_BUMP amplitude_m: 5e-4 field {{ {MAPPED} }} }} stiffness_over {{ variation: 0.3 "
    f"field {{ {GROWN} }} }} softness_over {{ variation: -0.5 field {{ {NOISE} }} }} }} deformation {{ softness {{ "
    "stiffness_N_per_m: 200 radius_m: 0.01 degree: 3 return_s: 0.5 plastic: 0.5 } }",
    "material { color { red: 0.1 green: 1 } friction { mu_static: 1 per_vertex { values { %s } } } %s }" %
    (" ".join(f"value: {i / 8}" for i in range(8)), SCALARS),
    f"deformation {{ lattice {{ points_x: 2 points_y: 2 points_z: 2 {CORNERS} }} }}",
    f"motion {{ mass_kg: 1 {INERTIA} {SPRING} hinge {{ anchor_m {{ x: 0.1 }} axis {{ z: 1 }} lowest: -1 highest: 0.5 }} }}",
    "motion { mass_kg: 0.5 gravity_m_per_s2 {} linear_damping_per_s: 0.5 slider { axis { x: 0.6 y: 0.8 } } }",
    "motion { mass_kg: 0.1 planes { normal { z: 1 } } planes { normal { x: -1 } offset_m: -0.5 friction: 0 rolling_m: 1e-3 } }",
    "motion { mass_kg: 0.1 collision { friction: 0.4 rolling_m: 1e-3 } planes { normal { z: 1 } } }",
    "motion { fixed: true collision {} }",
    "motion { tool { spacing_m: 0.05 } }",
    " ".join(harness.effects_of_every_kind()),
    "pose { position { x: -0.0 y: 1e-300 } rotation { w: 0.6 z: 0.8 } }",
)

JAWS = ('operations { add { name: "jaws" mesh { file: "forceps.obj" } motion { tool { spacing_m: 0.004 jaws { hinge_m { x: 1e-3 } '
        'axis { y: -1 } reach { x: 1 } grip_Nm_per_rad: 0.25 } } } } }\n')


def whole_scene():
    return harness.SCENE + "".join(
        f'operations {{ add {{ name: "object_{i}" mesh {{ box {{ size_m {{ x: 0.04 y: 0.04 z: 0.04 }} }} }} {text} }} }}\n'
        for i, text in enumerate(OBJECTS))


def lacking():
    """What stranger.js needs and this machine does not have; empty when all is there."""
    if not shutil.which("node"):
        return "node is not installed"
    done = subprocess.run(["node", "-e", "require('protobufjs')"], capture_output=True)
    return "node does not find protobufjs" if done.returncode else ""


class Stranger(harness.EndToEnd):
    def run_against(self, server, *arguments):
        """The command as the page has it; what it saw, compared with what the server holds."""
        command = shlex.split(re.search(r"^\$ (node .*)$", (TOP / "proto/README.md").read_text(), re.MULTILINE)[1])
        command = [server.address if word == "127.0.0.1:7654" else word for word in command]
        before = server.status()
        done = subprocess.run([*command, *map(str, arguments)], cwd=TOP, capture_output=True, text=True, timeout=harness.STOP_TIMEOUT_S)
        self.assertEqual(done.returncode, 0, done.stderr)
        saw, after = json.loads(done.stdout), server.status()
        self.assertEqual((saw["revision"], saw["root"]), (after["revision"], after["root"]))
        self.assertEqual(saw["edits"], 1 + ROUNDS * EDITS_A_ROUND)
        self.assertEqual(after["revision"], before["revision"] + saw["edits"])
        self.assertEqual(saw["resent"], ROUNDS * EDITS_A_ROUND)
        self.assertEqual((saw["snapshots"], saw["resumed"]), (1, ROUNDS + saw["continued"]))
        self.assertEqual((saw["commits"], saw["roots"]), (saw["edits"], saw["edits"] + 1))
        self.assertEqual(server.ctl("verify").code, 0)
        return saw

    def test_it_joins_edits_and_resumes_after_cuts(self):
        server = self.start_server()
        saw = self.run_against(server)
        self.assertEqual(saw["continued"], 1, "the torus takes several chunks, the box one")
        self.assertGreaterEqual(saw["datagrams"], 10)
        self.stop_and_check(server)

    def test_it_hashes_every_property_and_speaks_tls(self):
        credentials = harness.make_credentials(self.folder / "credentials")
        scenes = harness.PROJECT / "deploy/scenes"
        server = self.start_server(scene=whole_scene() + JAWS, credentials=credentials,
                                   options=("--hand", "none", "--assets", scenes))
        editor = credentials / "editor.credentials"
        with Client(server.address, credentials=str(editor)) as client:
            residue = client.upload(haptic_assets.MOVED_VERTICES, haptic_assets.moved_vertices({2: (0.01, 0, 0.03)}))
            escaped = "".join(f"\\x{byte:02x}" for byte in residue)
            client.apply('operations { set_deformation { object { name: "object_7" } deformation { residue { asset: "%s" } } } }'
                         % escaped)
        saw = self.run_against(server, editor)
        self.assertEqual(saw["datagrams"], 0)
        self.stop_and_check(server)


if __name__ == "__main__":
    if lacking():
        print(f"skipped: {lacking()}; deploy/test installs both")
        sys.exit(SKIPPED)
    unittest.main()
