"""The program `cullet` that came with this package."""

from __future__ import annotations

import os
import sysconfig
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path


# What the wheel is called for an installer: `cullet` on the Python Package Index is another program.
DISTRIBUTION = "cullet-sim"


def program() -> Path:
    """The program `cullet` of this package: worker processes are started with it.

    Raises
    ------
    FileNotFoundError
        The package was not installed as a wheel.
    """
    name = "cullet" + (sysconfig.get_config_var("EXE") or "")
    try:
        # What the installer says it laid down.
        listed = [Path(str(entry.locate())) for entry in files(DISTRIBUTION) or [] if entry.name == name]
    except PackageNotFoundError:
        listed = []
    folders = [Path(sysconfig.get_path("scripts"))]
    if os.name == "posix":
        folders.append(Path(sysconfig.get_path("scripts", scheme="posix_user")))
    # The program of another version may lie in the folders of scripts.
    candidates = listed or [folder / name for folder in folders]
    # With `--target` the scripts lie in a folder beside the package.
    candidates.append(Path(__file__).resolve().parent.parent / "bin" / name)
    for candidate in candidates:
        if candidate.is_file() and os.access(candidate, os.X_OK):
            return candidate
    places = ", ".join(str(candidate.parent) for candidate in candidates)
    raise FileNotFoundError(f"there is no program {name} in {places}; install the wheel of {DISTRIBUTION}")
