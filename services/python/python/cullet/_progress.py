"""How far a run is, while it runs: tqdm where it is installed, else a display in notebooks and a line in terminals."""

from __future__ import annotations

import html
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, Union


@dataclass(frozen=True)
class Progress:
    """How far a run is.

    Attributes
    ----------
    time, end : float
        Simulated time, and that at which it ends [s].
    bodies : int
        Bodies in the world.
    fractures : int
        Fractures so far.
    jobs : int
        Fracture jobs that it waits for.
    jobs_done : float
        How far those at workers are, in the mean [1]; 0 where none is.
    state : str
        `running` for a run on this machine; of a run at a farm any state of docs/protocol.md.
    lines : tuple of str
        New lines of the log, of a run at a farm.
    """

    time: float
    end: float
    bodies: int
    fractures: int
    jobs: int
    jobs_done: float = 0.0
    state: str = "running"
    lines: tuple[str, ...] = ()

    @property
    def share(self) -> float:
        """Share of the simulated time that is done [1]."""
        return min(1.0, self.time / self.end) if self.end > 0 else 0.0

    def __str__(self) -> str:
        text = f"{self.time:.3f} of {self.end:.3f} s, {self.bodies} bodies, {self.fractures} fractures"
        if self.state != "running":
            text = f"{self.state}: {text}"
        return f"{text}, waits for {self.jobs} jobs ({self.jobs_done:.0%})" if self.jobs else text


Told = Union[bool, Callable[[Progress], Any]]
"""Whether progress is shown, or who is told of it."""


class _Bar(Protocol):
    def show(self, progress: Progress) -> None: ...
    def done(self) -> None: ...


class _Tqdm:
    def __init__(self, tqdm: Any, name: str) -> None:
        form = "{desc}: {percentage:3.0f}%|{bar}| {n:.3f}/{total:.3f} s [{elapsed}{postfix}]"
        self.bar = tqdm(desc=name, total=1.0, bar_format=form)

    def show(self, progress: Progress) -> None:
        self.bar.total = progress.end
        self.bar.n = progress.time
        self.bar.set_postfix_str(f"{progress.bodies} bodies, {progress.fractures} fractures", refresh=True)

    def done(self) -> None:
        self.bar.close()


class _Notebook:
    def __init__(self, name: str, display: Any, page: Any) -> None:
        self.name, self.page = name, page
        self.handle = display(page(self._text("starts", 0.0)), display_id=True)

    def _text(self, text: str, share: float) -> str:
        return f"<progress value='{share:.4f}' max='1'></progress> {html.escape(f'{self.name}: {text}')}"

    def show(self, progress: Progress) -> None:
        self.handle.update(self.page(self._text(str(progress), progress.share)))

    def done(self) -> None:
        pass


class _Line:
    def __init__(self, name: str) -> None:
        self.name, self.width = name, 0

    def show(self, progress: Progress) -> None:
        line = f"{self.name}: {progress}"
        sys.stderr.write("\r" + line.ljust(self.width))
        sys.stderr.flush()
        self.width = len(line)

    def done(self) -> None:
        if self.width:
            sys.stderr.write("\n")


def _in_notebook() -> bool:
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and type(shell).__name__ == "ZMQInteractiveShell"


def _bar(name: str) -> _Bar | None:
    notebook = _in_notebook()
    if not notebook and not sys.stderr.isatty():
        return None
    try:
        from tqdm.auto import tqdm
    except ImportError:
        pass
    else:
        return _Tqdm(tqdm, name)
    if notebook:
        from IPython.display import HTML, display

        return _Notebook(name, display, HTML)
    return _Line(name)


class Shown:
    """Progress of one run as it is shown; a context manager.

    Nothing is shown where nobody looks: `progress=True` shows it in notebooks and terminals only.
    """

    PERIOD = 0.1
    """Shown no more often than this [s]."""

    def __init__(self, name: str, progress: Told) -> None:
        self.call = progress if callable(progress) else None
        self.bar = _bar(name) if progress is True else None
        self.last = 0.0

    @property
    def wanted(self) -> bool:
        """Whether anybody is told anything."""
        return self.call is not None or self.bar is not None

    def show(self, progress: Progress) -> None:
        """Tells whoever listens."""
        if self.call:
            self.call(progress)
        now = time.monotonic()
        if self.bar and (now - self.last >= self.PERIOD or progress.share >= 1.0):
            self.bar.show(progress)
            self.last = now

    def __enter__(self) -> Shown:
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar:
            self.bar.done()
