"""Builds the wheel: maturin's backend, after the program `cullet` is built and laid beside the module.

A wheel that maturin makes holds one Rust artifact, the module. The program is a script of the wheel, which maturin
takes from `wheel-data/scripts`. What both are made of is built once: its features are the same. There is no source
distribution, for the wheel is built from the whole workspace.
"""

import json
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


def target_folder() -> pathlib.Path:
    """Where cargo builds, as it says itself: the environment or a configuration of it may name another folder."""
    call = ["cargo", "metadata", "--format-version", "1", "--no-deps"]
    said = subprocess.run(call, cwd=ROOT, check=True, stdout=subprocess.PIPE)
    return pathlib.Path(json.loads(said.stdout)["target_directory"])


def lay_program() -> None:
    """Builds the program and lays it where maturin looks for scripts."""
    target = target_folder()
    # Of both builds, whatever folder they are started in.
    os.environ["CARGO_TARGET_DIR"] = str(target)
    subprocess.run(["cargo", "build", "--release", "--locked", "-p", "cullet"], cwd=ROOT, check=True)
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
