"""Runs on this machine."""

from __future__ import annotations

import itertools
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from . import _cullet
from ._errors import RunError
from ._program import program
from ._progress import Progress, Shown, Told
from ._recording import Recording
from ._scene import PathLike, Scene
from ._sweep import Sweep, SweepRun
from ._values import Settings, settings

RESULTS = 1024
"""Results of jobs that are kept beside a recording, at most [MiB]."""


def new_folder(name: str) -> Path:
    """A new folder ``runs/NAME-N`` for a run."""
    runs = Path("runs")
    runs.mkdir(exist_ok=True)
    number = 1
    while True:
        folder = runs / f"{name}-{number}"
        try:
            folder.mkdir()
            return folder
        except FileExistsError:
            number += 1


def refuse_taken(folder: PathLike) -> None:
    """Refuses a folder that holds a run or a sweep."""
    if _cullet.is_taken(os.fspath(folder)):
        raise RunError(f"{folder}: there is a run in this folder; name another")


def folder_for(out: PathLike | None, name: str) -> Path:
    """The folder for a run, which holds none yet."""
    if out is None:
        return new_folder(name)
    refuse_taken(out)
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


class LocalPool:
    """Workers on this machine that are kept for several runs; a context manager.

    Parameters
    ----------
    workers : int, optional
        Jobs solved at once; without it a worker for every core but one. The result is the same with any number.
    threads : int
        Threads that each job is solved with.
    kind : {"processes", "threads"}
        `processes` of the program `cullet`, as ``cullet run`` has them: a job that crashes or takes too much memory is
        tried again and harms nothing else. `threads` of this process start faster.

    Raises
    ------
    RunError
        The workers do not start.

    Examples
    --------
    >>> with LocalPool(workers=2) as pool:
    ...     runs = [pool.run(scene.set("world.seed", seed)) for seed in range(3)]
    """

    def __init__(
        self,
        workers: int | None = None,
        threads: int = 1,
        kind: Literal["processes", "threads"] = "processes",
    ) -> None:
        count = _cullet.spare_cores() if workers is None else workers
        for what, number in (("workers", count), ("threads", threads)):
            if not 1 <= number <= 256:
                raise ValueError(f"{what}: {number}; there are 1 to 256")
        if kind not in ("processes", "threads"):
            raise ValueError(f'kind: {kind!r}; it is "processes" or "threads"')
        path = str(program()) if kind == "processes" else None
        self._inner = _cullet.LocalPool(count, threads, path)

    def run(
        self,
        scene: Scene,
        out: PathLike | None = None,
        progress: Told = True,
        *,
        from_run: Recording | PathLike | None = None,
        from_step: int | None = None,
        results: int = RESULTS,
    ) -> Recording:
        """Runs a scene to its end; see `run`."""
        if from_step is not None and from_run is None:
            raise ValueError("from_step: it is a step of an earlier run; give from_run")
        if not 0 <= results <= 1 << 24:
            raise ValueError(f"results: {results}; there are 0 to {1 << 24} MiB")
        earlier = from_run.path if isinstance(from_run, Recording) else from_run
        again = (None if earlier is None else os.fspath(earlier), from_step, results << 20)
        folder = folder_for(out, scene.name)
        with Shown(scene.name, progress) as shown:

            def tell(said: dict[str, Any]) -> None:
                shown.show(Progress(**said))

            told = self._inner.run(scene._inner, str(folder), tell if shown.wanted else None, again)
        recording = Recording(told["recording"])
        recording.unmet = list(told["unmet"])
        recording.log = list(told["log"])
        return recording

    def sweep(
        self,
        scene: Scene,
        values: Mapping[str, Sequence[Any]],
        *,
        out: PathLike | None = None,
        progress: Told = True,
        from_run: Recording | PathLike | None = None,
    ) -> Sweep:
        """Runs a scene with every combination of values; see `sweep`."""
        return _sweep(self, scene, values, out, progress, from_run)

    def close(self) -> None:
        """Ends the workers, once the run of another thread is over.

        Raises
        ------
        RunError
            Who hears of the progress of a run closes its pool, or runs another scene on it.
        """
        self._inner.close()

    def __enter__(self) -> LocalPool:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def run(
    scene: Scene | PathLike,
    out: PathLike | None = None,
    *,
    set: Settings = None,
    workers: int | None = None,
    threads: int = 1,
    kind: Literal["processes", "threads"] = "processes",
    progress: Told = True,
    from_run: Recording | PathLike | None = None,
    from_step: int | None = None,
    results: int = RESULTS,
) -> Recording:
    """Runs a scene on this machine to its end.

    Ctrl-C ends it early: the recording until then is finished, and `KeyboardInterrupt` is raised.

    Parameters
    ----------
    scene : Scene or path
        The scene, or its file or folder.
    out : path, optional
        Folder for ``run.mcap``, ``summary.json`` and a timeline, made if it is not there; without it a new folder
        ``runs/SCENE-N``.
    set : mapping or list of str, optional
        As for `Scene.load`.
    workers, threads, kind
        As for `LocalPool`.
    progress : bool or callable
        Whether a bar is shown, in notebooks and terminals; or who is called with a `Progress`. What it raises ends the
        run.
    from_run : Recording or path, optional
        An earlier run. Jobs whose problem is the same take the result from there, and only the others are solved. The
        digest is the same without it.
    from_step : int, optional
        The step of `from_run` at which it is resumed: the steps before it must come out as they are recorded there, or
        `RunError` is raised.
    results : int
        Results of jobs that are kept beside the recording for a later `from_run`, at most [MiB]; 0 for none.

    Returns
    -------
    Recording
        What was recorded. Its `unmet` has the expectations of the scene that do not hold.

    Raises
    ------
    SceneError
        The scene is wrong.
    RunError
        The run has no result; ``run.mcap.partial`` has what was recorded.
    """
    if isinstance(scene, Scene):
        scene = scene if set is None else Scene(scene._inner.set(settings(set)))
    else:
        scene = Scene.load(scene, set=set)
    with LocalPool(workers, threads, kind) as pool:
        return pool.run(scene, out, progress, from_run=from_run, from_step=from_step, results=results)


