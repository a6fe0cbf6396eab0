"""A farm on this machine, and a client of it."""

import json
import shutil
import signal
import socket
import subprocess
import sys
import textwrap
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

    def test_a_folder_with_another_run_is_refused(self) -> None:
        place = folder()
        run = self.client.submit(cullet.Scene.from_text(DROP))
        self.client.wait(run, progress=False)
        self.client.fetch(run, place)
        before = (place / "summary.json").read_bytes()
        other = self.client.submit(cullet.Scene.from_text(DROP).set("world.seed", 8))
        self.client.wait(other, progress=False)
        with self.assertRaisesRegex(cullet.ClientError, "there is a run in this folder"):
            self.client.fetch(other, place)
        self.assertEqual((place / "summary.json").read_bytes(), before)
        runs = len(self.client.runs())
        with self.assertRaisesRegex(cullet.RunError, "there is a run in this folder"):
            self.client.sweep(ROOT / "tests" / "corpus" / "nothing.toml", place)
        self.assertEqual(len(self.client.runs()), runs)
        # A fetch that was broken off goes on.
        again = folder()
        (again / "run.mcap.partial").write_bytes(b"begun")
        with self.assertRaises(cullet.ClientError):
            self.client.fetch(other, again)
        (again / ".cullet-fetch").write_text("")
        self.assertEqual(self.client.fetch(other, again).path, again / "run.mcap")
        self.assertEqual(json.loads((again / "summary.json").read_text())["seed"], 8)

    def test_a_sweep_that_breaks_off_names_its_runs(self) -> None:
        place = folder()
        scene = ROOT / "tests" / "corpus" / "ball.toml"
        lines = [f'scene = "{scene}"', 'set = ["fracture.solver=geometric"]', "[product]", '"world.seed" = [6, 7]']
        (place / "seeds.toml").write_text("\n".join(lines))

        def stop(_: cullet.Progress) -> None:
            raise RuntimeError("enough")

        with self.assertRaisesRegex(RuntimeError, "enough") as caught:
            self.client.sweep(place / "seeds.toml", place / "out", progress=stop)
        runs = [info.run for info in self.client.runs() if info.sweep == "seeds"][-2:]
        self.assertEqual(
            caught.exception.__notes__, [f"runs of the sweep seeds that were handed in: {runs[0]}, {runs[1]}"]
        )

    def test_a_full_queue_is_waited_for_until_control_c(self) -> None:
        place, endpoint = folder(), f"tcp/127.0.0.1:{free_port()}"
        code = textwrap.dedent(f"""
            import math, signal, cullet
            # Where the tests run in the background, Ctrl-C is ignored.
            signal.signal(signal.SIGINT, signal.default_int_handler)
            client = cullet.Client({endpoint!r}, patience=30)
            scene = cullet.Scene.from_text({DROP!r})
            try:
                for _ in range(100_000):
                    print(client.submit(scene, room=0.1), flush=True)
            except cullet.ClientError as error:
                print("full", flush=True)
            client.submit(scene, room=math.inf)
        """)
        # Nobody works there, so the queue fills up.
        call = [cullet.program(), "coordinator", "--listen", endpoint, "--out", str(place)]
        farm = subprocess.Popen([str(word) for word in call], cwd=folder(), stderr=subprocess.DEVNULL)
        child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        try:
            assert child.stdout is not None
            while child.stdout.readline() not in ("full\n", ""):
                pass
            time.sleep(1.5)
            self.assertIsNone(child.poll(), "it waits")
            since = time.monotonic()
            child.send_signal(signal.SIGINT)
            _, errors = child.communicate(timeout=60)
            self.assertLess(time.monotonic() - since, 10)
            self.assertIn("KeyboardInterrupt", errors)
        finally:
            farm.terminate()
            farm.wait(30)

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
