"""Programs outside of the project, built with the installed library alone: forces are the server's, bit for bit; a client.

HAPTICS_RATE, HAPTICS_TICKS: of the recording beside the server. HAPTICS_BUILD: the project's build folder.
"""
import math
import os
import re
import shutil
import struct
import subprocess
import unittest

import harness
import haptic_recording

RATE_HZ = int(os.environ.get("HAPTICS_RATE", "1000"))
TICKS = int(os.environ.get("HAPTICS_TICKS", "8000"))
SERVER_EXAMPLES = harness.PROJECT / "haptic_server" / "examples"
MODELS = "/usr/share/inventor/data"
SCENE_TICKS = min(TICKS, 3000)
SCENES = ("demo", "skin", "table") if TICKS < 10_000 else (
    "demo", "texture_wall", "skin", "doughnut", "door", "table", "soft", "ffd_bar")
STANDARD = {"linux-vdso", "libstdc++", "libm", "libgcc_s", "libc", "ld-linux-x86-64"}
CRYPTO = {"libcrypto", "libzstd"}  # Debian 13's libcrypto loads libzstd
CLIENTS = STANDARD | {"libprotobuf", *CRYPTO, "libssl", "libOpenMeshCore", "libz"}
AROUND, ACROSS = 256, 126  # 64,512 triangles

SCENE = """
operations { add { name: "torus" mesh { file: "torus.stl" }
                   material { stiffness_N_per_m: 800 damping_Ns_per_m: 0.5 shading { crease_rad: 0.6 }
                              friction { mu_static: 0.4 mu_dynamic: 0.3 } } } }
"""

# What the page on teleoperation calls the program's own.
ROBOT = """
#include <utility>
struct End {
  using Vector = haptics::TeleoperationPort::Vector;
  Vector read() { return {}; }
  Vector tip() { return {}; }
  Vector contactForce() { return {}; }
  void write(const Vector&) {}
} device, robot;
struct {
  std::optional<haptics::TeleoperationPacket> last;
  void put(const haptics::TeleoperationPacket& packet) { last = packet; }
  std::optional<haptics::TeleoperationPacket> take() { return std::exchange(last, std::nullopt); }
} line;
"""


def write_torus(file):
    def place(i, j):
        u, v = 2 * math.pi * (i % AROUND) / AROUND, 2 * math.pi * (j % ACROSS) / ACROSS
        r = 0.042 + 0.018 * math.cos(v)
        return r * math.cos(u), r * math.sin(u), 0.018 * math.sin(v)

    facets = []
    for i in range(AROUND):
        for j in range(ACROSS):
            a, b, c, d = place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)
            facets += [(a, b, c), (a, c, d)]
    with open(file, "wb") as out:
        out.write(bytes(80) + struct.pack("<I", len(facets)))
        for facet in facets:
            out.write(struct.pack("<12fH", 0, 0, 0, *(x for corner in facet for x in corner), 0))


