"""haptics.World and haptics.SceneWorld from Python: forces, what is refused, arrays in place, threads, lifetimes.

usage: PYTHONPATH=build/release/python python_world_test.py [-v]
"""
import gc
import sys
import tempfile
import threading
import tracemalloc
import unittest
import weakref
from pathlib import Path
from unittest import mock

import numpy

import haptics
from haptics import scene
from haptics.scene import Material, MeshSource, Operation, Sphere


def box(half=0.05):
    corners = numpy.array([(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, numpy.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def press(depth, ticks=1000):
    """From above the box to `depth` below its top, then at rest."""
    positions = numpy.zeros((ticks, 3))
    positions[:, 2] = numpy.maximum(0.05 - depth, 0.06 - 1e-4 * numpy.arange(ticks))
    return positions


class PythonWorld(unittest.TestCase):
    def setUp(self):
        self.world = haptics.World()
        self.body = self.world.add("box", *box(), haptics.Material(stiffness_N_per_m=500))

    def test_force_is_stiffness_times_depth(self):
        last = self.world.run(press(0.004))[-1]
        self.assertEqual(last["body"], self.body)
        self.assertAlmostEqual(last["force_N"][2], 2, places=6)
        self.assertAlmostEqual(last["penetration_m"], 0.004)
        numpy.testing.assert_allclose(last["normal"], (0, 0, 1))
        self.assertEqual(haptics.Fault(last["fault"]), haptics.Fault.NONE)

    def test_edits_are_felt(self):
        self.world.run(press(0.004))
        at_rest = press(0.004)[-500:]
        self.world.set_material(self.body, haptics.Material(stiffness_N_per_m=250))
        self.assertAlmostEqual(self.world.run(at_rest)[-1]["force_N"][2], 1, places=3)
        self.world.set_pose(self.body, haptics.Pose(position_m=(0, 0, -0.002)))
        self.assertAlmostEqual(self.world.run(at_rest)[-1]["force_N"][2], 0.5, places=3)
        self.world.remove(self.body)
        self.assertEqual(self.world.run(at_rest)[-1]["body"], 0)

    def test_a_body_that_is_moved_pushes_the_hand(self):
        hand = numpy.array([[0.0, 0.0, 0.06]])
        self.world.run(numpy.repeat(hand, 600, axis=0))
        for tick in range(13):  # 1 m/s, up to 2 mm above the hand
            self.world.move_kinematic(self.body, haptics.Pose(position_m=(0, 0, 1e-3 * tick)))
            sample = self.world.run(hand)[0]
        self.assertAlmostEqual(sample["ihip_m"][2], 0.062, places=6)
        self.assertGreater(sample["force_N"][2], 1)
        self.assertFalse(sample["depenetrated"])

    def test_vertices_that_are_moved_push_the_hand(self):
        hand = numpy.array([[0.0, 0.0, 0.06]])
        self.world.run(numpy.repeat(hand, 600, axis=0))
        for tick in range(13):
            vertices = box()[0] + numpy.array((0, 0, 1e-3 * tick))
            self.world.move_vertices_kinematic(self.body, vertices)
            sample = self.world.run(hand)[0]
        self.assertAlmostEqual(sample["ihip_m"][2], 0.062, places=6)
        with self.assertRaisesRegex(ValueError, "vertices: are 2"):
            self.world.move_vertices_kinematic(self.body, numpy.zeros((2, 3)))

    def test_a_tool_is_turned_by_what_it_touches(self):
        points = self.world.hold(*box(0.01), haptics.Tool(spacing_m=0.004, torsion_Nm_per_rad=2))
        self.assertGreater(points, 20)
        poses = numpy.zeros((3000, 7))
        poses[:, 3] = 1
        poses[:, 0] = 0.055  # its middle beyond the edge of the body
        poses[:, 2] = numpy.maximum(0.057, 0.07 - 1e-5 * numpy.arange(3000))
        samples = self.world.run_tool(poses)
        self.assertEqual(samples.dtype, haptics.TOOL_SAMPLE)
        self.assertGreater(samples[-1]["force_N"][2], 1)
        self.assertGreater(abs(samples[-1]["torque_Nm"][1]), 1e-3)
        self.assertFalse(samples["waits"][5:].any())  # of the first ticks all points look around
        with self.assertRaisesRegex(ValueError, r"poses: is .*\(n, 7\) of float64"):
            self.world.run_tool(poses[:, :3])

    def test_what_it_cannot_take_is_named(self):
        corners, triangles = box()
        for field, call in {
            '"box" is already there': lambda: self.world.add("box", corners, triangles),
            "vertices: is (8, 2)": lambda: self.world.add("other", corners[:, :2], triangles),
            "triangles: names vertex -1": lambda: self.world.add("other", corners, triangles - 1),
            "triangles: is (12, 3) of float64": lambda: self.world.add("other", corners, triangles * 1.0),
            "mesh.triangles[": lambda: self.world.add("other", corners[:4], triangles),
            "stiffness_N_per_m: is nan": lambda: self.world.set_material(
                self.body, haptics.Material(stiffness_N_per_m=float("nan"))),
            "there is no body 99": lambda: self.world.remove(99),
            "positions: is (10, 3) of float32": lambda: self.world.run(numpy.zeros((10, 3), numpy.float32)),
            "positions: is (10, 2)": lambda: self.world.run(numpy.zeros((10, 2))),
            "positions: is (5, 3)": lambda: self.world.run(numpy.zeros((10, 3))[::2]),
            "omni, touch": lambda: haptics.Device.named("omny"),
            "device.rate_Hz": lambda: haptics.World(haptics.Device(rate_Hz=0)),
        }.items():
            with self.subTest(field), self.assertRaises(ValueError) as refusal:
                call()
            self.assertIn(field, str(refusal.exception))
        self.assertAlmostEqual(self.world.run(press(0.004))[-1]["force_N"][2], 2, places=6)

    def test_a_position_that_is_not_finite_takes_the_force_away(self):
        positions = press(0.004)
        positions[800:, 1] = numpy.nan
        samples = self.world.run(positions)
        self.assertEqual(haptics.Fault(samples[-1]["fault"]), haptics.Fault.NON_FINITE_HIP)
        self.assertEqual(tuple(samples[-1]["force_N"]), (0, 0, 0))
        self.assertTrue(numpy.isfinite(samples["force_N"]).all())
        self.assertLess(abs(numpy.diff(samples["force_N"][790:], axis=0)).max(), 0.3)

    def test_positions_are_read_in_place(self):
        positions = press(0.001, 1_000_000)
        positions.flags.writeable = False
        self.world.run(positions[:10])
        references = sys.getrefcount(positions)
        tracemalloc.start()
        samples = self.world.run(positions)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        self.assertGreaterEqual(peak, samples.nbytes)  # numpy's memory is seen
        self.assertLess(peak, samples.nbytes + 1e5)
        self.assertEqual(sys.getrefcount(positions), references)
        self.assertEqual(sys.getrefcount(samples), 2)

    def test_worlds_of_several_threads_run_at_once_and_come_to_the_same(self):
        expected = self.world.run(press(0.004))
        worlds = [haptics.World() for _ in range(4)]
        for world in worlds:
            world.add("box", *box(), haptics.Material(stiffness_N_per_m=500))
        results = [None] * len(worlds)

        def run(i):
            results[i] = worlds[i].run(press(0.004))

        self.in_threads(run, len(worlds))
        for result in results:
            numpy.testing.assert_array_equal(result["force_N"], expected["force_N"])

    def test_threads_may_share_a_world_and_edit_it(self):
        positions, errors = press(0.004), []

        def work(i):
            try:
                for step in range(20):
                    body = self.world.add(f"box {i} {step}", *box(0.01), pose=haptics.Pose((0.2 + 0.1 * i, 0, 0)))
                    samples = self.world.run(positions)
                    if not numpy.isfinite(samples["force_N"]).all():
                        errors.append("a force is not finite")
                    self.world.remove(body)
            except Exception as error:
                errors.append(repr(error))

        self.in_threads(work, 4)
        self.assertEqual(errors, [])

    def test_python_goes_on_while_a_world_runs(self):
        counted, stop = [0], threading.Event()

        def count():
            while not stop.is_set():
                counted[0] += 1

        counter = threading.Thread(target=count)
        positions = press(0.001, 2_000_000)
        interval = sys.getswitchinterval()
        sys.setswitchinterval(1e-4)
        counter.start()
        before = counted[0]
        self.world.run(positions)
        during = counted[0] - before
        stop.set()
        counter.join()
        sys.setswitchinterval(interval)
        self.assertGreater(during, 1000)

    def test_samples_outlive_their_world_and_worlds_end(self):
        samples = self.world.run(press(0.004))
        ended = weakref.ref(self.world)
        del self.world
        gc.collect()
        self.assertIsNone(ended())
        self.assertAlmostEqual(samples[-1]["force_N"][2], 2, places=6)

    def in_threads(self, work, count):
        threads = [threading.Thread(target=work, args=(i,)) for i in range(count)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()


SCENE = """
operations { add { name: "plate" mesh { box { size_m { x: 0.2 y: 0.2 z: 0.02 } } }
                   material { stiffness_N_per_m: 500
                              texture { amplitude_m: 0.0005
                                        field { fourier { terms { direction { x: 1 } wavelength_m: 0.01 } } } } } } }
operations { add { name: "ball" mesh { sphere { radius_m: 0.02 } } pose { position { z: 0.5 } } motion { mass_kg: 0.1 } } }
"""


class PythonSceneWorld(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        file = Path(folder.name) / "plate.scene"
        file.write_text(SCENE)
        self.world = haptics.SceneWorld(str(file), haptics.Device.named("omni"))

    def test_what_a_scene_file_says_is_felt(self):
        positions = numpy.zeros((2000, 3))
        positions[:, 2] = numpy.maximum(0.008, 0.02 - 1e-4 * numpy.arange(2000))
        positions[1000:, 0] = 5e-5 * numpy.arange(1000)
        stroke = self.world.run(positions)[1000:]
        self.assertTrue((stroke["body"] == self.world.bodies()[0].number).all())
        self.assertGreater(numpy.ptp(stroke["force_N"][:, 2]), 0.1)

    def test_bodies_move(self):
        self.world.run(numpy.full((100, 3), 1.0))
        plate, ball = self.world.bodies()
        self.assertEqual((plate.name, ball.name), ("plate", "ball"))
        self.assertEqual(plate.pose.position_m, [0, 0, 0])
        self.assertAlmostEqual(ball.pose.position_m[2], 0.5 - 9.81 * 0.1**2 / 2, delta=0.005)

    def test_edits_are_applied_whole_or_not_at_all(self):
        remove = 'operations { remove { object { name: "%s" } } }'
        self.world.apply(remove % "ball")
        self.assertEqual([body.name for body in self.world.bodies()], ["plate"])
        with self.assertRaisesRegex(ValueError, "ball"):
            self.world.apply(remove % "plate" + remove % "ball")
        self.assertEqual([body.name for body in self.world.bodies()], ["plate"])

    def test_what_it_cannot_take_is_named(self):
        with self.assertRaisesRegex(ValueError, "edit:1:.*no field \"oops\""):
            self.world.apply("oops { }")
        with self.assertRaisesRegex(ValueError, "no such file"):
            haptics.SceneWorld("missing.scene")
        with self.assertRaisesRegex(ValueError, "file"):
            self.world.apply('operations { add { name: "head" mesh { file: "missing.stl" } } }')

    def test_it_takes_the_protocols_messages_as_text(self):
        from google.protobuf import text_format
        from haptics.v1 import scene_pb2
        edit = scene_pb2.Transaction()
        edit.operations.add().remove.object.name = "ball"
        self.world.apply(text_format.MessageToString(edit))
        self.assertEqual([body.name for body in self.world.bodies()], ["plate"])


class PythonScene(unittest.TestCase):
    """A scene that is written without text format."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.scene = haptics.Scene(folder=self.folder)

    def test_it_is_that_of_the_same_text(self):
        self.scene.add(name="ball", mesh=MeshSource(sphere=Sphere(radius_m=0.02)), material=Material(stiffness_N_per_m=600))
        self.scene.set_pose(object={"name": "ball"}, pose={"position": {"z": 0.05}})
        self.scene.save(self.folder / "ball.scene")
        (self.folder / "text.scene").write_text("""
          operations { add { name: "ball" mesh { sphere { radius_m: 0.02 } } material { stiffness_N_per_m: 600 } } }
          operations { set_pose { object { name: "ball" } pose { position { z: 0.05 } } } }""")
        roots = {haptics.SceneWorld(scene).root()
                 for scene in (self.scene, self.folder / "ball.scene", str(self.folder / "text.scene"))}
        self.assertEqual(len(roots), 1)
        self.assertRegex(roots.pop(), "^[0-9a-f]{64}$")
        self.assertEqual(haptics.Scene.load(self.folder / "text.scene").transaction, self.scene.transaction)

    def test_every_operation_has_a_method(self):
        for field in Operation.DESCRIPTOR.fields:
            message = getattr(self.scene, field.name)()
            self.assertIs(message.DESCRIPTOR, field.message_type)
            self.assertEqual(self.scene.transaction.operations[-1].WhichOneof("op"), field.name)
        with self.assertRaisesRegex(TypeError, "Sphere is no operation"):
            self.scene.append(Sphere())

    def test_every_kind_of_effect_has_a_call(self):
        calls = {scene.EffectKind.Name(make(amplitude_N=1).kind): make
                 for make in (scene.constant, scene.spring_to_point, scene.spring_to_line, scene.spring_to_plane,
                              scene.spring_to_path, scene.guide, scene.forbidden_side, scene.viscosity, scene.vibration,
                              scene.tube, scene.inertia, scene.magnet, scene.spring_to_vertex, scene.spring_to_edge,
                              scene.samples, scene.recorded_texture)}
        self.assertEqual(set(calls), set(scene.EffectKind.keys()[1:]))
        self.scene.add(name="ball", mesh={"sphere": {"radius_m": 0.02}}, material=Material(**scene.TAPS["wood"]), effects=[
            scene.guide(path_m=numpy.array([(0, 0, 0.5), (0.1, 0, 0.5)]), stiffness_N_per_m=200, reach_m=0.1),
            scene.spring_to_plane(point_m=(0, 0, 0.5), direction=(0, 0, 1), stiffness_N_per_m=100)])
        haptics.SceneWorld(self.scene)
        self.assertEqual(list(self.scene.transaction.operations[0].add.effects[0].path_m), [0, 0, 0.5, 0.1, 0, 0.5])
        with self.assertRaises(ValueError):
            scene.viscosity(size_m=(1, 2))

    def test_an_edit_is_a_scene_too(self):
        self.scene.add(name="ball", mesh={"sphere": {"radius_m": 0.02}})
        world = haptics.SceneWorld(self.scene)
        before = world.root()
        edit = haptics.Scene()
        edit.set_material(object={"name": "ball"}, material={"stiffness_N_per_m": 300})
        world.apply(edit)
        self.assertNotEqual(world.root(), before)

    def test_files_that_it_names_go_with_it(self):
        (self.folder / "parts").mkdir()
        (self.folder / "parts/corner.obj").write_text(
            "v 0 0 0\nv 0.05 0 0\nv 0 0.05 0\nv 0 0 0.05\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        self.scene.add(name="corner", mesh=MeshSource(file="parts/corner.obj"))
        self.scene.add(name="head", mesh=MeshSource(file="of_the_server.iv"))
        self.scene.save(self.folder / "a.scene")
        other = self.folder / "other"
        other.mkdir()
        haptics.Scene.load(self.folder / "a.scene").save(other / "a.scene")
        self.assertTrue((other / "parts/corner.obj").exists())
        (other / "parts/corner.obj").write_text("another")
        with self.assertRaisesRegex(FileExistsError, r"operations\[0\].add.mesh.file: .*corner.obj is there already"):
            haptics.Scene.load(self.folder / "a.scene").save(other / "a.scene")

    def test_a_copy_that_fails_half_way_leaves_nothing(self):
        def fill_disk(source, part):
            part.write(source.read(2))
            raise OSError("no space left")
        (self.folder / "corner.obj").write_text("v 0 0 0")
        self.scene.add(name="corner", mesh=MeshSource(file="corner.obj"))
        self.scene.save(self.folder / "a.scene")
        other = self.folder / "other"
        other.mkdir()
        loaded = haptics.Scene.load(self.folder / "a.scene")
        with mock.patch("shutil.copyfileobj", fill_disk), self.assertRaisesRegex(OSError, "no space left"):
            loaded.save(other / "a.scene")
        self.assertEqual(list(other.iterdir()), [])
        with mock.patch("os.fsync") as fsync:
            loaded.save(other / "a.scene")
        self.assertEqual(fsync.call_count, 4, "two files, and their folder after each")
        self.assertEqual((other / "corner.obj").read_text(), "v 0 0 0")

    def test_what_it_cannot_take_is_named(self):
        self.scene.add(name="corner", mesh=MeshSource(file="../corner.obj"))
        with self.assertRaisesRegex(ValueError, r"operations\[0\].add.mesh.file: \"../corner.obj\" leaves"):
            self.scene.save(self.folder / "a.scene")
        with self.assertRaisesRegex(ValueError, r"operations\[0\].add.mesh.file"):
            haptics.SceneWorld(self.scene)
        (self.folder / "bad.scene").write_text("operations { grow { } }")
        with self.assertRaisesRegex(ValueError, r"bad.scene: 1:14 .*grow"):
            haptics.Scene.load(self.folder / "bad.scene")
        with self.assertRaises(TypeError):
            self.scene.add(name=7)


if __name__ == "__main__":
    unittest.main()
