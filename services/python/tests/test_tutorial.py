"""The tutorial works when it is followed to the letter."""

import contextlib
import io
import os
import re
import unittest

from common import ROOT, folder


class Tutorial(unittest.TestCase):
    def test_the_tutorial_runs_from_its_first_line_to_its_last(self) -> None:
        page = (ROOT / "docs" / "tutorials" / "python.md").read_text(encoding="utf-8")
        blocks = re.findall(r"```python\n(.*?)```(?:\n+```\n(.*?)```)?", page, flags=re.S)
        self.assertGreaterEqual(len(blocks), 5)
        names: dict[str, object] = {}
        before = os.getcwd()
        os.chdir(folder())
        try:
            for code, shown in blocks:
                said = io.StringIO()
                with contextlib.redirect_stdout(said):
                    exec(compile(code, "docs/tutorials/python.md", "exec"), names)
                if shown:
                    self.assertEqual(said.getvalue(), shown)
            self.assertTrue(os.path.isfile("drop.png") and os.path.isfile("runs/drop-1/run.mcap"))
        finally:
            os.chdir(before)


if __name__ == "__main__":
    unittest.main()
