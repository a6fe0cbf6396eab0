"""Scenes: loaded from files, read from text, or built from Python's own numbers."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _cullet
from ._table import Array, Table, table
from ._values import Settings, document, settings

PathLike = Union[str, "os.PathLike[str]"]

_BODIES = {
    "mass": ("f8", 1, "kg"),
    "volume": ("f8", 1, "m³"),
    "fixed": ("?", 1, ""),
    "breakable": ("?", 1, ""),
    "triangles": ("u8", 1, ""),
    "position": ("f8", 3, "m"),
    "velocity": ("f8", 3, "m/s"),
}


class Scene:
    """A scene that was read and checked, ready to run or to submit.

    Made by `Scene.load`, `Scene.from_text`, or by `SceneBuilder.scene`. A scene does not change: `set` returns another
    one. All quantities are SI: metres, kilograms, seconds; gravity is along −z unless the scene sets it.

    Examples
    --------
    >>> scene = Scene.load("scenes/pot", set={"world.seed": 7})
    >>> scene.bodies["name"]
    array(['floor', 'pot'], dtype='<U5')
    """

    def __init__(self, inner: _cullet.Scene) -> None:
        self._inner = inner

    @classmethod
    def load(cls, path: PathLike, set: Settings = None) -> Scene:
        """Reads a scene from its file, or from the folder that holds ``scene.toml``.

        Parameters
        ----------
        path : path
            The file or the folder.
        set : mapping or list of str, optional
            Values over those of the file: ``{"world.seed": 7, "body.ball.velocity": [0, 0, -8]}``, or arguments as
            ``cullet run --set`` takes them, such as ``"body.ball.velocity=[0, 0, '-30 km/h']"``.

        Raises
        ------
        SceneError
            Everything that is wrong with it, each with its place.
        """
        return cls(_cullet.Scene.load(os.fspath(path), settings(set)))

    @classmethod
    def from_text(
        cls,
        text: str,
        *,
        name: str = "scene",
        folder: PathLike | None = None,
        files: Mapping[str, bytes] | None = None,
        set: Settings = None,
    ) -> Scene:
        """Reads a scene from TOML, as docs/scene.md describes it.

        Parameters
        ----------
        text : str
            The scene file.
        name : str
            What the scene is called.
        folder : path, optional
            Where files lie that the text names, such as meshes. Without a folder it can name none but `files`.
        files : mapping of str to bytes, optional
            Files by the names that the text has for them.
        set : mapping or list of str, optional
            As for `load`.

        Raises
        ------
        SceneError
            Everything that is wrong with it, each with its place.
        """
        given = {key: bytes(content) for key, content in (files or {}).items()}
        place = None if folder is None else os.fspath(folder)
        return cls(_cullet.Scene.parse(name, text, given, place, settings(set)))

    def set(self, path: str | Mapping[str, Any], value: Any = None) -> Scene:
        """The same scene with another value, or with several.

        The scene is read again, from its file if it has one: where that was changed, so is the result.

        Parameters
        ----------
        path : str or mapping
            Where the value is, such as ``"world.seed"`` or ``"body.ball.velocity"``; or values by paths.
        value
            The value: a number in SI units, text with a unit, a list.

        Raises
        ------
        SceneError
            Everything that is wrong with the new scene.
        """
        values = path if isinstance(path, Mapping) else {path: value}
        return Scene(self._inner.set(settings(values)))

    def check(self) -> list[str]:
        """What is unusual about the scene or was repaired in its meshes, a line each.

        What is wrong was told when the scene was made, by `SceneError`.
        """
        return self._inner.warnings

    @property
    def name(self) -> str:
        """The name of its folder, or of its file."""
        return self._inner.name

    @property
    def description(self) -> str:
        """What it shows, in a line."""
        return self._inner.description

    @property
    def duration(self) -> float:
        """Simulated time of a run [s]."""
        return self._inner.duration

    @property
    def step(self) -> float:
        """Step of the rigid world [s]."""
        return self._inner.step

    @property
    def steps(self) -> int:
        """Steps of a run."""
        return self._inner.steps

    @property
    def seed(self) -> int:
        """What everything random is drawn from."""
        return self._inner.seed

    @property
    def text(self) -> str:
        """The scene file as it is written."""
        return self._inner.text

    @property
    def overrides(self) -> list[str]:
        """What was set, as ``path=value``."""
        return self._inner.overrides

    @property
    def bodies(self) -> Table:
        """The rigid bodies, in order: a table.

        Columns: `name`, `material`, `mass` [kg], `volume` [m³], `fixed`, `breakable`, `triangles`, `position` of the
        centre of mass float64[n, 3] [m], `velocity` float64[n, 3] [m/s].
        """
        return table(self._inner.bodies(), _BODIES)

    @property
    def moving(self) -> Table:
        """Sheets and dynamic bodies, which move as they deform: `name`, `material`, `about` in words."""
        return table(self._inner.moving(), {})

    def __repr__(self) -> str:
        moving = len(self.moving)
        more = f", {moving} that move as they deform" if moving else ""
        return f"<Scene {self.name}: {len(self.bodies)} bodies{more}, {self.steps} steps of {self.step:.6g} s>"


class SceneBuilder:
    """Puts a scene together from Python's own numbers and arrays.

    Keyword arguments have the names and units of docs/scene.md: numbers are SI, text has a unit (``"20 cm"``).
    `text` is the scene file that comes of it.

    Parameters
    ----------
    name : str
        What the scene is called.
    description : str, optional
        What it shows, in a line.
    world, fracture, fidelity, view, recording, expect : mapping, optional
        The tables of these names.

    Examples
    --------
    >>> build = SceneBuilder("drop", world={"duration": 0.3})
    >>> build.add_body("floor", shape={"kind": "box", "size": [4, 4, 0.2]}, position=[0, 0, -0.1],
    ...                material="granite", fixed=True)
    >>> build.add_body("ball", shape={"kind": "sphere", "radius": 0.05}, position=[0, 0, 0.1],
    ...                velocity=[0, 0, -8], material="soda-lime-glass")
    >>> scene = build.scene()
    """

    def __init__(self, name: str, description: str | None = None, **tables: Mapping[str, Any]) -> None:
        self.name = name
        self._tables: dict[str, Any] = {"description": description, **tables}
        self._files: dict[str, bytes] = {}

    def add_body(
        self,
        name: str,
        *,
        material: str | None = None,
        shape: Mapping[str, Any] | None = None,
        mesh: tuple[ArrayLike, ArrayLike] | PathLike | None = None,
        **keys: Any,
    ) -> SceneBuilder:
        """Adds a body: `shape` or `mesh`, `material`, and any key of ``[[body]]``.

        Parameters
        ----------
        name : str
            Its name.
        material : str
            A preset, or a material added by `add_material`.
        shape : mapping, optional
            A shape by its dimensions: ``{"kind": "box", "size": [1, 1, 0.1]}``.
        mesh : (vertices, triangles) or path, optional
            A mesh: float64[n, 3] [m] with the triangles' corners uint32[m, 3], counter-clockwise seen from outside; or
            a mesh file.
        **keys
            `position`, `rotation`, `velocity`, `spin`, `fixed`, `solver`, …: docs/scene.md has them all.
        """
        body: dict[str, Any] = {"name": name, "shape": shape, "mesh": None, "material": material, **keys}
        if mesh is not None:
            body["mesh"] = self._mesh(name, mesh)
        return self._add("body", body)

    def add_sheet(self, name: str, **keys: Any) -> SceneBuilder:
        """Adds a sheet that moves as it deforms: any key of ``[[sheet]]``."""
        return self._add("sheet", {"name": name, **keys})

    def add_material(self, name: str, **keys: Any) -> SceneBuilder:
        """Adds a material: any key of ``[[material]]``."""
        return self._add("material", {"name": name, **keys})

    def _add(self, kind: str, row: dict[str, Any]) -> SceneBuilder:
        self._tables.setdefault(kind, []).append(row)
        return self

    def _mesh(self, name: str, mesh: Any) -> str:
        if isinstance(mesh, str | os.PathLike):
            path = Path(mesh)
            key = f"{len(self._files)}-{path.name}"
            self._files[key] = path.read_bytes()
            return key
        vertices, triangles = mesh
        key = f"{len(self._files)}.ply"
        self._files[key] = ply(vertices, triangles)
        return key

    @property
    def text(self) -> str:
        """The scene file."""
        return document(self._tables)

    def scene(self, set: Settings = None) -> Scene:
        """Checks the scene.

        Raises
        ------
        SceneError
            Everything that is wrong with it, each with its place in `text`.
        """
        return Scene.from_text(self.text, name=self.name, files=self._files, set=set)


def ply(vertices: ArrayLike, triangles: ArrayLike) -> bytes:
    """A mesh as a binary PLY file, in which coordinates keep all their bits.

    Parameters
    ----------
    vertices : float64[n, 3]
        Corners [m].
    triangles : uint32[m, 3]
        Three corners each, counter-clockwise seen from outside.

    Raises
    ------
    ValueError
        Arrays of other shapes, corners that are not finite, or triangles with corners that are not there.
    """
    points: Array = np.ascontiguousarray(vertices, dtype="<f8")
    faces: Array = np.asarray(triangles)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"vertices have the shape {points.shape}; it must be (n, 3)")
    if faces.ndim != 2 or faces.shape[1] != 3:
        raise ValueError(f"triangles have the shape {faces.shape}; it must be (m, 3)")
    if not np.issubdtype(faces.dtype, np.integer):
        raise ValueError(f"triangles are {faces.dtype}; they must be whole numbers")
    if not np.isfinite(points).all():
        raise ValueError("a vertex is not finite")
    if faces.size and (faces.min() < 0 or faces.max() >= len(points)):
        raise ValueError(f"a triangle names vertex {faces.max()}, or one below 0; there are {len(points)}")
    rows = np.empty(len(faces), dtype=[("n", "u1"), ("corners", "<i4", 3)])
    rows["n"], rows["corners"] = 3, faces
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    return head.encode() + points.tobytes() + rows.tobytes()


def materials() -> dict[str, Any]:
    """The material presets, with the source of each value."""
    presets: Sequence[dict[str, Any]] = json.loads(_cullet.materials_json())
    return {preset["name"]: preset for preset in presets}


def schema() -> dict[str, Any]:
    """The JSON schema of scene files: every key with its unit, bounds and meaning."""
    schema: dict[str, Any] = json.loads(_cullet.schema_json())
    return schema
