#!/usr/bin/env python3
"""Writes random meshes with another program in every format and variant, and compares volumes.

    pip install trimesh==5.2.0 numpy
    python tests/python/check_meshes.py target/release/cullet --scenes 8 --seed 1

Each random scene is some closed shapes apart from one another, under nested transformations. What
`cullet check` reads of each file must have the volume of the shapes within 1e-6, or 1e-4 where the
file holds numbers of few digits. Exit code 0: all hold; 1: some do not, each named on stderr.
"""

import argparse
import json
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile

import numpy as np
import trimesh

# So dense that four decimals of a mass are ten digits.
DENSITY = 20_000


def shape(rng):
    """A closed shape of about size 1."""
    size = [rng.uniform(0.3, 1.0) for _ in range(3)]
    kind = rng.randrange(6)
    if kind == 0:
        return trimesh.creation.box(extents=size)
    if kind == 1:
        return trimesh.creation.icosphere(subdivisions=rng.randrange(1, 4), radius=size[0] / 2)
    if kind == 2:
        return trimesh.creation.cylinder(size[0] / 2, size[1], sections=rng.randrange(3, 40))
    if kind == 3:
        return trimesh.creation.annulus(size[0] / 4, size[0] / 2, size[1])
    if kind == 4:
        return trimesh.creation.torus(0.4, 0.05 + 0.1 * size[0])
    return trimesh.creation.capsule(size[0], size[1] / 4)


def transform(rng, uneven):
    """A rotation with a scale, uneven or mirrored too if `uneven`."""
    matrix = trimesh.transformations.random_rotation_matrix(np.array([rng.random() for _ in range(3)]))
    scale = [rng.uniform(0.5, 2.0)] * 3
    if uneven:
        scale = [rng.choice([-1, 1]) * rng.uniform(0.5, 2.0) for _ in range(3)]
    return matrix @ np.diag([*scale, 1.0])


def scene_of(rng):
    """A scene of shapes apart from one another in nested frames, and the sum of their volumes."""
    scene, volume = trimesh.Scene(), 0.0
    unit = 10 ** rng.uniform(-2, 1)
    shared = shape(rng)
    for k in range(rng.randrange(1, 6)):
        mesh = shared if rng.random() < 0.3 else shape(rng)
        place = transform(rng, uneven=True)
        above = np.diag([unit, unit, unit, 1.0])
        above[:3, 3] = np.array([6.0 * k, rng.uniform(-1, 1), rng.uniform(-1, 1)]) * unit
        volume += abs(mesh.volume * np.linalg.det(place[:3, :3])) * unit**3
        name = f"frame {k}"
        scene.graph.update(frame_to=name, frame_from="world", matrix=above)
        scene.add_geometry(mesh, node_name=f"shape {k}", geom_name=f"mesh {k}",
                           parent_node_name=name, transform=place)
    return scene, volume


def one_mesh(scene):
    """The shapes as one mesh, all outward."""
    parts = []
    for name in scene.graph.nodes_geometry:
        matrix, geometry = scene.graph[name]
        part = scene.geometry[geometry].copy()
        part.apply_transform(matrix)
        if part.volume < 0:
            part.invert()
        parts.append(part)
    return trimesh.util.concatenate(parts)


def variants_of_obj(text, rng):
    """An OBJ file as other programs would have written it."""
    yield "obj", text.encode()
    yield "bom", ("\ufeff" + text).encode()
    yield "utf16", text.encode("utf-16")
    yield "latin1", b"# f\xfcr S\xe4ule\ng Stein \xe4\n" + text.encode()
    yield "crlf", text.replace("\n", "\r\n").encode()
    yield "cr", text.replace("\n", "\r").encode()
    yield "unnamed", b"mtllib\nusemtl\no\n" + text.encode()
    lines = text.splitlines()
    count = sum(line.startswith("v ") for line in lines)
    loose = [f"l {' '.join(str(rng.randrange(1, count + 1)) for _ in range(rng.randrange(2, 6)))}"
             for _ in range(5)] + ["p 1 2 3"]
    yield "loose", "\n".join(lines + loose).encode()
    faces = re.compile(r"^f (\S+) (\S+) (\S+)", re.M)
    yield "continued", faces.sub(r"f \1 \\\n   \2 \3", text).encode()

    def negative(match):
        return "f " + " ".join(str(int(part.split("/")[0]) - count - 1) for part in match.groups())

    yield "negative", faces.sub(negative, text).encode()
    colour = re.compile(r"^(v \S+ \S+ \S+)$", re.M)
    yield "colours", colour.sub(lambda m: m[1] + (" 1 0 0.5" if rng.random() < 0.5 else ""),
                                text).encode()


