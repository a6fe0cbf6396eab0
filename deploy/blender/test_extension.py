#!/usr/bin/env python3
"""Tests the extension in Blender as a module, without a screen.

    python3.11 -m venv target/bpy-venv
    target/bpy-venv/bin/pip install bpy==5.0.1
    target/bpy-venv/bin/pip install ./services/python
    target/bpy-venv/bin/python deploy/blender/test_extension.py

Takes 350 MB of download, so .ci/run leaves it out. Objects are submitted to a farm of this machine, fetched and
imported; every transform is held to the recording, at frames and between them, as is what is there when, and the shape
of a sheet.
"""

import random
import socket
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import bpy
import cullet
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import cullet_blender  # noqa: E402
from cullet_blender import tracks  # noqa: E402
from cullet_blender.importing import import_run  # noqa: E402
from cullet_blender.submitting import scene_of  # noqa: E402

FOLDER = tempfile.TemporaryDirectory()


def folder():
    return Path(tempfile.mkdtemp(dir=FOLDER.name))


def empty():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return bpy.context.scene


def there(objects):
    return sorted(each["cullet_body"] for each in objects if not each.hide_viewport)


class Tracks(unittest.TestCase):
    def test_a_body_without_a_row_rests(self):
        places = np.array([[0, 0, 1], [0, 0, 0], [1, 0, 0]], dtype=float)
        half = np.sqrt(0.5)
        # The third turn is a quarter about z, as the quaternion of the other sign.
        turns = np.array([[0, 0, 0, 1], [0, 0, 0, 1], [0, 0, -half, -half]])
        track = cullet.Table({"step": np.array([0, 1, 11], dtype=np.uint64), "position": places, "rotation": turns})
        location, turn = tracks.at_frames(track, 0.1, 10, [0, 1, 5, 10, 11, 20], np.inf)
        np.testing.assert_allclose(location[:, 2], [1, 0, 0, 0, 0, 0])
        np.testing.assert_allclose(location[:, 0], [0, 0, 0, 0, 1, 1])
        np.testing.assert_allclose(turn[3], [1, 0, 0, 0])
        np.testing.assert_allclose(turn[4], [half, 0, 0, half])
        # Between two steps on the straight line.
        location, turn = tracks.at_frames(track, 0.1, 20, [1, 21], np.inf)
        np.testing.assert_allclose(location, [[0, 0, 0.5], [0.5, 0, 0]])
        np.testing.assert_allclose(turn[1], [np.cos(np.pi / 8), 0, 0, np.sin(np.pi / 8)], atol=1e-12)

    def test_keys_that_say_nothing_are_left_out(self):
        kept = tracks.needed(np.array([[0.0], [0], [0], [1], [2], [2], [2]]), 1e-9)
        self.assertEqual(kept.tolist(), [True, False, True, True, True, False, True])


