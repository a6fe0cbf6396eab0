"""What goes wrong, as exceptions. Each message names the file, value or endpoint, and the bound."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


class CulletError(Exception):
    """Anything that Cullet refuses or fails at."""

    @classmethod
    def _of(cls, said: Any) -> CulletError:
        return cls(said)


@dataclass(frozen=True)
class ScenePlace:
    """One thing that is wrong with a scene.

    Attributes
    ----------
    path : str
        The value concerned, as `Scene.set` takes it; may be empty.
    message : str
        What is wrong: the value and the bound.
    help : str or None
        What could be meant instead.
    file : str or None
        The file, or ``--set`` for a value that was set.
    line, column : int or None
        Where in the file, from 1.
    """

    path: str
    message: str
    help: str | None
    file: str | None
    line: int | None
    column: int | None


class SceneError(CulletError, ValueError):
    """A scene or a sweep is wrong. `places` has everything that is wrong with it.

    Attributes
    ----------
    places : list of ScenePlace
        One for each error, in the order of the text.
    """

    def __init__(self, message: str, places: list[ScenePlace] | None = None) -> None:
        super().__init__(message)
        self.places = places or []

    @classmethod
    def _of(cls, said: Any) -> SceneError:
        text, places = said
        return cls(text, [ScenePlace(**place) for place in places])


class RunError(CulletError, RuntimeError):
    """A run has no result: workers do not start, the world broke down, or a job was given up.

    What was recorded until then is in ``run.mcap.partial``, which `Recording` reads.
    """


class RecordingError(CulletError):
    """A recording cannot be read, drawn or exported."""


class ClientError(CulletError, ConnectionError):
    """A farm is silent, refuses, or does not know a run."""
