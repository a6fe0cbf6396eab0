"""A client of a farm: submits scenes, watches runs, fetches recordings."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import _cullet
from ._errors import ClientError, RunError
from ._progress import Progress, Shown, Told
from ._recording import Recording
from ._run import folder_for, new_folder, refuse_taken
from ._scene import PathLike, Scene
from ._sweep import Sweep, SweepRun
from ._values import Settings, settings

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"
"""Where a coordinator listens by default."""

OVER = frozenset(("done", "failed", "stalled", "cancelled"))
"""States in which nothing more happens to a run by itself."""


@dataclass(frozen=True)
class RunInfo:
    """A run, as its coordinator knows it.

    Attributes
    ----------
    run : int
        Its number.
    name : str
        The scene's name.
    state : str
        `queued`, `running`, `paused`, `done`, `failed`, `stalled` or `cancelled`.
    user, sweep : str
        Whose it is, and the sweep that it belongs to.
    code : int or None
        How it ended, as the exit code of ``cullet run``.
    text : str
        Why it is not done, if it is over and is not.
    overrides : list of str
        What was set.
    answer : dict
        All that the coordinator says: `RunInfo` of docs/protocol.md.
    """

    run: int
    name: str
    state: str
    user: str
    sweep: str
    code: int | None
    text: str
    overrides: list[str]
    answer: dict[str, Any] = field(repr=False)

    @classmethod
    def _of(cls, answer: dict[str, Any]) -> RunInfo:
        names = ("run", "name", "state", "user", "sweep", "code", "text", "overrides")
        return cls(**{name: answer[name] for name in names}, answer=answer)

    @property
    def over(self) -> bool:
        """Whether nothing more happens to it by itself."""
        return self.state in OVER


class Client:
    """A client of a farm, connected to its coordinator.

    Parameters
    ----------
    endpoint : str
        Zenoh endpoint of the coordinator, such as ``tcp/192.168.0.7:7447``.
    tls : path, optional
        Folder with ``ca.pem``, ``cert.pem`` and ``key.pem``, for a ``tls/`` endpoint.
    user : str
        Who asks; with TLS the common name of the certificate.
    coordinator : str
        The coordinator's name, if there are several on the network.
    patience : float
        Longest time to try to connect, and then to wait for each answer [s].

    Raises
    ------
    ClientError
        Nobody answers.

    Examples
    --------
    >>> client = Client()
    >>> run = client.submit(Scene.load("scenes/pot"))
    >>> for progress in client.watch(run):
    ...     print(progress)
    >>> recording = client.fetch(run, "pot")
    """

    def __init__(
        self,
        endpoint: str = DEFAULT_ENDPOINT,
        *,
        tls: PathLike | None = None,
        user: str = "user",
        coordinator: str = "main",
        patience: float = 10.0,
    ) -> None:
        if endpoint.startswith("tls/") and tls is None:
            raise ClientError(f"{endpoint}: a tls/ endpoint needs the folder of an identity (tls=)")
        folder = None if tls is None else os.fspath(tls)
        self.endpoint = endpoint
        self._inner = _cullet.Client(endpoint, folder, user, coordinator, patience)

    def submit(
        self,
        scene: Scene | PathLike,
        *,
        set: Settings = None,
        priority: int = 0,
        sweep: str = "",
        ticket: str | None = None,
        room: float | None = None,
    ) -> int:
        """Hands a scene in with all its files.

        Parameters
        ----------
        scene : Scene or path
            The scene, or its file or folder.
        set : mapping or list of str, optional
            As for `Scene.load`.
        priority : int
            From −100 to 100; higher ones run first.
        sweep : str
            The sweep that it belongs to.
        ticket : str, optional
            The sender's own name for it: handed in again with the same ticket, it is the same run.
        room : float, optional
            How long a full queue is asked for room [s]; ``math.inf`` for as long as it takes. Without it `patience`.

        Returns
        -------
        int
            The number of the run.

        Raises
        ------
        SceneError
            The scene is wrong.
        ClientError
            The coordinator refuses or is silent.
        """
        scene = scene if isinstance(scene, Scene) else Scene.load(scene)
        scene = scene if set is None else Scene(scene._inner.set(settings(set)))
        run = self._inner.submit(scene._inner, priority, sweep, ticket, room)
        # Nobody follows it yet: a coordinator that ends need not wait for us.
        self._inner.enough(run)
        return run

    def watch(self, run: int) -> Iterator[Progress]:
        """How far a run is, again and again, until it is over or paused.

        Each `Progress` has the state and the lines of the log that are new.

        Raises
        ------
        ClientError
            There is no such run, or the coordinator is silent or about to end.
        """
        start, told = 0, False
        try:
            while True:
                news = json.loads(self._inner.news(run, start))
                start = news["next"]
                progress = _progress(news["run"], news["lines"])
                if not told or news["lines"] or news["run"]["position"] or news["end"]:
                    told = True
                    yield progress
                if news["end"]:
                    return
                if news["leaving"]:
                    text = f"{self.endpoint}: the coordinator is about to end; run {run} goes on when it is back"
                    raise ClientError(text)
        finally:
            self._inner.enough(run)

    def wait(self, run: int, *, progress: Told = True) -> RunInfo:
        """Waits until a run is over or paused, and shows how far it is.

        Raises
        ------
        ClientError
            As `watch`.
        """
        with Shown(f"run {run}", progress) as shown:
            for moment in self.watch(run):
                shown.show(moment)
        return self.run(run)

    def fetch(self, run: int, out: PathLike | None = None) -> Recording:
        """Fetches what a run left, once it is over.

        Each file appears once it is whole and matches its digest. A fetch that was broken off goes on in the same
        folder, and what is there already is not fetched again.

        Parameters
        ----------
        run : int
            Its number.
        out : path, optional
            The folder, made if it is not there; without it a new folder ``runs/SCENE-N``.

        Raises
        ------
        ClientError
            The run is not over, the coordinator is silent, a file does not match, or the folder holds a run.
        RunError
            The run left no recording.
        """
        info = self.run(run)
        if not info.over:
            raise ClientError(f"run {run} is {info.state}, not over")
        folder = new_folder(info.name) if out is None else Path(out)
        files = {path.name: path for path in map(Path, self._inner.fetch(run, os.fspath(folder)))}
        found = files.get("run.mcap") or files.get("run.mcap.partial")
        if found is None:
            raise RunError(f"run {run} is {info.state} and left no recording: {info.text}")
        return Recording(found)

    def sweep(
        self,
        file: PathLike,
        out: PathLike | None = None,
        *,
        set: Sequence[str] | None = None,
        priority: int = 0,
        progress: Told = True,
    ) -> Sweep:
        """Hands all runs of a sweep file in, waits for them and fetches them.

        All scenes are checked before the first is handed in. A full queue is asked for room for as long as it takes.
        Where the sweep breaks off, the exception has a note with the numbers of the runs that were handed in.

        Parameters
        ----------
        file : path
            A sweep file, as docs/operations.md describes it.
        out : path, optional
            Folder for the runs' folders ``1``, ``2``, …; without it a new one.
        set : list of str, optional
            ``path=value`` for every run.
        priority : int
            From −100 to 100.
        progress : bool or callable
            As for `run`.

        Raises
        ------
        SceneError
            The sweep or a scene of it is wrong.
        ClientError
            The coordinator refuses or is silent.
        RunError
            The folder holds a run or a sweep.
        """
        if out is not None:
            refuse_taken(out)
        path = Path(file)
        told = _cullet.sweep_rows(path.read_text(encoding="utf-8"))
        base = path.parent / told["scene"]
        scenes = [Scene.load(base, set=[*row, *(set or [])]) for row in told["set"]]
        runs: list[int] = []
        try:
            for scene in scenes:
                runs.append(self.submit(scene, priority=priority, sweep=path.stem, room=math.inf))
            folder = folder_for(out, path.stem)
            rows = []
            for number, (run, values) in enumerate(zip(runs, told["values"], strict=True), 1):
                info = self.wait(run, progress=progress)
                here = dict(zip(told["keys"], map(_value, values), strict=True))
                recording = None
                if info.over and any(file["name"] == "run.mcap" for file in info.answer["files"]):
                    recording = self.fetch(run, folder / str(number))
                rows.append(SweepRun(values=here, recording=recording, run=run, state=info.state))
        except BaseException as error:
            numbers = ", ".join(map(str, runs)) or "none"
            error.add_note(f"runs of the sweep {path.stem} that were handed in: {numbers}")
            raise
        return Sweep(rows)

    def run(self, run: int) -> RunInfo:
        """What is known of a run."""
        return RunInfo._of(json.loads(self._inner.run(run)))

    def runs(self) -> list[RunInfo]:
        """Every run that the coordinator remembers, by number."""
        return [RunInfo._of(answer) for answer in json.loads(self._inner.runs())]

    def about(self) -> dict[str, Any]:
        """What the coordinator is and has."""
        about: dict[str, Any] = json.loads(self._inner.about())
        return about

    def cancel(self, run: int) -> None:
        """Ends a run; its recording so far is kept."""
        self._inner.cancel(run)

    def pause(self, run: int) -> None:
        """Pauses a run."""
        self._inner.pause(run)

    def resume(self, run: int) -> None:
        """Puts a paused run back into the queue."""
        self._inner.resume(run)

    def retry(self, run: int) -> None:
        """Puts a run that failed, stalled or was cancelled back into the queue."""
        self._inner.retry(run)

    def delete(self, run: int) -> None:
        """Deletes a run that is over, with its recording, from the coordinator's disk."""
        self._inner.delete(run)

    def __repr__(self) -> str:
        return f"<Client {self._inner.user} at {self.endpoint}>"


def _progress(run: dict[str, Any], lines: list[str]) -> Progress:
    at = run["position"] or {}
    return Progress(
        time=at.get("time", 0.0),
        end=at.get("end", 0.0),
        bodies=at.get("bodies", 0),
        fractures=at.get("fractures", 0),
        jobs=at.get("jobs", 0),
        jobs_done=at.get("permille", 0) / 1000.0,
        state=run["state"],
        lines=tuple(lines),
    )


def _value(text: str) -> Any:
    """A value of a sweep, which is TOML; text where it is none."""
    import tomllib

    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
