#!/usr/bin/env python3
"""Runs notebooks from their first cell to their last: run.py NOTEBOOK… [--out DIR]

Each runs in a folder of its own, gone afterwards. With --out the notebooks are written there with what their cells
printed and drew. An error in a cell ends it with that cell's text.
"""

import argparse
import sys
import tempfile
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient

LONGEST = 300
"""Longest time for a cell [s]."""


def main() -> int:
    words = argparse.ArgumentParser()
    words.add_argument("notebooks", nargs="+", type=Path)
    words.add_argument("--out", type=Path)
    chosen = words.parse_args()
    for path in chosen.notebooks:
        since = time.monotonic()
        book = nbformat.read(path, as_version=4)
        with tempfile.TemporaryDirectory() as folder:
            NotebookClient(book, timeout=LONGEST, resources={"metadata": {"path": folder}}).execute()
        pictures = sum("image/png" in str(cell.get("outputs", "")) for cell in book.cells)
        if pictures == 0:
            print(f"{path.name}: no cell draws anything", file=sys.stderr)
            return 1
        if chosen.out:
            chosen.out.mkdir(parents=True, exist_ok=True)
            nbformat.write(book, chosen.out / path.name)
        print(f"{path.name}: {len(book.cells)} cells, {pictures} pictures, {time.monotonic() - since:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
