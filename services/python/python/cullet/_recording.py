"""Recordings: what a run left, as numpy arrays, worked out when they are asked for."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, overload

import numpy as np

from . import _cullet
from ._errors import RecordingError
from ._scene import PathLike
from ._table import Array, Table, numbers, table

_BODIES = {
    "body": ("u8", 1, ""),
    "parent": ("i8", 1, ""),
    "generation": ("u4", 1, ""),
    "mass": ("f8", 1, "kg"),
    "volume": ("f8", 1, "m³"),
    "fixed": ("?", 1, ""),
    "birth_step": ("u8", 1, ""),
    "end_step": ("i8", 1, ""),
    "spacing": ("f8", 1, "m"),
}
_ROWS = {
    "step": ("u8", 1, ""),
    "time": ("f8", 1, "s"),
    "body": ("u8", 1, ""),
    "position": ("f8", 3, "m"),
    "rotation": ("f8", 4, ""),
    "velocity": ("f8", 3, "m/s"),
    "spin": ("f8", 3, "rad/s"),
}
_GRAINS = {
    "grain": ("u8", 1, ""),
    "position": ("f8", 3, "m"),
    "velocity": ("f8", 3, "m/s"),
    "mass": ("f8", 1, "kg"),
    "size": ("f8", 1, "m"),
    "parent": ("u8", 1, ""),
}
_SHAPES = {
    "body": ("u8", 1, ""),
    "step": ("u8", 1, ""),
    "time": ("f8", 1, "s"),
    "mass": ("f8", 1, "kg"),
    "volume": ("f8", 1, "m³"),
}
_MASSES = {
    "generation": ("u4", 1, ""),
    "mass": ("f8", 1, "kg"),
    "ratio": ("f8", 1, ""),
    "cell": ("f8", 1, "kg"),
}
_REST = {"body": ("u8", 1, ""), "root": ("u8", 1, ""), "origin": ("f8", 3, "m")}


@dataclass(frozen=True)
class Mesh:
    """A closed mesh in the frame of its body, whose origin is the centre of mass.

    Attributes
    ----------
    vertices : float64[n, 3]
        Corners [m].
    triangles : uint32[m, 3]
        Three corners each, counter-clockwise seen from outside.
    crack : bool[m]
        True for a crack face, false for the surface that the object was made with.
    damage_time : float32[m, 3]
        At each corner of a crack face, the time from the impact to full damage [s]; nan elsewhere.
    front_speed : float32[m, 3]
        At each corner of a crack face, the speed of the crack front [m/s], 0 where it is not known; nan elsewhere.
    """

    vertices: Array
    triangles: Array
    crack: Array
    damage_time: Array
    front_speed: Array

    @property
    def volume(self) -> float:
        """Volume [m³]."""
        a, b, c = (self.vertices[self.triangles[:, corner]] for corner in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)

    @property
    def crack_area(self) -> float:
        """Area of its crack faces [m²]."""
        a, b, c = (self.vertices[self.triangles[self.crack, corner]] for corner in range(3))
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


@dataclass(frozen=True)
class Crack:
    """A crack that ends inside a body: an open surface in the body's frame.

    Attributes
    ----------
    vertices : float64[n, 3]
        Corners [m].
    triangles : uint32[m, 3]
        Three corners each; which side is seen means nothing.
    damage_time : float32[n]
        Time from the impact to full damage [s].
    front_speed : float32[n]
        Speed of the crack front [m/s]; 0 where it is not known.
    step, time : int, float
        When it was recorded [s].
    """

    vertices: Array
    triangles: Array
    damage_time: Array
    front_speed: Array
    step: int
    time: float


@dataclass(frozen=True)
class SheetMoment:
    """A body that moves as it deforms, at one frame, in the world.

    Attributes
    ----------
    vertices : float64[n, 3]
        Where its points are [m].
    triangles : uint32[m, 3]
        Three points each, counter-clockwise seen from outside, or from above where a sheet lies at rest. They change
        where it tears: points along a tear are there once for each of its lips.
    reference : float32[n, 2]
        Place of each point at rest, in the plane of the sheet [m].
    quantity : float32[n] or float32[0]
        What diffuses at each point; empty where nothing does.
    thickness : float
        Thickness with which it is drawn [m]; 0 for a closed surface.
    step, time : int, float
        When this frame was recorded [s].
    """

    vertices: Array
    triangles: Array
    reference: Array
    quantity: Array
    thickness: float
    step: int
    time: float


class Sheet:
    """A body that moves as it deforms: a ``[[sheet]]``, a soft shell or a soft solid.

    Attributes
    ----------
    number : int
        Its number in the recording.
    name, material : str
        As in the scene.
    steps : uint64[k]
        Steps of its frames.
    times : float64[k]
        Times of its frames [s].
    """

    def __init__(self, inner: _cullet.Recording, told: dict[str, Any], step: float) -> None:
        self._inner, self._step = inner, step
        self.number: int = told["number"]
        self.name: str = told["name"]
        self.material: str = told["material"]
        self.steps = numbers(told["step"], "u8")
        self.times = numbers(told["time"], "f8")

    def at(self, time: float | None = None, *, step: int | None = None) -> SheetMoment | None:
        """Its last frame up to a time [s] or step, or of the run; nothing where it has none until then.

        Raises
        ------
        RecordingError
            The frame or its surface is damaged.
        """
        told = self._inner.sheet_at(self.number, _step(self._step, time, step, _LAST))
        if told is None:
            return None
        return SheetMoment(
            vertices=numbers(told["vertices"], "f8", 3),
            triangles=numbers(told["triangles"], "u4", 3),
            reference=numbers(told["reference"], "f4", 2),
            quantity=numbers(told["quantity"], "f4"),
            thickness=told["thickness"],
            step=told["step"],
            time=told["time"],
        )

    @cached_property
    def windows(self) -> list[dict[str, Any]]:
        """What came of each window of its time, in order.

        `first_step`, `steps`, `time` at its end [s], `gap` [m], `solved` (how often), `one_way`, `ledger` (mass,
        momentum and energies by name, SI units), `pieces`, `figures` (value and unit by name), `warnings`:
        docs/recording.md.
        """
        return self._inner.windows(self.number)

    def __repr__(self) -> str:
        return f"<Sheet {self.number} {self.name}: {self.material}, {len(self.times)} frames>"


_LAST = 2**63 - 1
_SLACK = 1e-6
"""Part of a step by which a time may miss it, for 0.1 is not 24 steps of 1/240 to the bit."""


def _step(size: float, time: float | None, step: int | None, last: int) -> int:
    if time is not None and step is not None:
        raise ValueError("name a time or a step, not both")
    if step is not None:
        if step < 0:
            raise ValueError(f"step {step}: steps begin at 0")
        return int(step)
    if time is None:
        return last
    if not time >= 0:
        raise ValueError(f"{time} s: a run begins at 0 s")
    return int(min(time / size + _SLACK, last))


class Recording:
    """What a run recorded. Arrays are made when they are asked for, and are read-only.

    Lengths are metres, times seconds, all units SI; docs/recording.md describes every field. A moment is a time [s] or
    a step; without either, the end of the run.

    Parameters
    ----------
    path : path
        ``run.mcap``, or the folder that holds it. Of a run that was killed, ``run.mcap.partial`` is read up to its
        last whole chunk.

    Raises
    ------
    RecordingError
        No such file, or one of another program.

    Examples
    --------
    >>> recording = Recording("runs/pot-1")
    >>> pieces = recording.bodies[recording.bodies.parent >= 0]
    >>> pieces.mass.sum()
    """

    def __init__(self, path: PathLike) -> None:
        given = Path(path)
        if given.is_dir():
            given = given / "run.mcap"
        self._given = given
        if not given.exists() and not given.with_name(given.name + ".partial").exists():
            raise RecordingError(f"{given}: there is no such recording")
        self.unmet: list[str] = []
        self.log: list[str] = []

    @cached_property
    def _inner(self) -> _cullet.Recording:
        return _cullet.Recording(os.fspath(self._given))

    @property
    def path(self) -> Path:
        """The file that is read."""
        return Path(self._inner.path)

    @property
    def folder(self) -> Path:
        """The folder that it lies in."""
        return self._given.parent

    @property
    def complete(self) -> bool:
        """Whether the run ended and the file is whole."""
        return self._inner.complete

    @property
    def damaged(self) -> bool:
        """Whether something is missing in it, or its end is though it has the name of a whole file."""
        return self._inner.damaged

    @property
    def missing(self) -> str | None:
        """What a damaged or recovered recording lacks, in words; ``None`` where nothing does.

        One that lacks something tells of no expectation of its scene.
        """
        return self._inner.missing

    @cached_property
    def meta(self) -> dict[str, str]:
        """The metadata of the run: scene, seed, version, step, gravity, …"""
        return self._inner.meta

    @cached_property
    def summary(self) -> dict[str, Any]:
        """What ``summary.json`` has: counts, shares solved and sampled, the conservation ledger, the digest."""
        summary: dict[str, Any] = json.loads(self._inner.summary())
        return summary

    @property
    def digest(self) -> str:
        """The digest of the run: equal for equal runs, whatever the number of workers."""
        return str(self.summary["digest"])

    @property
    def step(self) -> float:
        """Step of the rigid world [s]."""
        return float(self.meta["step"])

    @property
    def steps(self) -> int:
        """Steps that were taken."""
        return int(self.summary["steps"])

    @property
    def duration(self) -> float:
        """Simulated time [s]."""
        return float(self.summary["sim_seconds"])

    @cached_property
    def bodies(self) -> Table:
        """Every body that there was, in order of birth: a table.

        Columns: `body` uint64, its number; `name`; `object` of the scene that it is a part of; `parent` int64, the body
        that it broke from, or −1; `generation`; `tier` (`whole`, `large`, `small`, `tiny`); `made`; `material`; `mass`
        [kg]; `volume` [m³]; `fixed`; `birth_step`; `end_step` int64, when it broke or left, or −1; `spacing` [m] of the
        grid that it was solved with, or 0.

        `made` says where a body comes from: `given` by the scene; `solved`, for a solver found its cracks; `sampled`,
        drawn from a size distribution where the body was crushed finer than the grid can resolve; or `unknown`, in old
        recordings.
        """
        return table(self._inner.bodies(), _BODIES)

    def body(self, which: int | str) -> dict[str, Any]:
        """The row of `bodies` of a body, by number or name.

        Raises
        ------
        KeyError
            There is none.
        """
        column = self.bodies.name if isinstance(which, str) else self.bodies.body
        rows = np.flatnonzero(column == which)
        if not len(rows):
            raise KeyError(f"there is no body {which!r} in {self._given}")
        return dict(self.bodies[int(rows[0])])

    @cached_property
    def pose_rows(self) -> Table:
        """The whole pose track: a row for each body that moved in a step.

        Columns: `step`, `time` [s], `body`, `position` of the centre of mass float64[n, 3] [m], `rotation`
        float64[n, 4], a unit quaternion x, y, z, w from the body's frame to the world, `velocity` float64[n, 3] [m/s],
        `spin` float64[n, 3] [rad/s].
        """
        return table(self._inner.pose_rows(), _ROWS)

    def poses(self, time: float | None = None, *, step: int | None = None) -> Table:
        """Where the bodies are that are there at a moment, by number.

        Those that broke or left by then are not among them. The columns are those of `pose_rows`; `step` and `time`
        are of the row, which is older where a body rests.
        """
        at = _step(self.step, time, step, _LAST)
        rows = self.pose_rows
        until = int(np.searchsorted(rows.step, at, side="right"))
        # The last row of each body, which comes first from behind.
        ids, back = np.unique(rows.body[:until][::-1], return_index=True)
        bodies = self.bodies
        gone = bodies.body[(bodies.end_step >= 0) & (bodies.end_step <= at)]
        there = ~np.isin(ids, gone)
        poses: Table = rows[until - 1 - back[there]]
        return poses

    def track(self, body: int | str) -> Table:
        """The rows of `pose_rows` of one body, in order of time."""
        number = self.body(body)["body"]
        track: Table = self.pose_rows[self.pose_rows.body == number]
        return track

    def mesh(self, body: int | str, *, time: float | None = None, step: int | None = None) -> Mesh:
        """The mesh of a body in its own frame [m], as it is at its birth, or at a moment where it was deformed.

        Raises
        ------
        RecordingError
            The mesh is damaged or missing.
        """
        at = None if time is None and step is None else _step(self.step, time, step, _LAST)
        told = self._inner.mesh(int(self.body(body)["body"]), at)
        return Mesh(
            vertices=numbers(told["vertices"], "f8", 3),
            triangles=numbers(told["triangles"], "u4", 3),
            crack=numbers(told["crack"], "?"),
            damage_time=numbers(told["damage_time"], "f4", 3),
            front_speed=numbers(told["front_speed"], "f4", 3),
        )

    def cracks(self, body: int | str, *, time: float | None = None, step: int | None = None) -> list[Crack]:
        """Cracks that end inside a body, in its own frame [m], as far as they were recorded up to a moment."""
        at = _step(self.step, time, step, _LAST)
        return [
            Crack(
                vertices=numbers(told["vertices"], "f8", 3),
                triangles=numbers(told["triangles"], "u4", 3),
                damage_time=numbers(told["damage_time"], "f4"),
                front_speed=numbers(told["front_speed"], "f4"),
                step=told["step"],
                time=told["time"],
            )
            for told in self._inner.cracks(int(self.body(body)["body"]), at)
        ]

    def grains(self, time: float | None = None, *, step: int | None = None) -> Table:
        """The grains of debris at a moment: a table.

        Columns: `grain`, its number; `position` float64[n, 3] [m]; `velocity` float64[n, 3] [m/s]; `mass` [kg]; `size`,
        its diameter [m]; `parent`, the body that it broke from. Grains are sampled: their sizes are drawn.
        """
        return table(self._inner.grains(_step(self.step, time, step, _LAST)), _GRAINS)

    @cached_property
    def shapes(self) -> Table:
        """New shapes of bodies that were deformed: `body`, `step`, `time` [s], `mass` [kg], `volume` [m³].

        `mesh` gives the shape at a moment.
        """
        return table(self._inner.shapes(), _SHAPES)

    @cached_property
    def rest(self) -> Table:
        """Where each body lay in the whole object.

        `body`; `root`, the body of the scene; `origin` float64[n, 3], the body's centre of mass in the frame of `root`
        [m]. The axes are the same: all fragments at their origins make up the object.
        """
        return table(self._inner.rest(), _REST)

    @cached_property
    def events(self) -> list[dict[str, Any]]:
        """What happened, in order: dictionaries with `kind`, `step`, `time` [s], `body`, and what the kind has.

        `impact` has `striker`, `point` [m], `impulse` [N·s], `closing_speed` [m/s], `energy` [J], `duration` [s],
        `radius` [m], `peak_force` [N] and `dissipated` [J]; `fractured` has `fragments`, `grains`, `grain_mass` [kg],
        `alpha` and `ledger`; `job_settled` has `verdict`; `expectation` has `held`. `gate`, `job_opened`,
        `kept_whole`, `removed`, `deformed` and `finished` have no more. `text` has reasons, `job` the digest of a job.
        """
        return self._inner.events()

    @cached_property
    def fractures(self) -> list[dict[str, Any]]:
        """The events of kind `fractured`, with what was solved and what was sampled.

        They have `sampled_fragments` (the others were solved), `solved_volume` and `sampled_volume` [m³], and
        `solved_crack_area` and `sampled_crack_area` [m²] beside; None in old recordings.
        """
        return self._inner.fractures()

    @cached_property
    def reports(self) -> list[dict[str, Any]]:
        """How each job came out, in order.

        `body`, `hits`, `asked` and `solver` (families), `verdict` (`broken`, `kept`, `refused`, `failed`, `abandoned`,
        `deformed`), `refusal`, `fragments`, `spacing` [m], `particles`, `steps`, `simulated` [s], `crack_area` [m²],
        `fracture_energy` [J], `dissipated_energy` [J], `strength_ratio`, `damaged_fraction`, `delivered_impulse`
        [N·s], `warnings`, and `figures`: value and unit by name, which only the family knows.
        """
        return self._inner.reports()

    @cached_property
    def sheets(self) -> list[Sheet]:
        """Bodies that move as they deform: sheets, soft shells and soft solids."""
        return [Sheet(self._inner, told, self.step) for told in self._inner.sheets()]

    def sheet(self, name: str) -> Sheet:
        """A sheet by its name.

        Raises
        ------
        KeyError
            There is none.
        """
        for sheet in self.sheets:
            if sheet.name == name:
                return sheet
        raise KeyError(f"there is no sheet {name!r} in {self._given}")

    @cached_property
    def energy(self) -> Table:
        """Energies of the rigid bodies, after each step with a pose.

        Columns: `step`, `time` [s], `translational` Σ ½ m v² of the moving bodies, rotation left out [J], `fracture`
        the energy of all cracks until then, G_f·A [J], `bodies` that are there.
        """
        rows, bodies = self.pose_rows, self.bodies
        place = {int(number): row for row, number in enumerate(bodies.body)}
        index = np.array([place[int(number)] for number in rows.body], dtype=np.int64)
        each = 0.5 * bodies.mass[index] * np.einsum("ij,ij->i", rows.velocity, rows.velocity)
        each = np.where(bodies.fixed[index], 0.0, each)
        steps, first = np.unique(rows.step, return_index=True)
        bounds = np.append(first, len(rows))
        current = np.zeros(len(bodies))
        there = np.zeros(len(bodies), dtype=bool)
        ends = sorted((int(end), row) for row, end in enumerate(bodies.end_step) if end >= 0)
        energies, counts = np.zeros(len(steps)), np.zeros(len(steps), dtype=np.int64)
        for i, step in enumerate(steps):
            span = slice(bounds[i], bounds[i + 1])
            current[index[span]] = each[span]
            there[index[span]] = True
            while ends and ends[0][0] <= step:
                row = ends.pop(0)[1]
                current[row], there[row] = 0.0, False
            energies[i], counts[i] = current.sum(), there.sum()
        spent = np.array([event["ledger"]["fracture_energy"] for event in self.fractures])
        when = np.array([event["step"] for event in self.fractures], dtype=np.uint64)
        total = np.concatenate([[0.0], np.cumsum(spent)])[np.searchsorted(when, steps, side="right")]
        times = rows.time[first]
        columns: dict[str, Array] = {"step": steps, "time": times, "translational": energies}
        columns |= {"fracture": total, "bodies": counts}
        return Table(columns, {"time": "s", "translational": "J", "fracture": "J"})

    @cached_property
    def fragment_masses(self) -> Table:
        """The fragments that broke no further: `name`, `object`, `generation`, `mass` [kg], `ratio`, `cell`,
        `made`.

        `ratio` is the volume over the object's [1]; `cell` the mass of a cell of the grid that it was solved with [kg],
        0 where there was no grid; `made` is "solved" or "sampled". A solve resolves solved fragments of 64 cells and more.
        """
        return table(self._inner.fragment_masses(), _MASSES)

    def attachment(self, name: str) -> bytes:
        """A file that lies in the recording, such as ``scene.toml``; `attachments` has their names.

        Raises
        ------
        KeyError
            There is none.
        """
        content = self._inner.attachment(name)
        if content is None:
            raise KeyError(f"there is no attachment {name!r}; there are {', '.join(self.attachments)}")
        return content

    @property
    def attachments(self) -> list[str]:
        """Names of the files that lie in the recording."""
        return self._inner.attachments()

    @overload
    def still(
        self, time: float | None = ..., path: None = ..., *, size: tuple[int, int] = ..., close: bool | str = ...
    ) -> bytes: ...

    @overload
    def still(
        self, time: float | None, path: PathLike, *, size: tuple[int, int] = ..., close: bool | str = ...
    ) -> float: ...

    def still(
        self,
        time: float | None = None,
        path: PathLike | None = None,
        *,
        size: tuple[int, int] = (1280, 720),
        close: bool | str = False,
    ) -> float | bytes:
        """Draws a moment as PNG.

        Parameters
        ----------
        time : float, optional
            When [s]; without it a moment after the first break.
        path : path, optional
            The file. Without it the bytes of the picture are returned: ``IPython.display.Image(recording.still())``.
        size : (int, int)
            Pixels across and down.
        close : bool or str
            Whether what breaks fills the picture; a name: what is left of that body does.

        Returns
        -------
        float or bytes
            The moment that is shown [s], or the picture.

        Raises
        ------
        RecordingError
            There is no such moment or body, or the file cannot be written.
        """
        body = close if isinstance(close, str) else "" if close else None
        if path is not None:
            return self._inner.still(os.fspath(path), time, size, body)
        from tempfile import TemporaryDirectory

        with TemporaryDirectory() as folder:
            file = Path(folder) / "still.png"
            self._inner.still(str(file), time, size, body)
            return file.read_bytes()

    def export(
        self,
        path: PathLike,
        *,
        fps: float = 24.0,
        start: float | None = None,
        end: float | None = None,
        at: float | None = None,
        grains: bool = True,
    ) -> dict[str, Any]:
        """Writes the run for another program: ``.glb``, ``.usda`` or ``.csv``, as docs/export.md describes.

        Parameters
        ----------
        path : path
            The file; its ending says which format.
        fps : float
            Frames a second [1/s].
        start, end : float, optional
            A part of the run [s]; its first moment becomes time 0.
        at : float, optional
            One moment [s], without animation.
        grains : bool
            Whether grains of debris are there.

        Returns
        -------
        dict
            Which files were written, and what is in them.

        Raises
        ------
        RecordingError
            An option is out of bounds, or the file cannot be written.
        """
        report: dict[str, Any] = json.loads(self._inner.export(os.fspath(path), fps, (start, end), at, grains))
        return report

    def __repr__(self) -> str:
        if "_inner" not in self.__dict__:
            return f"<Recording {self._given}>"
        summary = self.summary
        word = "" if self.complete else ", with holes" if self.missing else ", cut off"
        return (
            f"<Recording {self._given}: {summary['scene']}, {summary['sim_seconds']:.3f} s, "
            f"{summary['fractures']} fractures, {summary['fragments']} fragments{word}>"
        )


@dataclass(frozen=True)
class MassFit:
    """Laws fitted to masses of fragments by maximum likelihood.

    Attributes
    ----------
    count : int
        How many masses were fitted.
    least : float
        The least mass of the laws [kg].
    mott_mass, mott_count : float
        μ [kg] and N₀ [1] of Mott's law: N(>m) = N₀ exp(−√(m/μ)).
    mott_distance : float
        Kolmogorov–Smirnov distance of the masses from it [1]. By chance alone it is below 1.36/√count in 95 % of
        samples of a law that was not fitted to them, and lower if it was.
    power_exponent : float
        τ of a power law: n(m) ∝ m^−τ.
    power_distance : float
        Distance from that [1].
    """

    count: int
    least: float
    mott_mass: float
    mott_count: float
    mott_distance: float
    power_exponent: float
    power_distance: float


def fit_masses(masses: Any, least: float = 0.0) -> MassFit | None:
    """Fits Mott's law and a power law to the masses of at least `least` [kg].

    Parameters
    ----------
    masses : array of float
        Masses [kg].
    least : float
        The least that count; 0: all, from the least of them on.

    Returns
    -------
    MassFit or None
        Nothing for fewer than three.
    """
    told = _cullet.fit_masses(np.asarray(masses, dtype=np.float64).tolist(), least)
    return None if told is None else MassFit(**told)
