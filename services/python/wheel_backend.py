"""Builds the wheel: maturin's backend, after the program `cullet` is built and laid beside the module.

A wheel that maturin makes holds one Rust artifact, the module. The program is a script of the wheel, which maturin
takes from `wheel-data/scripts`. What both are made of is built once: its features are the same. There is no source
distribution, for the wheel is built from the whole workspace.
"""

import os
import pathlib
import shutil
import subprocess
from typing import Any

import maturin
from maturin import get_requires_for_build_editable, get_requires_for_build_wheel  # noqa: F401

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
SCRIPTS = HERE / "wheel-data" / "scripts"


def lay_program() -> None:
    """Builds the program and lays it where maturin looks for scripts."""
    subprocess.run(["cargo", "build", "--release", "--locked", "-p", "cullet"], cwd=ROOT, check=True)
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    name = "cullet.exe" if os.name == "nt" else "cullet"
    SCRIPTS.mkdir(parents=True, exist_ok=True)
    shutil.copy2(target / "release" / name, SCRIPTS / name)


def prepare_metadata_for_build_wheel(metadata_directory: str, config_settings: Any = None) -> str:
    # maturin wants the folder, if with nothing in it.
    SCRIPTS.mkdir(parents=True, exist_ok=True)
    return maturin.prepare_metadata_for_build_wheel(metadata_directory, config_settings)


def build_wheel(wheel_directory: str, config_settings: Any = None, metadata_directory: Any = None) -> str:
    lay_program()
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory: str, config_settings: Any = None, metadata_directory: Any = None) -> str:
    lay_program()
    return maturin.build_editable(wheel_directory, config_settings, metadata_directory)