class Import(unittest.TestCase):
    def setUp(self):
        self.scene = empty()

    def run_of(self):
        build = cullet.SceneBuilder("drop", world={"duration": 0.5}, fracture={"max_particles": 5000})
        build.add_body(
            "floor", shape={"kind": "box", "size": [4, 4, 0.2]}, position=[0, 0, -0.1], material="granite", fixed=True
        )
        build.add_body(
            "ball", shape={"kind": "sphere", "radius": 0.06}, position=[0, 0, 0.3], velocity=[0, 0, -20],
            spin=[8, 5, 0], material="plaster",
        )
        return cullet.run(build.scene(), folder(), workers=1, progress=False)

    def test_bodies_are_where_the_recording_has_them(self):
        recording = self.run_of()
        fps = 24
        count = import_run(bpy.context, recording)
        objects = [each for each in self.scene.objects if "cullet_body" in each]
        self.assertEqual(count, len(objects))
        self.assertEqual({each["cullet_body"] for each in objects}, set(recording.bodies.body.tolist()))
        draw, worst = random.Random(5), 0.0
        for frame in [0, 1, *(draw.randint(0, 12) for _ in range(8)), 12]:
            self.scene.frame_set(frame)
            bpy.context.view_layer.update()
            poses = recording.poses(frame / fps)
            self.assertEqual(there(objects), sorted(poses.body.tolist()), f"frame {frame}")
            # A frame is a whole number of steps here: 240 of them a second.
            for each in objects:
                if each.hide_viewport:
                    continue
                at = poses[poses.body == each["cullet_body"]]
                place, turn, size = each.matrix_world.decompose()
                x, y, z, w = at.rotation[0]
                near = abs(np.dot([turn.x, turn.y, turn.z, turn.w], [x, y, z, w]))
                worst = max(worst, np.abs(np.array(place) - at.position[0]).max(), 1 - near)
                self.assertAlmostEqual(size.x, 1, places=5)
        self.assertLess(worst, 1e-5)

    def test_meshes_and_collections_are_those_of_the_recording(self):
        recording = self.run_of()
        import_run(bpy.context, recording)
        ball = recording.body("ball")
        pieces = bpy.data.collections["ball pieces"]
        own = recording.bodies[recording.bodies.parent == ball["body"]]
        direct = {each["cullet_body"] for each in pieces.objects}
        self.assertEqual(direct, set(own.body.tolist()))
        made = {each["cullet_body"]: each["cullet_made"] for each in pieces.objects}
        self.assertEqual(made, dict(zip(own.body.tolist(), map(str, own.made), strict=True)))
        for each in pieces.objects:
            mesh = recording.mesh(each["cullet_body"])
            self.assertEqual(len(each.data.polygons), len(mesh.triangles))
            cracks = sum(face.material_index == 1 for face in each.data.polygons)
            self.assertEqual(cracks, int(mesh.crack.sum()))
            ends = {tuple(round(x, 6) for x in vertex.co) for vertex in each.data.vertices}
            self.assertEqual(ends, {tuple(round(float(x), 6) for x in np.float32(v)) for v in mesh.vertices})

    def test_a_body_is_hidden_before_its_birth_and_after_its_end(self):
        recording = self.run_of()
        import_run(bpy.context, recording)
        ball = next(each for each in self.scene.objects if each.get("cullet_body") == recording.body("ball")["body"])
        broke = recording.body("ball")["end_step"] * recording.step * 24
        for frame in range(13):
            self.scene.frame_set(frame)
            self.assertEqual(ball.hide_viewport, frame >= broke - 1e-6, f"frame {frame}, broke at {broke}")
            self.assertEqual(ball.hide_render, ball.hide_viewport)

    def test_a_sheet_has_the_shape_of_each_frame(self):
        build = cullet.SceneBuilder("flag", world={"duration": 0.25})
        build.add_material("paper", density=300, young="50 MPa", poisson=0.333, strength="2 MPa", fracture_energy=800)
        build.add_sheet(
            "flag", size=[0.1, 0.1], thickness="0.15 mm", spacing="10 mm", position=[0, 0, 1], material="paper",
            grip=[{"patch": {"centre": [-0.05, -0.05], "radius": 0.012}}],
        )
        recording = cullet.run(build.scene(), folder(), workers=1, progress=False)
        import_run(bpy.context, recording)
        sheet = recording.sheet("flag")
        made = next(each for each in self.scene.objects if each.get("cullet_sheet") == sheet.number)
        moved = 0.0
        for step in sheet.steps[:: max(1, len(sheet.steps) // 6)]:
            moment = sheet.at(step=int(step))
            frame = moment.time * 24
            self.scene.frame_set(int(frame), subframe=frame % 1)
            shape = made.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
            places = np.empty(3 * len(shape.vertices), dtype=np.float32)
            shape.vertices.foreach_get("co", places)
            off = np.abs(places.reshape(-1, 3) - moment.vertices).max()
            self.assertLess(off, 2e-4, f"{moment.time} s")
            moved = max(moved, np.abs(moment.vertices - sheet.at(0.0).vertices).max())
        self.assertGreater(moved, 0.02)


class Submit(unittest.TestCase):
    def setUp(self):
        self.scene = empty()
        bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, -0.5))
        self.floor = bpy.context.active_object
        self.floor.name, self.floor.scale = "floor", (4, 4, 1)
        self.floor.cullet.material, self.floor.cullet.fixed = "granite", True
        bpy.ops.mesh.primitive_ico_sphere_add(radius=1, subdivisions=3, location=(0, 0, 0.2), rotation=(0.3, 0.2, 0.1))
        self.ball = bpy.context.active_object
        # A mirror: faces would be inside out.
        self.ball.name, self.ball.scale = "ball", (0.06, -0.06, 0.06)
        self.ball.cullet.material, self.ball.cullet.velocity = "plaster", (0, 0, -20)
        self.scene.cullet.duration, self.scene.cullet.points = 0.1, 4000
        self.floor.select_set(True)
        self.ball.select_set(True)

    def test_the_selected_objects_are_a_scene(self):
        scene = scene_of(bpy.context)
        self.assertEqual(scene.check(), [])
        self.assertEqual(list(scene.bodies.name), ["ball", "floor"])
        self.assertEqual(list(scene.bodies.fixed), [False, True])
        self.assertAlmostEqual(scene.bodies.volume[1], 16, places=4)
        self.assertAlmostEqual(scene.bodies.volume[0] / (4 / 3 * np.pi * 0.06**3), 1, delta=0.04)
        np.testing.assert_allclose(scene.bodies.position[0], [0, 0, 0.2], atol=1e-6)
        self.ball.select_set(False)
        self.assertEqual(list(scene_of(bpy.context).bodies.name), ["floor"])

    def test_a_run_goes_to_a_farm_and_comes_back(self):
        with socket.socket() as link:
            link.bind(("127.0.0.1", 0))
            port = link.getsockname()[1]
        endpoint = self.scene.cullet.endpoint = f"tcp/127.0.0.1:{port}"
        call = [str(cullet.program()), "coordinator", "--listen", endpoint, "--workers", "1", "--out", str(folder())]
        farm = subprocess.Popen(call, stderr=subprocess.DEVNULL)
        try:
            cullet.Client(endpoint, patience=30).about()
            self.assertEqual(bpy.ops.cullet.submit(), {"FINISHED"})
            self.assertGreater(self.scene.cullet.run, 0)
            self.scene.cullet.folder = str(folder())
            since = time.monotonic()
            while bpy.ops.cullet.fetch() != {"FINISHED"}:
                self.assertLess(time.monotonic() - since, 120)
                time.sleep(0.2)
        finally:
            farm.terminate()
            farm.wait(30)
        self.assertEqual(self.scene.cullet.state, "done")
        made = [each for each in self.scene.objects if "cullet_body" in each]
        self.assertGreater(len(made), 3)
        # A second time from the file.
        path = next(Path(bpy.path.abspath(self.scene.cullet.folder)).glob("run-*/run.mcap"))
        before = len(self.scene.objects)
        self.assertEqual(bpy.ops.cullet.import_run(filepath=str(path)), {"FINISHED"})
        self.assertEqual(len(self.scene.objects), before + len(made))

    def test_what_is_wrong_is_told(self):
        self.ball.location = (0, 0, 0)
        with self.assertRaisesRegex(RuntimeError, "ball"):
            bpy.ops.cullet.submit()


if __name__ == "__main__":
    cullet_blender.register()
    unittest.main()
