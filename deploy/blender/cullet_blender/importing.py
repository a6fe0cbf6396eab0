"""A run as objects: bodies with keys for their motion, and for when they are there; sheets with a shape a frame.

The pieces of a body are a collection below that of the object of the scene. Frame 0 is the start of the run.
"""

import math

import bpy
import numpy as np
from bpy.props import StringProperty
from bpy_extras.io_utils import ImportHelper

from . import tracks

_SKIN, _CRACK, _SHEET = "Cullet skin", "Cullet crack", "Cullet sheet"
_COLOURS = {_SKIN: (0.8, 0.8, 0.78, 1.0), _CRACK: (0.55, 0.38, 0.25, 1.0), _SHEET: (0.75, 0.78, 0.85, 1.0)}


class CULLET_OT_import_run(bpy.types.Operator, ImportHelper):
    """Import a run that Cullet recorded"""

    bl_idname = "cullet.import_run"
    bl_label = "Import a Run of Cullet"
    bl_options = {"REGISTER", "UNDO"}
    filename_ext = ".mcap"
    filter_glob: StringProperty(default="*.mcap;*.partial", options={"HIDDEN"})

    def execute(self, context):
        import cullet

        try:
            count = import_run(context, cullet.Recording(self.filepath))
        except cullet.RecordingError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{count} objects")
        return {"FINISHED"}


def import_run(context, recording):
    """Makes the objects of a recording in the scene; hands back how many."""
    scene = context.scene
    fps = scene.render.fps / scene.render.fps_base
    last = math.ceil(recording.duration * fps)
    scene.frame_start, scene.frame_end = 0, max(last, 1)
    top = bpy.data.collections.new(recording.summary["scene"])
    scene.collection.children.link(top)
    run = _Run(recording, top, fps, last)
    for row in recording.bodies:
        run.add_body(row)
    for sheet in recording.sheets:
        run.add_sheet(sheet)
    scene.frame_set(0)
    return run.count


class _Run:
    def __init__(self, recording, top, fps, last):
        self.recording, self.top, self.fps, self.last = recording, top, fps, last
        self.step = recording.step
        self.count = 0
        self.collections = {}
        self.names = dict(zip(recording.bodies.body.tolist(), recording.bodies.name, strict=True))
        rows = recording.pose_rows
        order = np.argsort(rows.body, kind="stable")
        bounds = np.flatnonzero(np.diff(rows.body[order])) + 1
        self.rows = {int(rows.body[part[0]]): part for part in np.split(order, bounds) if len(part)}

    def frame_of(self, step):
        """The first frame at which as many steps are over."""
        return math.ceil(step * self.step * self.fps - 1e-6)

    def collection(self, parent):
        """The collection of the pieces of a body; without one, that of the run."""
        if parent < 0:
            return self.top
        if parent not in self.collections:
            made = bpy.data.collections.new(f"{self.names[parent]} pieces")
            row = self.recording.body(int(parent))
            self.collection(int(row["parent"])).children.link(made)
            self.collections[parent] = made
        return self.collections[parent]

    def add_body(self, row):
        """An object for each shape that the body had."""
        number = int(row["body"])
        if number not in self.rows:
            return
        shapes = self.recording.shapes
        own = shapes.step[shapes.body == number]
        births = [int(row["birth_step"]), *map(int, own)]
        end = int(row["end_step"])
        ends = [*births[1:], end if end >= 0 else None]
        track = self.recording.pose_rows[self.rows[number]]
        for birth, end in zip(births, ends, strict=True):
            mesh = self.recording.mesh(number, step=birth)
            made = _object(str(row["name"]), mesh.vertices, mesh.triangles, mesh.crack.astype(np.int32), (_SKIN, _CRACK))
            made["cullet_body"], made["cullet_made"] = number, str(row["made"])
            made["cullet_mass"] = float(row["mass"])
            self.collection(int(row["parent"])).objects.link(made)
            self.count += 1
            part = track[track.step >= birth]
            self.move(made, part if len(part) else track[-1:], birth, end)

    def move(self, made, track, birth, end):
        """Keys for where it is, and for when it is there."""
        first = self.frame_of(birth)
        final = self.last if end is None else min(self.last, max(first, self.frame_of(end)))
        frames = np.arange(min(first, final), final + 1)
        until = math.inf if end is None else end - 1
        location, turn = tracks.at_frames(track, self.step, self.fps, frames, until)
        made.rotation_mode = "QUATERNION"
        made.location, made.rotation_quaternion = location[0], turn[0]
        curves = _Curves(made)
        keep = tracks.needed(np.hstack([location, turn]), 1e-9)
        if keep.sum() > 2 or np.abs(location[-1] - location[0]).max() > 1e-9:
            curves.add("location", frames[keep], location[keep])
            curves.add("rotation_quaternion", frames[keep], turn[keep])
        self.show(curves, birth, end)

    def show(self, curves, birth, end):
        first = self.frame_of(birth)
        keys = [(0, first > 0), (first, False)] if first > 0 else [(0, False)]
        if end is not None and self.frame_of(end) <= self.last:
            keys.append((self.frame_of(end), True))
        # Born and broken between two frames: it is never seen.
        keys = sorted(dict(keys).items())
        if len(keys) > 1:
            for path in ("hide_viewport", "hide_render"):
                curves.add(path, [frame for frame, _ in keys], [[float(hidden)] for _, hidden in keys], constant=True)

    def add_sheet(self, sheet):
        """An object for each surface of a sheet, with a shape a frame of the recording."""
        moments = [sheet.at(step=int(step)) for step in sheet.steps]
        spans, begin = [], 0
        for i in range(1, len(moments) + 1):
            if i == len(moments) or not np.array_equal(moments[i].triangles, moments[begin].triangles):
                spans.append((begin, i))
                begin = i
        for begin, end in spans:
            part = moments[begin:end]
            made = _object(sheet.name, part[0].vertices, part[0].triangles, None, (_SHEET,))
            made["cullet_sheet"] = sheet.number
            self.top.objects.link(made)
            self.count += 1
            self.shape(made, part)
            after = moments[end].step if end < len(moments) else None
            self.show(_Curves(made), part[0].step if begin else 0, after)

    def shape(self, made, moments):
        """Absolute shape keys: between two the mesh goes straight from one to the next, as the recording means it."""
        for moment in moments:
            made.shape_key_add(name=f"{moment.time:.4f} s", from_mix=False).data.foreach_set(
                "co", moment.vertices.astype(np.float32).ravel()
            )
        keys = made.data.shape_keys
        keys.use_relative = False
        for block in keys.key_blocks:
            block.interpolation = "KEY_LINEAR"
        times = np.array([[block.frame] for block in keys.key_blocks])
        frames = [moment.time * self.fps for moment in moments]
        _Curves(keys).add("eval_time", frames, times)


