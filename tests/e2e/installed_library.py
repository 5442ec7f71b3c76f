"""A program outside of the project, built with the installed library alone, comes to the server's forces bit for bit.

HAPTICS_RATE, HAPTICS_TICKS: of the recording beside the server. HAPTICS_BUILD: the project's build folder.
"""
import math
import os
import shutil
import struct
import subprocess
import unittest
from pathlib import Path

import harness
import haptic_recording

RATE_HZ = int(os.environ.get("HAPTICS_RATE", "1000"))
TICKS = int(os.environ.get("HAPTICS_TICKS", "8000"))
EXAMPLE = harness.PROJECT / "haptic_server" / "examples" / "own_loop"
AROUND, ACROSS = 256, 126  # 64,512 triangles

SCENE = """
operations { add { name: "torus" mesh { file: "torus.stl" }
                   material { stiffness_N_per_m: 800 damping_Ns_per_m: 0.5 shading { crease_rad: 0.6 }
                              friction { mu_static: 0.4 mu_dynamic: 0.3 } } } }
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
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout}{done.stderr}")
        return done.stdout

    def build_example(self):
        prefix, source, build = self.folder / "prefix", self.folder / "own_loop", self.folder / "own_loop_build"
        self.run_or_fail("cmake", "--install", os.environ["HAPTICS_BUILD"], "--prefix", prefix, "--component", "library")
        shutil.copytree(EXAMPLE, source)
        self.run_or_fail("cmake", "-S", source, "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}",
                         "-DCMAKE_BUILD_TYPE=Release")
        self.run_or_fail("cmake", "--build", build)
        commands = self.run_or_fail("ninja", "-C", build, "-t", "commands").lower()
        for heavy in ("vtk", "coin", "asio", "openssl", "libssl", "libcrypto", "protobuf", "openmesh", str(harness.PROJECT)):
            self.assertNotIn(heavy, commands)
        loaded = self.run_or_fail("ldd", build / "own_loop")
        self.assertEqual({line.split()[0].split(".so")[0].split("/")[-1] for line in loaded.splitlines()},
                         {"linux-vdso", "libstdc++", "libm", "libgcc_s", "libc", "ld-linux-x86-64"})
        return build / "own_loop"

    def record(self):
        mesh, file = self.folder / "torus.stl", self.folder / "ticks.haptics"
        write_torus(mesh)
        seconds = TICKS / RATE_HZ
        server = self.start_server(scene=SCENE, options=["--record", file, "--rate", RATE_HZ, "--seconds", seconds,
                                                         "--assets", self.folder])
        server.wait(timeout_s=seconds + harness.STOP_TIMEOUT_S)
        return mesh, list(haptic_recording.ticks(file))

    def test_an_outside_program_comes_to_the_servers_forces(self):
        program = self.build_example()
        mesh, recorded = self.record()
        self.assertGreaterEqual(len(recorded), 0.9 * TICKS)
        ticks, forces = self.folder / "ticks", self.folder / "forces"
        ticks.write_bytes(b"".join(struct.pack("<Q3d", tick.tick, *tick.position) for tick in recorded))
        print(self.run_or_fail(program, str(RATE_HZ), mesh, ticks, forces))
        made = list(struct.iter_unpack("<3d", forces.read_bytes()))
        self.assertEqual(len(made), len(recorded))
        bits = struct.Struct("<3d").pack
        differing = [i for i, tick in enumerate(recorded) if bits(*tick.force) != bits(*made[i])]
        in_contact = sum(any(tick.force) for tick in recorded)
        print(f"{len(recorded)} ticks, {in_contact} with a force, {len(differing)} with another one")
        self.assertGreater(in_contact, len(recorded) / 4)
        self.assertEqual(differing[:3], [], f"{recorded[differing[0]]} came to {made[differing[0]]}" if differing else "")


if __name__ == "__main__":
    unittest.main()
