"""Tables of columns."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]

_SHOWN = 20
"""Most rows that a table prints."""


class Table:
    """Columns of equal length, by name.

    A column is a numpy array: `table["mass"]` or `table.mass`. A slice, a list of row numbers or an array of booleans
    selects rows: `table[table.mass > 1]` is a table too. Iterating gives a dictionary for each row.
    ``pandas.DataFrame(table.columns)`` works where every column has one number a row.
    """

    def __init__(self, columns: dict[str, Array], units: dict[str, str] | None = None) -> None:
        lengths = {len(column) for column in columns.values()}
        if len(lengths) > 1:
            raise ValueError(f"columns of different lengths: {sorted(lengths)}")
        self.columns = columns
        self.units = units or {}

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()))) if self.columns else 0

    def __getattr__(self, name: str) -> Array:
        columns: dict[str, Array] = self.__dict__.get("columns", {})
        if name in columns:
            return columns[name]
        raise AttributeError(f"there is no column {name!r}; there are {', '.join(columns)}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.columns]

    def __getitem__(self, which: Any) -> Any:
        if isinstance(which, str):
            return self.columns[which]
        if isinstance(which, int | np.integer):
            return {name: column[which] for name, column in self.columns.items()}
        return Table({name: column[which] for name, column in self.columns.items()}, self.units)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return (self[row] for row in range(len(self)))

    def _heads(self) -> list[str]:
        return [f"{name} [{self.units[name]}]" if name in self.units else name for name in self.columns]

    def _rows(self) -> list[list[str]]:
        def cell(value: Any) -> str:
            if isinstance(value, np.ndarray):
                return " ".join(f"{x:.4g}" for x in value.ravel())
            return f"{value:.4g}" if isinstance(value, float | np.floating) else str(value)

        return [[cell(value) for value in self[row].values()] for row in range(min(len(self), _SHOWN))]

    def __repr__(self) -> str:
        grid = [self._heads(), *self._rows()]
        widths = [max(map(len, column)) for column in zip(*grid, strict=True)]
        lines = ["  ".join(c.rjust(w) for c, w in zip(row, widths, strict=True)) for row in grid]
        more = [f"… {len(self) - _SHOWN} more rows"] if len(self) > _SHOWN else []
        return "\n".join([*lines, *more])

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{escape(name)}</th>" for name in self._heads())
        rows = "".join("<tr>" + "".join(f"<td>{escape(c)}</td>" for c in row) + "</tr>" for row in self._rows())
        more = f"<p>… {len(self) - _SHOWN} more rows</p>" if len(self) > _SHOWN else ""
        return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>{more}"


def table(raw: dict[str, Any], kinds: dict[str, tuple[str, int, str]]) -> Table:
    """A table of columns as they come from Rust: bytes or texts. `kinds`: dtype, numbers a row, unit."""
    columns: dict[str, Array] = {}
    units: dict[str, str] = {}
    for name, column in raw.items():
        if isinstance(column, bytes):
            kind, width, unit = kinds[name]
            columns[name] = numbers(column, kind, width)
            if unit:
                units[name] = unit
        else:
            columns[name] = np.array(column, dtype=np.str_)
    return Table(columns, units)


def numbers(column: bytes, kind: str, width: int = 1) -> Array:
    """Numbers from their bytes, read-only."""
    array: Array = np.frombuffer(column, dtype=np.dtype(kind).newbyteorder("<"))
    return array if width == 1 else array.reshape(-1, width)
