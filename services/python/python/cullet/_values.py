"""Values of Python as TOML, for scenes and for what is set in them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, Union

import numpy as np

Settings = Union[Mapping[str, Any], Iterable[str], None]
"""What is set in a scene: `{"world.seed": 7}`, or arguments as `cullet run --set` takes them."""

_ESCAPES = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r", "\b": "\\b", "\f": "\\f"}


def _text(value: str) -> str:
    def one(c: str) -> str:
        if c in _ESCAPES:
            return _ESCAPES[c]
        return f"\\u{ord(c):04x}" if ord(c) < 32 or ord(c) == 127 else c

    return '"' + "".join(map(one, value)) + '"'


def _key(key: str) -> str:
    bare = key.isascii() and key.replace("-", "_").isidentifier()
    return key if bare else _text(key)


def toml(value: Any) -> str:
    """A value as TOML writes it: text, number, boolean, list or table.

    Raises
    ------
    ValueError
        A number that is not finite.
    TypeError
        Something that TOML has no word for.
    """
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{value} is no number of a scene")
        return repr(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(str(k))} = {toml(v)}" for k, v in value.items() if v is not None) + " }"
    if isinstance(value, Iterable):
        return "[" + ", ".join(map(toml, value)) + "]"
    raise TypeError(f"a scene has no value such as {value!r}")


def settings(values: Settings) -> list[str]:
    """What is set, as `path=value` arguments."""
    if values is None:
        return []
    if isinstance(values, Mapping):
        return [f"{path}={toml(value)}" for path, value in values.items()]
    if isinstance(values, str):
        return [values]
    return list(values)


def document(tables: Mapping[str, Any]) -> str:
    """Tables as a TOML document: lists of mappings become `[[name]]`, mappings `[name]`, anything else a key."""
    heads: list[str] = []
    parts: list[str] = []
    for name, value in tables.items():
        if isinstance(value, Mapping):
            parts.append(_table(f"[{_key(name)}]", value))
        elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            parts.extend(_table(f"[[{_key(name)}]]", item) for item in value)
        elif value is not None:
            heads.append(f"{_key(name)} = {toml(value)}")
    return "\n\n".join(["\n".join(heads), *parts] if heads else parts) + "\n"


def _table(head: str, table: Mapping[str, Any]) -> str:
    rows = (f"{_key(str(key))} = {toml(value)}" for key, value in table.items() if value is not None)
    return "\n".join([head, *rows])
