#!/usr/bin/env python3
"""Reads a run with a reader that this project did not write, and checks what it finds.

    pip install mcap==1.6.0 mcap-protobuf-support==0.6.0 rerun-sdk==0.41.0 grpcio-tools==1.85.1
    python tests/python/read_run.py runs/pot-1/run.mcap [--summary runs/pot-1/summary.json]
        [--proto proto/recording.proto]
    rerun mcap check runs/pot-1/run.mcap

Every message is decoded by the schema embedded in the file; with --proto the first of each topic of
Cullet's own also by that file, which protoc compiles. Exit code 0: all checks hold; 1: some do not, each named on
stderr. `rerun mcap check` exits with 0 if the structure of the file is sound.
"""

import argparse
import collections
import hashlib
import importlib
import json
import os
import struct
import sys
import tempfile

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

ALWAYS = ("/tf", "/log", "/geometry", "/body", "/bodies", "/events", "/stats", "/fragments")
SCHEMAS = {
    "/tf": "foxglove.FrameTransforms",
    "/log": "foxglove.Log",
    "/fragments": "foxglove.PointCloud",
    "/geometry": "cullet.Geometry",
    "/body": "cullet.Body",
    "/shape": "cullet.NewShape",
    "/bodies": "cullet.BodyPoses",
    "/debris": "cullet.Grains",
    "/cracks": "cullet.Cracks",
    "/sampled": "cullet.Sampled",
    "/appearance": "cullet.Appearance",
    "/joints": "cullet.BodyJoint",
    "/events": "cullet.RunEvent",
    "/jobs": "cullet.JobReport",
    "/pool": "cullet.PoolReport",
    "/stats": "cullet.RunStats",
    "/sheets/surface": "cullet.SheetSurface",
    "/sheets": "cullet.SheetFrame",
    "/windows": "cullet.SheetWindow",
}
FRACTURED = 5
REMOVED = 7
JOINT_BROKEN, JOINT_GONE = 11, 12