def _object(name, vertices, triangles, slots, materials):
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", vertices.astype(np.float32).ravel())
    mesh.loops.add(3 * len(triangles))
    mesh.loops.foreach_set("vertex_index", triangles.astype(np.int32).ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * len(triangles), 3, dtype=np.int32))
    for material in materials:
        mesh.materials.append(_material(material))
    if slots is not None:
        mesh.polygons.foreach_set("material_index", slots)
    mesh.update(calc_edges=True)
    mesh.validate()
    return bpy.data.objects.new(name, mesh)


def _material(name):
    made = bpy.data.materials.get(name)
    if made is None:
        made = bpy.data.materials.new(name)
        made.diffuse_color = _COLOURS[name]
        if made.node_tree is None:
            # Before Blender 5 a material has nodes only once it is asked for them.
            made.use_nodes = True
        shader = made.node_tree.nodes.get("Principled BSDF")
        if shader is not None:
            shader.inputs["Base Color"].default_value = _COLOURS[name]
    return made


class _Curves:
    """Curves of one object, in an action of its own."""

    def __init__(self, owner):
        self.owner = owner
        self.bag = None

    def _channels(self):
        if self.bag is None:
            data = self.owner.animation_data_create()
            if data.action is None:
                data.action = bpy.data.actions.new(self.owner.name)
                data.action_slot = data.action.slots.new(self.owner.id_type, self.owner.name)
                strip = data.action.layers.new("Cullet").strips.new(type="KEYFRAME")
            else:
                strip = data.action.layers[0].strips[0]
            self.bag = strip.channelbag(data.action_slot, ensure=True)
        return self.bag

    def add(self, path, frames, values, constant=False):
        values = np.asarray(values, dtype=np.float32)
        for index in range(values.shape[1]):
            curve = self._channels().fcurves.new(path, index=index)
            curve.keyframe_points.add(len(frames))
            points = np.column_stack([np.asarray(frames, dtype=np.float32), values[:, index]])
            curve.keyframe_points.foreach_set("co", points.ravel())
            kind = bpy.types.Keyframe.bl_rna.properties["interpolation"].enum_items["CONSTANT" if constant else "LINEAR"].value
            curve.keyframe_points.foreach_set("interpolation", [kind] * len(frames))
            curve.update()


def _menu(self, _context):
    self.layout.operator(CULLET_OT_import_run.bl_idname, text="Cullet (.mcap)")


def register():
    bpy.utils.register_class(CULLET_OT_import_run)
    bpy.types.TOPBAR_MT_file_import.append(_menu)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(_menu)
    bpy.utils.unregister_class(CULLET_OT_import_run)
