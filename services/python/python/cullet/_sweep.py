"""Sweeps: one scene with many settings, and what came of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ._recording import Recording
from ._table import Array, Table


@dataclass
class SweepRun:
    """A run of a sweep.

    Attributes
    ----------
    values : dict
        What was set, by path.
    recording : Recording or None
        What was recorded; nothing where the run has none.
    run : int or None
        Its number, at a farm.
    state : str
        How it ended.
    """

    values: dict[str, Any]
    recording: Recording | None
    run: int | None = None
    state: str = "done"


class Sweep:
    """The runs of a sweep, in the order of their values. Iterating gives each `SweepRun`."""

    def __init__(self, runs: list[SweepRun]) -> None:
        self.runs = runs

    def __len__(self) -> int:
        return len(self.runs)

    def __iter__(self) -> Iterator[SweepRun]:
        return iter(self.runs)

    def __getitem__(self, row: int) -> SweepRun:
        return self.runs[row]

    @property
    def table(self) -> Table:
        """A row a run: a column for each path, and `fractures`, `fragments`, `grains`, `bodies`, `sampled_mass` [1].

        `sampled_mass` is the share of the mass of fragments and grains that was sampled, and not solved. Runs without a recording
        have −1, or nan.
        """
        columns: dict[str, Array] = {}
        for path in self.runs[0].values if self.runs else {}:
            columns[path] = _column([run.values[path] for run in self.runs])
        counts = {"fractures": "fractures", "fragments": "fragments", "grains": "grains", "bodies": "bodies_final"}
        summaries = [run.recording.summary if run.recording else None for run in self.runs]
        for name, key in counts.items():
            columns[name] = np.array([summary[key] if summary else -1 for summary in summaries])
        shares = [(summary or {}).get("shares") for summary in summaries]
        columns["sampled_mass"] = np.array([share["sampled_mass"] if share else np.nan for share in shares])
        return Table(columns)

    def __repr__(self) -> str:
        return repr(self.table)

    def _repr_html_(self) -> str:
        return self.table._repr_html_()


def _column(values: list[Any]) -> Array:
    """Values of one key: numbers, lists of numbers, or words."""
    try:
        array: Array = np.array(values)
    except ValueError:
        array = np.array([str(value) for value in values])
    return array if array.dtype != object else np.array([str(value) for value in values])
