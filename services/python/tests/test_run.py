"""Runs on this machine: the same bits as the program, progress, a clean end when asked."""

import json
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
import unittest
from collections.abc import Callable
from importlib.metadata import files
from pathlib import Path
from unittest import mock

import cullet
from common import DROP, drop, folder, solved
from cullet._progress import _Notebook


class Runs(unittest.TestCase):
    def test_the_program_of_the_wheel_gives_the_same_digest(self) -> None:
        place = folder()
        (place / "drop.toml").write_text(DROP)
        said = subprocess.run([cullet.program(), "--version"], capture_output=True, text=True, check=True)
        self.assertEqual(said.stdout.split()[:2], ["cullet", cullet.__version__])
        call = [cullet.program(), "run", "drop.toml", "--out", "out", "-q", "--no-pictures", "--workers", "1"]
        subprocess.run(call, cwd=place, check=True)
        summary = json.loads((place / "out" / "summary.json").read_text())
        self.assertEqual(drop().digest, summary["digest"])
        self.assertGreater(drop().summary["fragments"], 10)

    def test_threads_and_processes_give_the_same_digest(self) -> None:
        with cullet.LocalPool(workers=3, kind="threads") as pool:
            for _ in range(2):
                again = pool.run(cullet.Scene.from_text(DROP, name="drop"), folder(), progress=False)
                self.assertEqual(again.digest, drop().digest)
        with self.assertRaises(ValueError):
            pool.run(cullet.Scene.from_text(DROP), folder())

    def test_a_forked_process_is_told_that_the_pool_is_not_its_own(self) -> None:
        scene = cullet.Scene.from_text(DROP, name="drop")
        with cullet.LocalPool(workers=1, kind="threads") as pool:
            child = os.fork()
            if child == 0:
                told = 0
                for call in (lambda: pool.run(scene, folder()), lambda: cullet.LocalPool(workers=1), pool.close):
                    try:
                        call()
                    except RuntimeError as error:
                        told += "forked" in str(error)
                os._exit(told)
            ended, status, end = 0, 0, time.monotonic() + 60
            while ended == 0 and time.monotonic() < end:
                time.sleep(0.1)
                ended, status = os.waitpid(child, os.WNOHANG)
            if ended == 0:
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
            self.assertEqual((ended, os.waitstatus_to_exitcode(status)), (child, 3))
            self.assertEqual(pool.run(scene, folder(), progress=False).digest, drop().digest)

    def test_a_run_takes_up_an_earlier_one(self) -> None:
        scene = cullet.Scene.from_text(DROP, name="drop")
        one = {"workers": 1, "kind": "threads", "progress": False}
        first = cullet.run(scene, folder(), **one)
        again = cullet.run(scene, folder(), from_run=first, from_step=2, **one)
        jobs = [run.summary["jobs"] for run in (first, again)]
        self.assertEqual((again.digest, jobs[1]["taken"]), (first.digest, jobs[0]["solved"]))
        self.assertGreater(jobs[0]["solved"], 0)
        self.assertEqual((jobs[0]["taken"], jobs[1]["solved"]), (0, 0))
        hit = cullet.run(scene, folder(), set={"hit.ball.seed": 5}, from_run=first.path, results=0, **one)
        self.assertEqual(hit.summary["directed"]["hits"], 1)
        self.assertNotEqual(hit.digest, first.digest)
        place = folder()
        with self.assertRaisesRegex(cullet.RunError, "the run is not as in"):
            cullet.run(scene, place / "out", set={"world.gravity": [0, 0, -1]}, from_run=first, from_step=9, **one)
        self.assertEqual(list((place / "out").iterdir()), [])
        with self.assertRaisesRegex(ValueError, "give from_run"):
            cullet.run(scene, folder(), from_step=2, **one)

    def test_progress_is_told_to_whoever_listens(self) -> None:
        told: list[cullet.Progress] = []
        scene = cullet.Scene.from_text(DROP)
        recording = cullet.run(scene, folder(), kind="threads", workers=1, progress=told.append)
        # The last step that fits is the last that is told.
        self.assertEqual(told[-1].time, recording.duration)
        self.assertEqual([at.time for at in told], sorted(at.time for at in told))
        self.assertTrue(any("ball" in line for line in recording.log), recording.log)

    def test_what_a_listener_raises_ends_the_run(self) -> None:
        scene = cullet.Scene.from_text(DROP).set("world.duration", 60)
        place = folder()

        def refuse(at: cullet.Progress) -> None:
            if at.time > 0.1:
                raise RuntimeError("enough")

        with self.assertRaisesRegex(RuntimeError, "enough"):
            cullet.run(scene, place, kind="threads", workers=1, progress=refuse)
        self.assertLess(cullet.Recording(place).duration, 59)

    def test_who_listens_can_neither_close_the_pool_nor_run_on_it(self) -> None:
        scene = cullet.Scene.from_text(DROP)
        pool = cullet.LocalPool(workers=1, kind="threads")
        for act in (pool.close, lambda: pool.run(scene, folder(), progress=False)):

            def listen(_: cullet.Progress, act: Callable[[], object] = act) -> None:
                act()

            with self.assertRaisesRegex(cullet.RunError, "the pool is in a run"):
                pool.run(scene, folder(), progress=listen)
        # And it is of use afterwards.
        self.assertTrue(pool.run(scene, folder(), progress=False).complete)
        pool.close()

    def test_names_stand_in_a_notebook_as_text(self) -> None:
        class Handle:
            def update(self, page: str) -> None:
                pages.append(page)

        def display(page: str, display_id: bool) -> Handle:
            pages.append(page)
            return Handle()

        pages: list[str] = []
        name = "<img src=x onerror=alert(1)>"
        bar = _Notebook(name, display, str)
        bar.show(cullet.Progress(time=0, end=1, bodies=1, fractures=0, jobs=0, state=name))
        self.assertEqual([page.count("&lt;img src=x") for page in pages], [1, 2])
        for page in pages:
            self.assertNotIn("<img", page)
            self.assertIn("<progress value=", page)

    def test_the_program_is_the_one_that_the_wheel_lists(self) -> None:
        listed = [Path(str(file.locate())).resolve() for file in files("cullet-sim") or [] if file.name == "cullet"]
        self.assertEqual([cullet.program().resolve()], listed)
        stranger = folder() / "cullet"
        stranger.write_text("#!/bin/sh\n")
        stranger.chmod(0o755)
        with mock.patch("sysconfig.get_path", return_value=str(stranger.parent)):
            self.assertEqual([cullet.program().resolve()], listed)
            with mock.patch("cullet._program.files", return_value=[]):
                self.assertEqual(cullet.program(), stranger)

    def test_control_c_finishes_the_recording_first(self) -> None:
        place = folder()
        code = textwrap.dedent(f"""
            import signal, cullet
            # Where the tests run in the background, Ctrl-C is ignored.
            signal.signal(signal.SIGINT, signal.default_int_handler)
            scene = cullet.Scene.from_text({DROP!r}).set("world.duration", 600)
            cullet.run(scene, {str(place)!r}, workers=1, progress=lambda at: print(at.time, flush=True))
        """)
        child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert child.stdout is not None
        child.stdout.readline()
        since = time.monotonic()
        child.send_signal(signal.SIGINT)
        _, errors = child.communicate(timeout=60)
        self.assertLess(time.monotonic() - since, 30)
        self.assertIn("KeyboardInterrupt", errors)
        recording = cullet.Recording(place)
        self.assertTrue(recording.complete)
        self.assertFalse((place / "run.mcap.partial").exists())

    def test_other_threads_of_python_go_on_meanwhile(self) -> None:
        ticks, done = [0], threading.Event()

        def tick() -> None:
            while not done.is_set():
                ticks[0] += 1
                time.sleep(0.001)

        thread = threading.Thread(target=tick)
        thread.start()
        scene = cullet.Scene.from_text(DROP).set("world.duration", 1)
        since = time.monotonic()
        cullet.run(scene, folder(), kind="threads", workers=1, progress=False)
        passed = time.monotonic() - since
        done.set()
        thread.join()
        self.assertGreater(ticks[0], 20 * passed)

    def test_a_folder_with_a_run_is_refused_and_a_new_one_is_found(self) -> None:
        with self.assertRaises(cullet.RunError):
            cullet.run(cullet.Scene.from_text(DROP), drop().folder)
        before = os.getcwd()
        os.chdir(folder())
        try:
            runs = [cullet.run(cullet.Scene.from_text(DROP, name="x"), kind="threads", progress=False) for _ in range(2)]
        finally:
            os.chdir(before)
        self.assertEqual([run.folder.name for run in runs], ["x-1", "x-2"])

    def test_a_sweep_runs_every_combination(self) -> None:
        scene = cullet.Scene.from_text(DROP)
        values = {"world.seed": [1, 2], "body.ball.velocity": [[0, 0, -1], [0, 0, -20]]}
        sweep = cullet.sweep(scene, values, out=folder(), kind="threads", workers=1, progress=False)
        self.assertEqual(len(sweep), 4)
        table = sweep.table
        self.assertEqual(list(table["world.seed"]), [1, 1, 2, 2])
        self.assertEqual(table["body.ball.velocity"].shape, (4, 3))
        self.assertTrue(all(table.fragments[[0, 2]] < table.fragments[[1, 3]]), table)
        with self.assertRaises(cullet.SceneError):
            cullet.sweep(scene, {"world.seed": [1, -1]}, out=folder())

    def test_solved_and_sampled_are_told_apart(self) -> None:
        made = set(drop().bodies.made)
        self.assertEqual(made, {"given", "sampled"})
        bodies = solved().bodies
        fragments = bodies[bodies.parent >= 0]
        self.assertIn("solved", set(fragments.made))
        shares = solved().summary["shares"]
        last = fragments[fragments.end_step < 0]
        self.assertEqual((last.made == "sampled").sum(), shares["sampled_pieces"])


if __name__ == "__main__":
    unittest.main()
