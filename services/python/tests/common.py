"""What the tests share: a small scene and a run of it."""

import functools
import tempfile
from pathlib import Path

import cullet

ROOT = Path(__file__).resolve().parents[3]

DROP = """
description = "A plaster ball falls onto a floor"
world = { duration = 0.06, seed = 3, impulse_threshold = 0.05 }
fracture = { solver = "geometric" }
[[body]]
name = "floor"
shape = { kind = "box", size = [4, 4, "20 cm"] }
position = [0, 0, "-10 cm"]
material = "granite"
fixed = true
[[body]]
name = "ball"
shape = { kind = "sphere", radius = "6 cm" }
position = [0, 0, "16 cm"]
velocity = [0, 0, -8]
material = "plaster"
"""

_folder = tempfile.TemporaryDirectory()


def folder() -> Path:
    """A folder that nobody else has, gone at the end."""
    return Path(tempfile.mkdtemp(dir=_folder.name))


@functools.cache
def drop() -> cullet.Recording:
    """A run of DROP, in which the ball is taken apart into sampled pieces."""
    scene = cullet.Scene.from_text(DROP, name="drop")
    return cullet.run(scene, folder() / "drop", workers=2, progress=False)


@functools.cache
def solved() -> cullet.Recording:
    """A run of DROP in which the ball is solved: into pieces solved and sampled, and grains."""
    scene = cullet.Scene.from_text(DROP, name="solved")
    scene = scene.set({"fracture.solver": "brittle", "fracture.max_particles": 8000, "body.ball.velocity": [0, 0, -10]})
    return cullet.run(scene, folder() / "solved", workers=1, progress=False)
