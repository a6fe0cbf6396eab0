#!/usr/bin/env python3
"""Checks exported files with programs that this project did not write.

    pip install usd-core==26.11 mcap==1.6.0 mcap-protobuf-support==0.6.0
    npm install --prefix target/ci-node gltf-validator@2.0.0-dev.3.10
    python tests/python/check_export.py --node target/ci-node run.glb run.usda pieces/*.glb

A GLB must have no error and no warning of Khronos's glTF validator; USD none of `usdchecker`'s
validators. With `--recording run.mcap`, the USD must say of every body what the recording says:
how many are visible at random times, and where. Exit code 0: all hold; 1: some do not, each named
on stderr.
"""

import argparse
import bisect
import json
import math
import os
import pathlib
import random
import subprocess
import sys

VALIDATE = """
const fs = require('fs'), validator = require('gltf-validator');
(async () => {
  const all = {};
  for (const file of process.argv.slice(1)) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)),
      { maxIssues: 0 });
    all[file] = { errors: report.issues.numErrors, warnings: report.issues.numWarnings,
      first: report.issues.messages.filter(m => m.severity < 2).slice(0, 3) };
  }
  console.log(JSON.stringify(all));
})();
"""


def validate_glb(files, node):
    """Complaints of the glTF validator."""
    modules = pathlib.Path(node).resolve() / "node_modules"
    done = subprocess.run(["node", "-e", VALIDATE, *files], check=True, capture_output=True,
                          text=True, env={**os.environ, "NODE_PATH": str(modules)})
    for file, found in json.loads(done.stdout).items():
        print(f"{file}: {found['errors']} errors, {found['warnings']} warnings")
        if found["errors"] or found["warnings"]:
            yield f"{file}: {json.dumps(found)}"


def validate_usd(files):
    """Complaints of all validators that usd-core has."""
    from pxr import Usd, UsdValidation

    registry = UsdValidation.ValidationRegistry()
    names = [one.name for one in registry.GetAllValidatorMetadata()]
    validators = registry.GetOrLoadValidatorsByName(names)
    context = UsdValidation.ValidationContext(validators)
    for file in files:
        stage = Usd.Stage.Open(file)
        errors = context.Validate(stage)
        print(f"{file}: {len(errors)} complaints of {len(validators)} validators")
        for error in errors[:5]:
            yield f"{file}: {error.GetName()}: {error.GetMessage()}"


def read_recording(path):
    """Bodies with birth, end and rows: (time, position, rotation x y z w)."""
    from mcap.reader import make_reader
    from mcap_protobuf.decoder import DecoderFactory

    bodies, step = {}, None
    with open(path, "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        step = [float(m.metadata["step"]) for m in reader.iter_metadata() if m.name == "run"][0]
        topics = ["/body", "/bodies", "/events"]
        for _, channel, _, message in reader.iter_decoded_messages(topics=topics):
            if channel.topic == "/body":
                bodies[message.id] = {"rows": [], "end": float("inf")}
            elif channel.topic == "/bodies":
                for i, body in enumerate(message.ids):
                    place = message.positions[3 * i : 3 * i + 3]
                    turn = message.rotations[4 * i : 4 * i + 4]
                    bodies[body]["rows"].append((message.time, place, turn))
            elif message.kind in (5, 7):
                bodies[message.body]["end"] = message.time
    return bodies, step


def at(body, time, step):
    """Where a body is at a time; it moves evenly between steps. None: it is not there."""
    rows = body["rows"]
    k = bisect.bisect_right(rows, time, key=lambda row: row[0]) - 1
    if k < 0 or time >= body["end"]:
        return None
    if k + 1 == len(rows):
        return rows[k][1:]
    leaves = max(rows[k][0], rows[k + 1][0] - step)
    share = min(max((time - leaves) / (rows[k + 1][0] - leaves), 0), 1)
    place = [p + share * (q - p) for p, q in zip(rows[k][1], rows[k + 1][1])]
    return place, slerp(rows[k][2], rows[k + 1][2], share)


def slerp(near, far, share):
    """The rotation at a share of the way, on the shortest way."""
    cosine = sum(a * b for a, b in zip(near, far))
    if cosine < 0:
        far, cosine = [-q for q in far], -cosine
    angle = math.acos(min(cosine, 1))
    if angle < 1e-9:
        return near
    weights = math.sin((1 - share) * angle) / math.sin(angle), math.sin(share * angle) / math.sin(angle)
    return [weights[0] * p + weights[1] * q for p, q in zip(near, far)]


def compare_usd(file, recording):
    """At random times as many bodies are visible as the recording has, at the frames where it says."""
    from pxr import Usd, UsdGeom

    bodies, step = read_recording(recording)
    stage = Usd.Stage.Open(file)
    # A body that is deformed has a prim for each of its shapes, of which one is visible at a time.
    prims = {}
    for prim in stage.Traverse():
        if prim.HasAttribute("userProperties:id"):
            prims.setdefault(prim.GetAttribute("userProperties:id").Get(), []).append(prim)
    if set(prims) != set(bodies):
        yield f"{file}: {len(prims)} prims for {len(bodies)} bodies"
    fps, last = stage.GetTimeCodesPerSecond(), stage.GetEndTimeCode()
    draw = random.Random(7)
    visible_at = lambda prim, frame: (
        UsdGeom.Imageable(prim).ComputeVisibility(frame) == "inherited"
        and abs(UsdGeom.Xformable(prim).GetLocalTransformation(frame).GetDeterminant()) > 0.5)
    worst = 0.0
    for _ in range(20):
        frame = draw.uniform(0, last)
        there = {i for i, body in bodies.items() if at(body, frame / fps, step)}
        seen = [i for i, shapes in prims.items() for prim in shapes if visible_at(prim, frame)]
        if sorted(seen) != sorted(there):
            yield f"{file}: frame {frame}: {len(seen)} bodies are visible, {len(there)} recorded"
        frame = draw.randint(0, int(last))
        for i, body in bodies.items():
            pose = at(body, frame / fps, step)
            if pose is None or i not in prims:
                continue
            shown = [prim for prim in prims[i] if visible_at(prim, frame)]
            if not shown:
                worst = max(worst, 1.0)
                continue
            matrix = UsdGeom.Xformable(shown[0]).GetLocalTransformation(frame)
            place, turn = matrix.ExtractTranslation(), matrix.ExtractRotationQuat()
            turn = [*turn.GetImaginary(), turn.GetReal()]
            sign = 1 if sum(a * b for a, b in zip(turn, pose[1])) >= 0 else -1
            off = [abs(a - b) for a, b in zip(place, pose[0])]
            off += [abs(a - sign * b) for a, b in zip(turn, pose[1])]
            worst = max(worst, *off)
    print(f"{file}: poses within {worst:.1e} of {recording}")
    if worst > 1e-5:
        yield f"{file}: a pose is {worst} from the recording"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="+")
    parser.add_argument("--node", help="folder with node_modules/gltf-validator")
    parser.add_argument("--recording", help="run.mcap that the USD files were exported from")
    arguments = parser.parse_args()
    glb = [file for file in arguments.files if file.endswith(".glb")]
    usd = [file for file in arguments.files if file.endswith(".usda")]
    complaints = []
    if glb:
        complaints += validate_glb(glb, arguments.node)
    if usd:
        complaints += validate_usd(usd)
    if arguments.recording:
        for file in usd:
            complaints += compare_usd(file, arguments.recording)
    for complaint in complaints[:50]:
        print(complaint, file=sys.stderr)
    sys.exit(1 if complaints else 0)


if __name__ == "__main__":
    main()
