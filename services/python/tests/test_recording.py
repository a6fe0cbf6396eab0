"""Recordings as arrays, held to what a reader that this project did not write finds, and to conservation."""

import json
import unittest

import cullet
import numpy as np
from common import drop, folder, solved


class Recordings(unittest.TestCase):
    def test_fragments_make_up_the_body(self) -> None:
        for recording in (drop(), solved()):
            bodies = recording.bodies
            ball = recording.body("ball")
            self.assertEqual(ball["made"], "given")
            parts = bodies[bodies.parent == ball["body"]]
            self.assertGreater(len(parts), 1)
            event = next(event for event in recording.fractures if event["body"] == ball["body"])
            self.assertEqual(sorted(event["fragments"]), sorted(parts.body))
            mass = parts.mass.sum() + event["grain_mass"]
            self.assertAlmostEqual(mass, ball["mass"], delta=1e-9 * ball["mass"])
            self.assertEqual(set(parts.birth_step), {ball["end_step"]})
            sampled = event["solved_volume"] + event["sampled_volume"]
            self.assertAlmostEqual(sampled, ball["volume"], delta=1e-6 * ball["volume"])

    def test_meshes_are_closed_and_have_the_volume_of_their_body(self) -> None:
        recording = solved()
        for row in recording.bodies:
            mesh = recording.mesh(int(row["body"]))
            self.assertAlmostEqual(mesh.volume, row["volume"], delta=1e-9 * row["volume"])
            edges = np.concatenate([mesh.triangles[:, [i, (i + 1) % 3]] for i in range(3)])
            there = {tuple(edge) for edge in edges.tolist()}
            self.assertEqual(there, {(b, a) for a, b in there})
            self.assertEqual(mesh.damage_time.shape, (len(mesh.triangles), 3))
            self.assertTrue((np.isnan(mesh.damage_time).all(axis=1) == ~mesh.crack).all())
            self.assertEqual(mesh.crack.any(), row["parent"] >= 0)
        with self.assertRaises(KeyError):
            recording.mesh(10**6)

    def test_poses_are_where_bodies_are(self) -> None:
        recording = drop()
        ball = recording.body("ball")
        track = recording.track("ball")
        self.assertEqual(track.position.shape, (len(track), 3))
        # It falls freely until it hits the floor.
        step = recording.step
        np.testing.assert_allclose(track.velocity[:3, 2], -8 - 9.81 * step * np.arange(3), atol=1e-9)
        fallen = track.position[2, 2] - track.position[0, 2]
        self.assertAlmostEqual(fallen, -8 * 2 * step - 0.5 * 9.81 * (2 * step) ** 2, delta=9.81 * step**2)
        np.testing.assert_allclose(np.linalg.norm(recording.pose_rows.rotation, axis=1), 1, atol=1e-12)
        before = recording.poses(step=ball["end_step"] - 1)
        after = recording.poses(step=ball["end_step"])
        self.assertIn(ball["body"], before.body)
        self.assertNotIn(ball["body"], after.body)
        self.assertEqual(len(after), len(before) - 1 + (recording.bodies.parent == ball["body"]).sum())
        np.testing.assert_array_equal(after.body, recording.poses(ball["end_step"] * step).body)
        np.testing.assert_array_equal(recording.poses().body, recording.poses(1e9).body)
        last = recording.poses()
        for number in (int(last.body[0]), int(last.body[-1])):
            row = recording.track(number)[-1]
            np.testing.assert_array_equal(last.position[last.body == number][0], row["position"])
        for bad in ({"time": -1}, {"step": -1}, {"time": 0.1, "step": 2}):
            with self.assertRaises(ValueError):
                recording.poses(**bad)

    def test_arrays_are_those_of_the_file(self) -> None:
        try:
            from mcap.reader import make_reader
            from mcap_protobuf.decoder import DecoderFactory
        except ImportError:
            self.skipTest("there is no mcap-protobuf-support")
        recording = solved()
        steps, rows, grains = [], {}, {}
        with open(recording.path, "rb") as file:
            reader = make_reader(file, decoder_factories=[DecoderFactory()])
            for _, channel, _, message in reader.iter_decoded_messages(topics=["/bodies", "/debris", "/events"]):
                if channel.topic == "/bodies":
                    steps += [message.step] * len(message.ids)
                    for i, body in enumerate(message.ids):
                        rows.setdefault(body, []).append(list(message.positions[3 * i : 3 * i + 3]))
                elif channel.topic == "/debris":
                    for grain, mass in zip(message.ids, message.masses, strict=False):
                        grains.setdefault(grain, mass)
        self.assertEqual(list(recording.pose_rows.step), steps)
        for body, positions in rows.items():
            np.testing.assert_array_equal(recording.track(body).position, positions)
        self.assertEqual(dict(zip(*(recording.grains()[c].tolist() for c in ("grain", "mass")), strict=True)), grains)
        self.assertEqual(len(grains), recording.summary["grains"])

    def test_grains_have_the_mass_that_the_fractures_say(self) -> None:
        recording = solved()
        grains = recording.grains()
        mass = sum(event["grain_mass"] for event in recording.fractures)
        self.assertAlmostEqual(grains.mass.sum(), mass, delta=1e-9 * max(mass, 1e-9))
        self.assertEqual(len(recording.grains(0.0)), 0)
        self.assertEqual(grains.position.shape, (len(grains), 3))

    def test_energy_is_what_the_ledger_says(self) -> None:
        recording = solved()
        energy = recording.energy
        total = sum(event["ledger"]["fracture_energy"] for event in recording.fractures)
        self.assertAlmostEqual(energy.fracture[-1], total)
        self.assertEqual(energy.fracture[0], 0)
        ball = recording.body("ball")
        self.assertAlmostEqual(energy.translational[0], 0.5 * ball["mass"] * 10**2, delta=1e-3 * ball["mass"] * 50)
        self.assertEqual(energy.bodies[-1], recording.summary["bodies_final"])
        # Of those that are there, and of no others.
        mass = {int(b): 0.0 if fixed else m for b, m, fixed in zip(*(recording.bodies[c] for c in ("body", "mass", "fixed")))}
        for row in (ball["end_step"] - 1, ball["end_step"], -1):
            there = recording.poses(step=int(energy.step[row]))
            speeds = (there.velocity**2).sum(axis=1)
            due = sum(0.5 * mass[int(b)] * v for b, v in zip(there.body, speeds, strict=True))
            self.assertAlmostEqual(energy.translational[row], due, delta=1e-12 * max(due, 1))

    def test_reports_and_events_have_what_happened(self) -> None:
        recording = solved()
        report = recording.reports[0]
        self.assertEqual((report["solver"], report["verdict"]), ("brittle", "broken"))
        self.assertGreater(report["particles"], 1000)
        hit = report["hits"][0]
        self.assertAlmostEqual(np.linalg.norm(hit["normal"]), 1, places=9)
        impact = next(event for event in recording.events if event["kind"] == "impact")
        self.assertGreater(impact["peak_force"], 0)
        self.assertEqual(recording.events[-1]["kind"], "finished")
        summary = json.loads((recording.folder / "summary.json").read_text())
        self.assertEqual({**recording.summary, "wall_seconds": 0}, {**summary, "wall_seconds": 0})

    def test_rest_places_put_the_object_together(self) -> None:
        recording = drop()
        rest, bodies = recording.rest, recording.bodies
        ball = recording.body("ball")["body"]
        parts = rest[(rest.root == ball) & (rest.body != ball)]
        mass = {int(b): m for b, m in zip(bodies.body, bodies.mass, strict=True)}
        weights = np.array([mass[int(b)] for b in parts.body])
        centre = (parts.origin * weights[:, None]).sum(axis=0) / weights.sum()
        self.assertLess(np.abs(centre).max(), 2e-2)

    def test_stills_and_exports_are_files(self) -> None:
        recording, place = drop(), folder()
        self.assertTrue(recording.still(size=(320, 180)).startswith(b"\x89PNG"))
        self.assertAlmostEqual(recording.still(0.03, place / "a.png", size=(320, 180)), 0.03, delta=recording.step)
        report = recording.export(place / "a.glb")
        self.assertEqual(report["bodies"], len(recording.bodies))
        self.assertTrue((place / "a.glb").is_file())
        for bad in (lambda: recording.export(place / "a.abc"), lambda: recording.still(99.0)):
            with self.assertRaises(cullet.RecordingError):
                bad()

    def test_what_is_no_recording_is_refused(self) -> None:
        place = folder()
        (place / "run.mcap").write_bytes(b"no recording")
        with self.assertRaises(cullet.RecordingError):
            _ = cullet.Recording(place).bodies
        with self.assertRaises(cullet.RecordingError):
            cullet.Recording(place / "nothing.mcap")

    def test_attachments_are_bytes(self) -> None:
        self.assertIn(b"plaster ball", drop().attachment("scene.toml"))
        with self.assertRaises(KeyError):
            drop().attachment("nothing")

    def test_laws_are_fitted(self) -> None:
        # Masses at even quantiles of Mott's law with μ = 4 g.
        share = (np.arange(1000) + 0.5) / 1000
        fit = cullet.fit_masses(4e-3 * np.log(1 - share) ** 2)
        assert fit is not None
        self.assertAlmostEqual(fit.mott_mass, 4e-3, delta=4e-5)
        self.assertLess(fit.mott_distance, 0.01)
        self.assertGreater(fit.power_distance, 0.1)
        self.assertIsNone(cullet.fit_masses([1.0, 2.0]))


class Sheets(unittest.TestCase):
    def test_a_sheet_has_frames_and_windows(self) -> None:
        scene = cullet.SceneBuilder("flag", world={"duration": 0.05})
        scene.add_material("paper", density=300, young="50 MPa", poisson=0.333, strength="2 MPa", fracture_energy=800)
        scene.add_sheet(
            "flag", size=[0.1, 0.1], thickness="0.15 mm", spacing="10 mm", position=[0, 0, 1], material="paper"
        )
        recording = cullet.run(scene.scene(), folder(), workers=1, progress=False)
        sheet = recording.sheet("flag")
        self.assertGreater(len(sheet.times), 2)
        first, last = sheet.at(0.0), sheet.at()
        assert first is not None and last is not None
        self.assertEqual(first.vertices.shape, (len(first.reference), 3))
        self.assertLess(last.triangles.max(), len(last.vertices))
        # It falls.
        self.assertLess(last.vertices[:, 2].mean(), first.vertices[:, 2].mean() - 5e-3)
        ledgers = [window["ledger"] for window in sheet.windows]
        self.assertGreater(len(ledgers), 0)
        self.assertAlmostEqual(sum(w["steps"] for w in sheet.windows), recording.steps)


if __name__ == "__main__":
    unittest.main()
