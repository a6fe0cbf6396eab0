#!/usr/bin/env python3
"""Packs the extension for Blender with Cullet's wheel in it: package.py WHEEL OUT.zip

Blender installs the file from Edit, Preferences, Get Extensions, Install from Disk. A wheel is of one kind of machine,
and so is the extension.
"""

import sys
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent / "cullet_blender"


def main(wheel: Path, out: Path) -> int:
    manifest = (HERE / "blender_manifest.toml").read_text(encoding="utf-8")
    named = manifest.replace("wheels = []", f'wheels = ["./wheels/{wheel.name}"]')
    if named == manifest:
        raise SystemExit("the manifest has no line `wheels = []`")
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("blender_manifest.toml", named)
        for path in sorted(HERE.glob("*.py")):
            packed.write(path, path.name)
        packed.write(wheel, f"wheels/{wheel.name}")
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
