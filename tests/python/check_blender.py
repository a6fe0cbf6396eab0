#!/usr/bin/env python3
"""Imports an exported GLB into Blender and compares it with its recording.

    python3.11 -m venv target/bpy-venv
    target/bpy-venv/bin/pip install bpy==5.0.1 mcap==1.6.0 mcap-protobuf-support==0.6.0
    target/bpy-venv/bin/python tests/python/check_blender.py run.glb run.mcap

An object for each body; at 20 random times as many visible as the recording has; at 20 random
frames every transform within 1e-5. Takes 350 MB of download, so .ci/run leaves it out.
"""

import random
import sys

import bpy

from check_export import at, read_recording


def main(glb, recording):
    bodies, step = read_recording(recording)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    fps = scene.render.fps / scene.render.fps_base
    bpy.ops.import_scene.gltf(filepath=glb)
    # A body that is deformed has an object for each of its shapes, of which one is visible at a time.
    objects = {}
    for o in scene.objects:
        if o.type == "MESH" and "id" in o:
            objects.setdefault(o["id"], []).append(o)
    visible = lambda o: o.matrix_world.to_scale().length > 0.5
    complaints = []
    if set(objects) != set(bodies):
        complaints.append(f"{len(objects)} objects for {len(bodies)} bodies")
    last = max(row[0] for body in bodies.values() for row in body["rows"])
    draw, worst = random.Random(7), 0.0
    for _ in range(20):
        time = draw.uniform(0, last)
        scene.frame_set(int(time * fps), subframe=time * fps % 1)
        seen = [i for i, shapes in objects.items() for o in shapes if visible(o)]
        there = [i for i, body in bodies.items() if at(body, time, step)]
        if sorted(seen) != sorted(there):
            complaints.append(f"{time} s: {len(seen)} are visible, {len(there)} recorded")
        frame = draw.randint(0, int(last * fps))
        scene.frame_set(frame)
        for i, o in [(i, o) for i, shapes in objects.items() for o in shapes if visible(o)]:
            pose = at(bodies[i], frame / fps, step)
            if pose is None:
                continue
            place, turn, _ = o.matrix_world.decompose()
            turn = [turn.x, turn.y, turn.z, turn.w]
            sign = 1 if sum(a * b for a, b in zip(turn, pose[1])) >= 0 else -1
            off = [abs(a - b) for a, b in zip(place, pose[0])]
            off += [abs(a - sign * b) for a, b in zip(turn, pose[1])]
            worst = max(worst, *off)
    print(f"{glb}: {len(objects)} objects, transforms within {worst:.1e}")
    if worst > 1e-5:
        complaints.append(f"a transform is {worst} from the recording")
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]))