def sweep(
    scene: Scene | PathLike,
    values: Mapping[str, Sequence[Any]],
    *,
    out: PathLike | None = None,
    workers: int | None = None,
    threads: int = 1,
    kind: Literal["processes", "threads"] = "processes",
    progress: Told = True,
    from_run: Recording | PathLike | None = None,
) -> Sweep:
    """Runs a scene on this machine with every combination of values, one after another on one pool.

    Parameters
    ----------
    scene : Scene or path
        The scene.
    values : mapping of str to sequence
        Values by path: ``{"world.seed": range(5), "body.ball.velocity": [[0, 0, -v] for v in (2, 4, 8)]}``.
    out : path, optional
        Folder for the runs' folders ``1``, ``2``, …; without it a new one.
    workers, threads, kind, progress, from_run
        As for `run`. The runs take results from each other too, as far as the pool remembers them, and keep none.

    Returns
    -------
    Sweep
        The runs with their values.
    """
    scene = scene if isinstance(scene, Scene) else Scene.load(scene)
    with LocalPool(workers, threads, kind) as pool:
        return pool.sweep(scene, values, out=out, progress=progress, from_run=from_run)


def _sweep(
    pool: LocalPool,
    scene: Scene,
    values: Mapping[str, Sequence[Any]],
    out: PathLike | None,
    progress: Told,
    from_run: Recording | PathLike | None,
) -> Sweep:
    rows = [dict(zip(values, row, strict=True)) for row in itertools.product(*values.values())]
    if not values or not rows:
        raise ValueError("a sweep has at least one value")
    # All are checked before the first one runs.
    scenes = [scene.set(row) for row in rows]
    folder = folder_for(out, f"{scene.name}-sweep")
    runs = []
    for number, (row, one) in enumerate(zip(rows, scenes, strict=True), 1):
        recording = pool.run(one, folder / str(number), progress, from_run=from_run, results=0)
        runs.append(SweepRun(values=row, recording=recording))
    return Sweep(runs)
