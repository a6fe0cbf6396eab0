"""A farm on this machine, and a client of it."""

import json
import shutil
import socket
import subprocess
import time
import unittest

import cullet
from common import DROP, ROOT, drop, folder


def free_port() -> int:
    with socket.socket() as link:
        link.bind(("127.0.0.1", 0))
        return int(link.getsockname()[1])


class Farm(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.endpoint = f"tcp/127.0.0.1:{free_port()}"
        call = [cullet.program(), "coordinator", "--listen", cls.endpoint, "--workers", "1", "--out", str(folder())]
        cls.farm = subprocess.Popen([str(word) for word in call], cwd=folder(), stderr=subprocess.DEVNULL)
        cls.client = cullet.Client(cls.endpoint, patience=30)

    @classmethod
    def tearDownClass(cls) -> None:
        cls.farm.terminate()
        cls.farm.wait(30)

    def test_a_scene_is_submitted_watched_and_fetched(self) -> None:
        run = self.client.submit(cullet.Scene.from_text(DROP, name="drop"))
        told = list(self.client.watch(run))
        self.assertEqual(told[-1].state, "done")
        lines = [line for progress in told for line in progress.lines]
        self.assertTrue(any("ball" in line for line in lines), lines)
        self.assertEqual(lines, json.loads(self.client._inner.news(run, 0))["lines"])
        recording = self.client.fetch(run, folder() / "fetched")
        self.assertEqual(recording.digest, drop().digest)
        self.assertIn(run, [info.run for info in self.client.runs()])
        self.client.delete(run)
        with self.assertRaises(cullet.ClientError):
            self.client.run(run)

    def test_a_run_is_cancelled(self) -> None:
        run = self.client.submit(cullet.Scene.from_text(DROP).set("world.duration", 600))
        with self.assertRaises(cullet.ClientError):
            self.client.fetch(run)
        self.client.cancel(run)
        self.assertEqual(self.client.wait(run, progress=False).state, "cancelled")

    def test_one_ticket_is_one_run(self) -> None:
        scene = cullet.Scene.from_text(DROP)
        runs = {self.client.submit(scene, ticket="once") for _ in range(2)}
        self.assertEqual(len(runs), 1)

    def test_a_sweep_comes_back_in_order(self) -> None:
        place = folder()
        scene = ROOT / "tests" / "corpus" / "ball.toml"
        lines = [f'scene = "{scene}"', 'set = ["fracture.solver=geometric"]', "[product]", '"world.seed" = [4, 5]']
        (place / "seeds.toml").write_text("\n".join(lines))
        sweep = self.client.sweep(place / "seeds.toml", place / "out", progress=False)
        self.assertEqual(list(sweep.table["world.seed"]), [4, 5])
        self.assertEqual([run.state for run in sweep], ["done", "done"])
        seeds = [json.loads((place / "out" / n / "summary.json").read_text())["seed"] for n in "12"]
        self.assertEqual(seeds, [4, 5])

    def test_silence_is_told_in_time(self) -> None:
        since = time.monotonic()
        with self.assertRaises(cullet.ClientError) as caught:
            cullet.Client(f"tcp/127.0.0.1:{free_port()}", patience=1).runs()
        self.assertIn("127.0.0.1", str(caught.exception))
        self.assertLess(time.monotonic() - since, 20)
        with self.assertRaises(cullet.ClientError):
            cullet.Client("tls/127.0.0.1:7447")

    def test_with_certificates_on_both_sides(self) -> None:
        if shutil.which("openssl") is None:
            self.skipTest("there is no openssl")
        place, endpoint = folder(), f"tls/127.0.0.1:{free_port()}"
        names = ["coordinator", "ada"]
        subprocess.run(["sh", ROOT / "deploy" / "certs.sh", place, *names], check=True, capture_output=True)
        (place / "roles.toml").write_text('workers = []\nusers = ["ada"]\noperators = []\n')
        call = [cullet.program(), "coordinator", "--listen", endpoint, "--out", folder()]
        call += ["--tls", place / "coordinator", "--roles", place / "roles.toml"]
        farm = subprocess.Popen([str(word) for word in call], cwd=folder(), stderr=subprocess.DEVNULL)
        try:
            client = cullet.Client(endpoint, tls=place / "ada", user="ada", patience=30)
            run = client.submit(cullet.Scene.from_text(DROP))
            self.assertEqual(client.run(run).user, "ada")
            # Nobody works there.
            client.cancel(run)
            self.assertEqual(client.wait(run, progress=False).state, "cancelled")
        finally:
            farm.terminate()
            farm.wait(30)


if __name__ == "__main__":
    unittest.main()
