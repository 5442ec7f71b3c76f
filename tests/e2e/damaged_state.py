"""A server with --state whose folder was damaged, cannot be written or is full: it starts all the same, and says what is
lost."""
import os
import random
import shutil
import subprocess
import time
import unittest

import harness
import haptic_client
from haptics.v1 import scene_pb2

DAMAGES = int(os.environ.get("HAPTICS_DAMAGES", "6"))
SEED = int(os.environ.get("HAPTICS_SEED", "1"))
PATIENCE_S = 60
EDITS = 12

SCENE = """
operations { add { name: "box" mesh { box { size_m { x: 0.05 y: 0.05 z: 0.05 } } } } }
operations { add { name: "ball" mesh { sphere { radius_m: 0.03 segments: 8 } } } }
"""


def move(x):
    return f'operations {{ set_pose {{ object {{ name: "box" }} pose {{ position {{ x: {x} }} }} }} }}'


def may_mount():
    return os.geteuid() == 0 and subprocess.run(["unshare", "-m", "true"], capture_output=True).returncode == 0


def flip(file, at):
    data = bytearray(file.read_bytes())
    data[at % len(data)] ^= 1
    file.write_bytes(bytes(data))


class DamagedState(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        self.state = self.folder / "state"

    def start(self, prefix=()):
        return self.start_server(scene=SCENE, prefix=prefix,
                                 options=["--state", self.state, "--recordings", self.folder])

    def make(self):
        """A folder that a killed server has left, and its status."""
        server = self.start()
        for i in range(EDITS):
            server.ctl("apply", "-", text=move(0.001 * i)).json()
        status = server.status()
        server.kill()
        return status

    def test_it_starts_from_random_damage(self):
        before = self.make()
        whole = self.folder / "whole"
        self.state.rename(whole)
        revisions = []
        for seed in range(SEED, SEED + DAMAGES):
            shutil.rmtree(self.state, ignore_errors=True)
            shutil.copytree(whole, self.state)
            chance = random.Random(seed)
            what = []
            for _ in range(chance.randint(1, 3)):
                file = chance.choice(sorted(f for f in self.state.rglob("*") if f.is_file() and f.stat().st_size
                                            and f.name not in ("reserve", "lock")))
                size = file.stat().st_size
                kind = chance.choice(["flip", "cut", "remove", "grow"])
                what.append((file.name, kind))
                if kind == "flip":
                    flip(file, chance.randrange(size))
                elif kind == "cut":
                    os.truncate(file, chance.randrange(size))
                elif kind == "remove":
                    file.unlink()
                else:
                    file.write_bytes(file.read_bytes() + chance.randbytes(chance.randint(1, 5000)))
            with self.subTest(seed=seed, what=what):
                server = self.start()
                status = server.status()
                revisions.append(int(status["revision"]))
                if int(status["revision"]) < int(before["revision"]) or status["lost"]:
                    self.assertIn("warning", server.text())
                if status["root"] == before["root"]:
                    self.assertFalse(status["lost"])
                self.assertEqual(int(server.ctl("apply", "-", text=move(0.5)).json()["revision"]), revisions[-1] + 1)
                server.ctl("verify").json()
                server.kill()
        print(f"\n{DAMAGES} damages, of revision {before['revision']}: {revisions}", flush=True)

    def test_a_damaged_mesh_is_a_placeholder_until_it_is_uploaded(self):
        before = self.make()
        for file in (self.state / "assets").iterdir():
            if file.stat().st_size > 1000:
                mesh, name = file.read_bytes(), file.name
        flip(self.state / "assets" / name, 500)
        server = self.start()
        self.assertIn('object "ball": mesh', server.text())
        status = server.status()
        self.assertEqual(status["lost"], ["ball: mesh"])
        self.assertNotEqual(status["epoch"], before["epoch"])
        client = haptic_client.Client(server.address)
        self.addCleanup(client.close)
        client.wait_live(PATIENCE_S)
        client.upload(scene_pb2.ASSET_KIND_MESH, mesh, PATIENCE_S)
        harness.wait_until(lambda: not server.status()["lost"], PATIENCE_S, server.text)
        server.kill()
        server = self.start()
        self.assertEqual(server.status()["lost"], [])
        self.assertNotIn("ball", server.text())

    def test_what_is_damaged_while_it_runs_is_written_anew(self):
        self.make()
        server = self.start()
        files = [f for f in (self.state / "assets").iterdir()]
        whole = {f: f.read_bytes() for f in files}
        for file in files:
            flip(file, 40)
        (self.state / "checkpoint").unlink()
        harness.wait_until(lambda: all(f.read_bytes() == whole[f] for f in files)
                           and (self.state / "checkpoint").exists(), PATIENCE_S, server.text)
        self.assertIn("written anew", server.text())
        self.stop_and_check(server)

    @unittest.skipUnless(may_mount(), "mounting needs root")
    def test_it_starts_from_a_folder_that_cannot_be_written(self):
        before = self.make()
        mount = f"mount --bind {self.state} {self.state} && mount -o remount,ro,bind {self.state}"
        server = self.start(prefix=["unshare", "-m", "sh", "-c", mount + ' && exec "$@"', "sh"])
        self.assertEqual(server.status()["root"], before["root"])
        self.assertIn("edits are rejected until they can be kept", server.text())
        answer = server.ctl("apply", "-", text=move(0.5))
        self.assertNotEqual(answer.code, 0)
        self.assertIn("cannot keep edits", answer.output + answer.errors)
        self.stop_and_check(server)

    @unittest.skipUnless(may_mount(), "mounting needs root")
    def test_it_starts_on_a_full_disk(self):
        before = self.make()
        (self.state / "reserve").unlink()
        flip(self.state / "log", 60)  # so that there is something to write
        mount = (f"cp -r {self.state} {self.folder}/whole && mount -t tmpfs -o size=400k tmpfs {self.state} && "
                 f"cp -r {self.folder}/whole/. {self.state} && (dd if=/dev/zero of={self.state}/filler || true)")
        server = self.start(prefix=["unshare", "-m", "sh", "-c", mount + ' 2>&1 && exec "$@"', "sh"])
        self.assertEqual(server.status()["root"], before["root"])
        answer = server.ctl("apply", "-", text=move(0.5))
        self.assertIn("cannot keep edits", answer.output + answer.errors)
        self.stop_and_check(server)


if __name__ == "__main__":
    unittest.main()