def variants_of_stl(mesh):
    binary, text = mesh.export(file_type="stl"), mesh.export(file_type="stl_ascii")
    yield "binary", binary
    yield "header", b"solid of a program that begins so".ljust(80) + binary[80:]
    yield "trailing", binary + b"\0" * 7
    yield "text", text.encode()
    yield "nameless", re.sub("(?m)^solid.*$", "solid", text).encode()
    yield "capitals", text.upper().encode()
    yield "crlf", text.replace("\n", "\r\n").encode()
    yield "empty-first", b"solid nothing\nendsolid nothing\n" + text.encode()
    triangles = text.split("endfacet")
    half = len(triangles) // 2
    two = "endfacet".join(triangles[:half]) + "endfacet\nendsolid a\nsolid b\n"
    yield "two-solids", (two + "endfacet".join(triangles[half:])).encode()


def variants_of_ply(mesh):
    binary = mesh.export(file_type="ply")
    text = mesh.export(file_type="ply", encoding="ascii")
    yield "binary", binary
    yield "text", text
    yield "crlf", text.replace(b"\n", b"\r\n")
    yield "odd-header", text.replace(b"format ascii 1.0\n", b"format ascii 1.0\nexported by hand\n")


def write(folder, number, rng):
    """Writes one random scene in every variant: (file, volume, tolerance)."""
    scene, volume = scene_of(rng)
    mesh = one_mesh(scene)

    def put(name, data, tolerance):
        path = folder / f"{number}-{name}"
        path.write_bytes(data)
        return path.name, volume, tolerance

    for digits in (8, 17):
        text = mesh.export(file_type="obj", digits=digits, include_normals=digits == 8)
        for name, data in variants_of_obj(text, rng):
            yield put(f"{name}-{digits}.obj", data, 1e-4 if digits == 8 else 1e-6)
    for name, data in variants_of_stl(mesh):
        yield put(f"{name}.stl", data, 1e-4)
    for name, data in variants_of_ply(mesh):
        yield put(f"{name}.ply", data, 1e-4)
    # In f32, as glTF holds it.
    yield put("scene.glb", scene.export(file_type="glb"), 1e-4)
    mixed = scene.copy()
    line = trimesh.path.Path3D(entities=[trimesh.path.entities.Line([0, 1, 2])],
                               vertices=np.array([[0, 0, 0], [1, 1, 1], [2, 0, 1.0]]))
    mixed.add_geometry(line, geom_name="line")
    mixed.add_geometry(trimesh.PointCloud([[0, 0, 0], [1, 0, 1.0]]), geom_name="points")
    yield put("loose.glb", mixed.export(file_type="glb"), 1e-4)
    for inside in (False, True):
        name = "inside" if inside else "beside"
        home = folder / f"{number}-{name}"
        home.mkdir()
        for file, data in scene.export(file_type="gltf", embed_buffers=inside).items():
            (home / file).write_bytes(data)
        yield f"{home.name}/model.gltf", volume, 1e-4


def read(cullet, folder, files):
    """The mass of each body of a scene that has each file as a body, as `cullet check` tells it."""
    lines = ['[[material]]\nname = "heavy"\npreset = "plaster"\n' f"density = {DENSITY}\n"]
    for k, (file, _, _) in enumerate(files):
        lines.append(f'[[body]]\nname = "b{k}"\nmesh = {json.dumps(file)}\nmaterial = "heavy"\n'
                     f"fixed = true\nposition = [0, {1_000.0 * k}, 0]\n")
    scene = folder / "scene.toml"
    scene.write_text("\n".join(lines))
    done = subprocess.run([cullet, "check", str(scene)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{cullet} check {scene}: {done.stdout}{done.stderr}")
    masses = re.findall(r"^  b(\d+): heavy, ([\d.]+) kg", done.stdout, re.M)
    return {int(k): float(mass) for k, mass in masses}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cullet", help="the program")
    parser.add_argument("--scenes", type=int, default=8, help="random scenes (8)")
    parser.add_argument("--seed", type=int, default=1, help="of the random numbers (1)")
    args = parser.parse_args()
    cullet, wrong, count = str(pathlib.Path(args.cullet).resolve()), 0, 0
    for number in range(args.scenes):
        rng = random.Random(1000 * args.seed + number)
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            files = list(write(folder, number, rng))
            masses = read(cullet, folder, files)
            for k, (file, volume, tolerance) in enumerate(files):
                count += 1
                ratio = masses.get(k, math.nan) / DENSITY / volume
                if not abs(ratio - 1) <= tolerance:
                    wrong += 1
                    print(f"{file}: {ratio} of the volume, {volume:g} m³", file=sys.stderr)
    print(f"{count} files of {args.scenes} scenes, {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