class Run:
    """What a pass over the messages gathers and complains about."""

    def __init__(self):
        self.complaints = []
        self.counts = collections.Counter()
        self.solids = set()
        self.bodies = {}
        self.alive = set()
        self.posed = set()
        self.fractures = 0
        self.drawn = collections.Counter()
        self.grains = {}
        self.fall, self.step = None, None
        self.compiled = None
        self.surfaces = {}
        self.framed, self.solved = {}, {}
        self.joints = set()

    def want(self, holds, text):
        if not holds:
            self.complaints.append(text)

    def take(self, schema, channel, message, decoded):
        topic = channel.topic
        wanted = "foxglove.SceneUpdate" if topic.startswith("/scene/") else SCHEMAS.get(topic)
        self.want(schema.name == wanted, f"{topic} carries {schema.name}, not {wanted}")
        self.want(message.sequence == self.counts[topic], f"{topic}: sequence {message.sequence}")
        self.counts[topic] += 1
        few = self.counts[topic] <= 20
        if self.compiled and few and schema.name.startswith("cullet."):
            self.by_file(schema.name, message.data, decoded)
        if topic.startswith("/scene/"):
            self.scene(topic, decoded)
        elif handler := getattr(self, f"on_{topic[1:].replace('/', '_')}", None):
            handler(decoded)

    def by_file(self, name, data, decoded):
        """A message says the same by the shipped file as by the embedded schema."""
        kind = getattr(self.compiled, name.removeprefix("cullet."), None)
        read = kind.FromString(data) if kind else None
        self.want(str(read) == str(decoded), f"{name} is another message by the shipped file")

    def on_geometry(self, solid):
        self.want(solid.hash not in self.solids, "a geometry is recorded twice")
        self.solids.add(solid.hash)
        self.want(len(solid.hash) == 32, "a digest is not 32 bytes")
        self.want(len(solid.triangles) == 3 * len(solid.crack), "one tag a triangle")
        interior = len(solid.interior_vertex)
        self.want(len(solid.corner) == 3 * sum(solid.crack), "three corners a crack triangle")
        self.want(not solid.corner or max(solid.corner) < interior, "a corner without a vertex")
        columns = (solid.damage_time, solid.front_speed, solid.parent, solid.material)
        self.want(all(len(c) == interior for c in columns), "one value an interior vertex")
        self.want(len(solid.uv) == 2 * interior, "two coordinates an interior vertex")
        self.want(all(solid.material), "an interior vertex without a material")
        self.want(max(solid.triangles) < len(solid.vertices) // 3, "a triangle without a corner")

    def on_cracks(self, cracks):
        count = len(cracks.vertices) // 3
        self.want(cracks.body in self.alive, f"cracks of body {cracks.body}, which is not there")
        self.want(len(cracks.vertices) == 3 * count, "a crack with a part of a vertex")
        self.want(len(cracks.triangles) % 3 == 0, "a crack with a part of a triangle")
        self.want(max(cracks.triangles) < count, "a crack triangle without a corner")
        columns = (cracks.damage_time, cracks.front_speed)
        self.want(all(len(c) == count for c in columns), "one value a vertex of a crack")

    def on_sampled(self, sampled):
        self.want(sampled.body in self.bodies, f"fragments of body {sampled.body}, never born")
        told = set(sampled.fragments)
        self.want(told <= set(self.bodies), "a fragment that was sampled and never born")
        self.want(len(told) == len(sampled.fragments), "a fragment is told as sampled twice")
        directed = set(sampled.directed)
        self.want(directed <= set(self.bodies), "a fragment that was directed and never born")
        self.want(not directed & told, "a fragment is told as sampled and as directed")

    def on_appearance(self, look):
        self.want(set(look.bodies) <= set(self.bodies), "the appearance of a body never born")
        corners = len(look.triangles)
        self.want(corners % 3 == 0, "an appearance with a part of a triangle")
        self.want(max(look.triangles) < len(look.vertices) // 3, "an appearance without a corner")
        for column, width, values in [
            (look.uv_corner, 2, look.uv),
            (look.normal_corner, 3, look.normals),
        ]:
            self.want(len(column) in (0, corners), "one value a corner of an appearance")
            self.want(max(column, default=-1) < len(values) // width, "a corner without a value")
        for column, names in [(look.slots, look.materials), (look.objects, look.object_names)]:
            self.want(len(column) in (0, corners // 3), "one value a triangle of an appearance")
            self.want(max(column, default=-1) < len(names), "a triangle of a name that is not there")

    def on_body(self, body):
        self.want(body.geometry in self.solids, f"body {body.id} comes before its geometry")
        self.want(body.id not in self.bodies, f"body {body.id} is born twice")
        self.bodies[body.id] = body
        self.alive.add(body.id)

    def on_shape(self, shape):
        self.want(shape.geometry in self.solids, f"body {shape.body} takes an unknown shape")
        self.want(shape.body in self.alive, f"body {shape.body} takes a shape, but is not there")
        self.want(shape.mass == self.bodies[shape.body].mass, f"body {shape.body} changes its mass")

    def on_bodies(self, poses):
        n = len(poses.ids)
        columns = [poses.positions, poses.rotations, poses.velocities, poses.spins]
        widths = [len(column) for column in columns]
        self.want(widths == [3 * n, 4 * n, 3 * n, 3 * n], f"step {poses.step}: odd columns")
        self.want(set(poses.ids) <= self.alive, f"step {poses.step}: a pose of a body not alive")
        self.posed.update(poses.ids)
        for i in range(n):
            q = poses.rotations[4 * i : 4 * i + 4]
            self.want(abs(sum(c * c for c in q) - 1) < 1e-9, f"step {poses.step}: not a rotation")

    def on_debris(self, told):
        """Follows every grain to the last bit, and holds the rounded rows to it."""
        # Recordings of before have all rows in `ids`.
        flying = list(getattr(told, "flying", []))
        places, speeds = (getattr(told, f"flown_{kind}", []) for kind in ("positions", "velocities"))
        n, widths = len(told.ids), [len(told.positions), len(told.velocities)]
        self.want(widths == [3 * n] * 2, f"step {told.step}: odd columns of grains")
        widths = [len(places), len(speeds)]
        self.want(widths == [3 * len(flying)] * 2, f"step {told.step}: odd columns of grains")
        born = [len(column) for column in (told.masses, told.sizes, told.parents)]
        self.want(born in ([0] * 3, [n] * 3), f"step {told.step}: a grain born in part")
        for i, grain in enumerate(flying):
            self.want(grain in self.grains, f"grain {grain} flies and was never born")
            at, v = self.grains.get(grain, ([0.0] * 3, [0.0] * 3))
            v = [a + b for a, b in zip(v, self.fall)]
            at = [a + b * self.step for a, b in zip(at, v)]
            row = slice(3 * i, 3 * i + 3)
            near = [*places[row], *speeds[row]]
            self.want(list(struct.unpack("6f", struct.pack("6f", *at, *v))) == near,
                      f"step {told.step}: grain {grain} did not fly freely")
            self.grains[grain] = (at, v)
        for i, grain in enumerate(told.ids):
            row = slice(3 * i, 3 * i + 3)
            self.grains[grain] = (list(told.positions[row]), list(told.velocities[row]))

    def on_sheets_surface(self, surface):
        self.want(surface.hash not in self.surfaces, "a surface is recorded twice")
        self.want(len(surface.hash) == 32, "a digest is not 32 bytes")
        points = len(surface.reference) // 2
        self.want(len(surface.reference) == 2 * points, "a surface with a part of a point")
        self.want(len(surface.triangles) % 3 == 0, "a surface with a part of a triangle")
        self.want(max(surface.triangles, default=-1) < points, "a triangle without a point")
        self.surfaces[surface.hash] = points

    def on_sheets(self, frame):
        what = f"sheet {frame.sheet} at step {frame.step}"
        points = self.surfaces.get(frame.surface, -1)
        self.want(points >= 0, f"{what} comes before its surface")
        self.want(len(frame.offsets) == 3 * points, f"{what}: three offsets a point")
        self.want(len(frame.quantity) in (0, points), f"{what}: one quantity a point")
        self.want(self.framed.get(frame.sheet, -1) < frame.step, f"{what}: steps run back")
        self.framed[frame.sheet] = frame.step

    def on_windows(self, window):
        what = f"sheet {window.sheet} from step {window.first_step}"
        self.want(len(window.job) == len(window.state) == 32, f"{what}: a digest is not 32 bytes")
        self.want(window.HasField("ledger"), f"{what}: a window without a ledger")
        last = self.solved.get(window.sheet, 0)
        self.want(last <= window.first_step, f"{what}: the window before ends at {last}")
        self.solved[window.sheet] = window.first_step + window.steps
        numbers = [piece.number for piece in window.pieces]
        self.want(numbers == sorted(set(numbers)), f"{what}: pieces are not by number")

    def on_joints(self, joint):
        ends = {joint.body} | ({joint.other} if joint.HasField("other") else set())
        self.want(ends <= self.alive, f"joint {joint.id} holds a body that is not there")
        self.joints.add(joint.id)

    def on_events(self, event):
        if event.kind in (JOINT_BROKEN, JOINT_GONE):
            self.want(event.joint in self.joints, f"joint {event.joint} ends twice")
            self.joints.discard(event.joint)
        if event.kind == FRACTURED:
            self.fractures += 1
            self.want(event.HasField("ledger"), "a fracture without a ledger")
            self.want(set(event.fragments) <= self.alive, "a fragment that was never born")
        if event.kind in (FRACTURED, REMOVED):
            self.want(event.body in self.alive, f"body {event.body} ends twice")
            self.alive.discard(event.body)

    def scene(self, topic, update):
        self.want(len(update.deletions) == 1 and update.deletions[0].type == 1,
                  f"{topic}: an update that is not the whole state")
        for entity in update.entities:
            self.want(entity.frame_id == "world", f"{topic}: frame {entity.frame_id}")
            for part in entity.triangles:
                self.want(len(part.indices) % 3 == 0 and max(part.indices) < len(part.points),
                          f"{topic}: a triangle without a corner")
                self.drawn[topic] += len(part.indices) // 3

    def on_fragments(self, cloud):
        self.want(len(cloud.data) % cloud.point_stride == 0, "a point cloud with a part of a point")


def read(path, run):
    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        metadata = {m.name: m.metadata for m in reader.iter_metadata()}
        run.step = float(metadata.get("run", {}).get("step", 0))
        gravity = metadata.get("run", {}).get("gravity", "0 0 0").split()
        run.fall = [float(g) * run.step for g in gravity]
        last = collections.defaultdict(int)
        for schema, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
            run.want(message.log_time >= last[channel.topic], f"{channel.topic}: time runs back")
            last[channel.topic] = message.log_time
            run.take(schema, channel, message, decoded)
        statistics = reader.get_summary().statistics
        run.want(statistics.message_count == sum(run.counts.values()), "statistics do not add up")
        attachments = {a.name: a.data for a in reader.iter_attachments()}
    run.want("scene.toml" in attachments, "no scene attached")
    run.want("run" in metadata, "no metadata of the run")
    shown = json.loads(attachments["layout.json"])["configById"]["3D!scene"]["topics"]
    for topic in run.drawn:
        run.want(shown.get(topic, {}).get("visible"), f"the layout hides {topic}")
    return attachments, metadata


def compiled(path):
    """The module that protoc makes of a file of messages."""
    from grpc_tools import protoc

    with tempfile.TemporaryDirectory() as folder:
        source, name = os.path.split(os.path.abspath(path))
        wrong = protoc.main(["protoc", f"-I{source}", f"--python_out={folder}", name])
        if wrong:
            sys.exit(f"protoc does not compile {path}")
        sys.path.insert(0, folder)
        return importlib.import_module(name.removesuffix(".proto") + "_pb2")


def compare(run, path):
    """The summary beside the recording says what the messages say."""
    with open(path, encoding="utf-8") as stream:
        summary = json.load(stream)
    born = [body for body in run.bodies.values() if body.HasField("parent")]
    found = {
        "bodies_initial": len(run.bodies) - len(born),
        "bodies_final": len(run.alive),
        "fragments": len(born),
        "fractures": run.fractures,
    }
    if run.framed:
        found["sheets"] = len(set(run.framed) | set(run.solved))
        summary["sheets"] = summary.get("sheets", {}).get("sheets")
    for key, value in found.items():
        run.want(summary[key] == value, f"summary: {key} is {summary[key]}, messages say {value}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording")
    parser.add_argument("--summary", help="summary.json to compare with")
    parser.add_argument("--proto", help="a file of messages to decode by as well")
    parser.add_argument("--cut", action="store_true", help="a recovered run may lack its end")
    arguments = parser.parse_args()
    run = Run()
    run.compiled = compiled(arguments.proto) if arguments.proto else None
    attachments, metadata = read(arguments.recording, run)
    # A scene of sheets alone has no bodies.
    for topic in ALWAYS if run.bodies or not run.framed else ("/tf", "/log", "/events"):
        run.want(run.counts[topic], f"nothing on {topic}")
    if not arguments.cut:
        run.want("end" in metadata, "the run has no end")
        run.want(run.alive <= run.posed, "a body at the end without a pose")
    if arguments.summary:
        compare(run, arguments.summary)
    print(f"scene {metadata['run']['scene']}, seed {metadata['run']['seed']}")
    for topic, count in sorted(run.counts.items()):
        if not topic.startswith("/scene/"):
            print(f"{count:8} {topic}")
    scenes = [topic for topic in run.counts if topic.startswith("/scene/")]
    print(f"{sum(run.counts[t] for t in scenes):8} /scene/* on {len(scenes)} topics")
    for name, data in sorted(attachments.items()):
        print(f"attachment {name}: {len(data)} bytes, {hashlib.sha256(data).hexdigest()[:12]}")
    for complaint in run.complaints[:50]:
        print(complaint, file=sys.stderr)
    sys.exit(1 if run.complaints else 0)


if __name__ == "__main__":
    main()
