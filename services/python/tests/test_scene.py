"""Scenes from files, text and arrays; everything that is wrong is told with its place."""

import unittest

import cullet
import numpy as np
from common import DROP, ROOT, folder


def cube(edge: float) -> tuple[np.ndarray, np.ndarray]:
    """A cube about the origin, of 8 corners and 12 triangles."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) - 0.5
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = [[f[0], f[i], f[i + 1]] for f in faces for i in (1, 2)]
    return edge * corners, np.array(triangles, dtype=np.uint32)


class Scenes(unittest.TestCase):
    def test_a_scene_is_loaded_with_what_is_set(self) -> None:
        scene = cullet.Scene.load(ROOT / "scenes" / "pot", set={"world.seed": 7})
        self.assertEqual((scene.name, scene.seed, scene.duration), ("pot", 7, 1.5))
        self.assertEqual(list(scene.bodies.name), ["floor", "pot"])
        self.assertEqual(list(scene.bodies.fixed), [True, False])
        self.assertEqual(scene.bodies.position.shape, (2, 3))
        np.testing.assert_allclose(scene.bodies.velocity[1], [0.3, 0, -6.2])
        self.assertEqual(scene.overrides, ["world.seed=7"])
        self.assertEqual(cullet.Scene.load(str(ROOT / "scenes/pot"), set=["world.seed=8"]).seed, 8)

    def test_set_makes_another_scene(self) -> None:
        scene = cullet.Scene.from_text(DROP)
        other = scene.set("world.seed", 11).set({"body.ball.velocity": np.array([0, 0, -2.5]), "world.duration": "10 ms"})
        self.assertEqual((scene.seed, other.seed, other.duration), (3, 11, 0.01))
        np.testing.assert_array_equal(other.bodies.velocity[1], [0, 0, -2.5])

    def test_all_errors_come_with_their_places(self) -> None:
        with self.assertRaises(cullet.SceneError) as caught:
            cullet.Scene.from_text('[world]\nduration = -1\nseeed = 2\n[[body]]\nname = "a"\nmaterial = "gold"\n')
        places = {place.path: place for place in caught.exception.places}
        self.assertGreaterEqual(len(places), 3)
        self.assertEqual((places["world.duration"].line, places["world.duration"].column), (2, 12))
        self.assertIn("seed", places["world.seeed"].help or "")
        self.assertIn("world.duration", str(caught.exception))
        with self.assertRaises(cullet.SceneError) as caught:
            cullet.Scene.load(folder() / "nothing.toml")
        self.assertIn("nothing.toml", str(caught.exception))
        with self.assertRaises(cullet.SceneError):
            cullet.Scene.from_text(DROP).set("world.seed", -1)

    def test_a_mesh_of_arrays_is_the_body_to_the_bit(self) -> None:
        build = cullet.SceneBuilder("cube", "A cube of arrays", world={"duration": 0.01})
        build.add_material("mine", preset="plaster", density=1000.0)
        build.add_body("cube", mesh=cube(0.1), material="mine", position=[0, 0, 1], repair="refuse")
        scene = build.scene()
        self.assertEqual(scene.description, "A cube of arrays")
        self.assertEqual(scene.bodies.triangles[0], 12)
        self.assertAlmostEqual(scene.bodies.volume[0], 1e-3, delta=1e-15)
        self.assertAlmostEqual(scene.bodies.mass[0], 1.0, delta=1e-12)
        recording = cullet.run(scene, folder(), kind="threads", workers=1, progress=False)
        born = recording.mesh("cube").vertices + recording.poses(0.0).position[0]
        np.testing.assert_allclose(np.sort(born, axis=0), np.sort(cube(0.1)[0] + [0, 0, 1], axis=0), atol=1e-15)
        # Inside out, and not repaired, for it was asked so.
        vertices, triangles = cube(0.1)
        build = cullet.SceneBuilder("cube").add_body("cube", mesh=(vertices, triangles[:-1]), material="plaster", repair="refuse")
        with self.assertRaises(cullet.SceneError):
            build.scene()

    def test_arrays_that_are_no_mesh_are_refused(self) -> None:
        vertices, triangles = cube(1.0)
        bad = [
            (vertices[:, :2], triangles),
            (vertices, triangles[:, :2]),
            (vertices, triangles.astype(float)),
            (vertices, triangles + 1),
            (np.full_like(vertices, np.nan), triangles),
        ]
        for mesh in bad:
            with self.assertRaises(ValueError):
                cullet.ply(*mesh)

    def test_text_may_name_files_of_a_folder_or_given_ones_only(self) -> None:
        text = 'world = { duration = 0.01 }\n[[body]]\nname = "a"\nmesh = "cube.ply"\nmaterial = "ice"\n'
        place = folder()
        (place / "cube.ply").write_bytes(cullet.ply(*cube(0.2)))
        for scene in (
            cullet.Scene.from_text(text, folder=place),
            cullet.Scene.from_text(text, files={"cube.ply": cullet.ply(*cube(0.2))}),
        ):
            self.assertAlmostEqual(scene.bodies.volume[0], 8e-3, delta=1e-15)
        with self.assertRaises(cullet.SceneError) as caught:
            cullet.Scene.from_text(text)
        self.assertIn("cube.ply", str(caught.exception))

    def test_values_are_written_as_toml_reads_them(self) -> None:
        import tomllib

        from cullet._values import toml

        values = [True, 3, -2.5, 1e-300, 'a "b" \\ \n \x7f é', [1, [2.5, "x"]], {"a": 1, "b c": {"d": []}}]
        for value in [*values, np.float64(0.1), np.arange(3)]:
            read = tomllib.loads(f"value = {toml(value)}")["value"]
            due = value.tolist() if hasattr(value, "tolist") else value
            self.assertEqual((read, type(read)), (due, type(due)))
        for bad in (float("nan"), float("inf"), object()):
            with self.assertRaises((ValueError, TypeError)):
                toml(bad)

    def test_presets_and_the_schema_are_listed(self) -> None:
        self.assertIn("plaster", cullet.materials())
        self.assertIn("body", cullet.schema()["properties"])


if __name__ == "__main__":
    unittest.main()