class InstalledLibrary(harness.EndToEnd):
    def run_or_fail(self, *command):
        done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "HAPTICS_PROGRAMS": str(harness.BIN)})
        self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout}{done.stderr}")
        return done.stdout

    def build_example(self, source, heavy, loaded):
        """Outside of the project. Its build has nothing to do with what is heavy, and it loads no other library."""
        prefix, copy, build = self.folder / "prefix", self.folder / source.name, self.folder / "build"
        self.run_or_fail("cmake", "--install", os.environ["HAPTICS_BUILD"], "--prefix", prefix, "--component", "library")
        shutil.copytree(source, copy)
        self.run_or_fail("cmake", "-S", copy, "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}",
                         "-DCMAKE_BUILD_TYPE=Release")
        self.run_or_fail("cmake", "--build", build)
        commands = self.run_or_fail("ninja", "-C", build, "-t", "commands").lower()
        for word in (*heavy, str(harness.PROJECT)):
            self.assertNotIn(word, commands)
        program = build / source.name
        libraries = {line.split()[0].split(".so")[0].split("/")[-1]
                     for line in self.run_or_fail("ldd", program).splitlines()}
        self.assertEqual(libraries - loaded, set())
        return program

    def record(self, scene, folders, ticks):
        file = self.folder / "ticks.haptics"
        seconds = ticks / RATE_HZ
        assets = [option for folder in folders for option in ("--assets", folder)]
        server = self.start_server(scene=scene, options=["--record", file, "--rate", RATE_HZ, "--seconds", seconds, *assets])
        server.wait(timeout_s=seconds + harness.STOP_TIMEOUT_S)
        recorded = list(haptic_recording.ticks(file))
        self.assertGreaterEqual(len(recorded), 0.9 * ticks)
        return recorded

    def compare(self, program, recorded, *scene):
        """The program's forces at the recorded positions are the server's."""
        ticks, forces = self.folder / "ticks", self.folder / "forces"
        ticks.write_bytes(b"".join(struct.pack("<Q3d", tick.tick, *tick.position) for tick in recorded))
        self.run_or_fail(program, str(RATE_HZ), *scene, ticks, forces)
        made = list(struct.iter_unpack("<3d", forces.read_bytes()))
        self.assertEqual(len(made), len(recorded))
        bits = struct.Struct("<3d").pack
        differing = [i for i, tick in enumerate(recorded) if bits(*tick.force) != bits(*made[i])]
        in_contact = sum(any(tick.force) for tick in recorded)
        print(f"{scene[0].name}: {len(recorded)} ticks, {in_contact} with a force, {len(differing)} with another one")
        self.assertGreater(in_contact, len(recorded) / 4)
        self.assertEqual(differing[:3], [], f"{recorded[differing[0]]} came to {made[differing[0]]}" if differing else "")

    def test_an_outside_program_comes_to_the_servers_forces(self):
        program = self.build_example(
            SERVER_EXAMPLES / "own_loop",
            ("vtk", "coin", "asio", "openssl", "libssl", "libcrypto", "protobuf", "openmesh"), STANDARD)
        mesh = self.folder / "torus.stl"
        write_torus(mesh)
        self.compare(program, self.record(SCENE, [self.folder], TICKS), mesh)

    def test_an_outside_program_comes_to_the_servers_forces_in_whole_scenes(self):
        program = self.build_example(SERVER_EXAMPLES / "scene_loop", ("vtk", "coin", "asio", "libssl"),
                                     STANDARD | {"libprotobuf", *CRYPTO, "libOpenMeshCore", "libz"})
        for name in SCENES:
            with self.subTest(scene=name):
                scene = harness.PROJECT / "deploy" / "scenes" / f"{name}.scene"
                recorded = self.record(scene.read_text(), [scene.parent, MODELS], SCENE_TICKS)
                self.compare(program, recorded, scene, MODELS)

    def test_an_outside_client_edits_and_follows_a_server(self):
        program = self.build_example(harness.PROJECT / "graphics_client" / "examples" / "follow_force", ("vtk", "coin", "asio"),
                                     CLIENTS)
        server = self.start_server()
        pose = 'operations { set_pose { object { name: "%s" } pose { position { z: %g } } } }'
        said = self.run_or_fail(program, server.address, "2", pose % ("box", 0.001)).splitlines()
        self.assertRegex(said[0], "revision 2, felt since tick [1-9]")
        self.assertEqual(len(said), 21)
        self.assertIn("N, touches", said[-1])
        for edit, reason in {pose % ("nobody", 0): "nobody", pose % ("box", 1e9): "position", "oops {": "edit:1:"}.items():
            refused = subprocess.run([program, server.address, "1", edit], capture_output=True, text=True)
            self.assertEqual(refused.returncode, 1)
            self.assertIn(reason, refused.stderr)
        self.stop_and_check(server)
        alone = subprocess.run([program, server.address, "1"], capture_output=True, text=True)
        self.assertEqual(alone.returncode, 1)
        self.assertIn(server.address, alone.stderr)

    def test_what_the_clients_pages_show_compiles(self):
        client = harness.PROJECT / "graphics_client"
        shown = [line for page in ("README.md", "client/README.md")
                 for block in re.findall("^```cpp\n(.*?)^```", (client / page).read_text(), re.M | re.S)
                 for line in block.splitlines()]
        included = [line for line in shown if line.startswith("#include")]
        source = self.folder / "shown" / "follow_force"
        shutil.copytree(client / "examples" / source.name, source)
        (source / "main.cpp").write_text("\n".join([*included, ROBOT, "int main() {", *(line for line in shown if line not in included),
                                                    "}", ""]))
        self.build_example(source, ("vtk", "coin", "asio"), CLIENTS)


if __name__ == "__main__":
    unittest.main()
