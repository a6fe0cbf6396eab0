"""Cullet simulates things that break, and records every piece.

==========================================  ========================================
to                                          use
==========================================  ========================================
read, build or change a scene               `Scene`, `SceneBuilder`
run it on this machine                      `run`, `sweep`, or `LocalPool` for several
read what a run recorded                    `Recording`
have it run by a farm                       `Client`
==========================================  ========================================

All quantities are SI: metres, kilograms, seconds, newtons, joules; docstrings say so in brackets. Arrays are numpy's
and read-only. The same scene with the same seed gives the same bits, whatever the number of workers.

>>> import cullet
>>> scene = cullet.Scene.load("scenes/pot", set={"world.seed": 7})
>>> recording = cullet.run(scene)
>>> recording.bodies[recording.bodies.parent >= 0].mass
"""

from ._client import DEFAULT_ENDPOINT, Client, RunInfo
from ._cullet import VERSION as __version__
from ._errors import ClientError, CulletError, RecordingError, RunError, SceneError, ScenePlace
from ._program import program
from ._progress import Progress
from ._recording import Crack, MassFit, Mesh, Recording, Sheet, SheetMoment, fit_masses
from ._run import LocalPool, run, sweep
from ._scene import Scene, SceneBuilder, materials, ply, schema
from ._sweep import Sweep, SweepRun
from ._table import Table

__all__ = [
    "DEFAULT_ENDPOINT",
    "Client",
    "ClientError",
    "Crack",
    "CulletError",
    "LocalPool",
    "MassFit",
    "Mesh",
    "Progress",
    "Recording",
    "RecordingError",
    "RunError",
    "RunInfo",
    "Scene",
    "SceneBuilder",
    "SceneError",
    "ScenePlace",
    "Sheet",
    "SheetMoment",
    "Sweep",
    "SweepRun",
    "Table",
    "__version__",
    "fit_masses",
    "materials",
    "ply",
    "program",
    "run",
    "schema",
    "sweep",
]
