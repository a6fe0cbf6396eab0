"""The selected objects as a scene, handed to a farm."""

import bpy
import numpy as np


class CULLET_OT_submit(bpy.types.Operator):
    """Submit the selected objects to a farm"""

    bl_idname = "cullet.submit"
    bl_label = "Submit the Selected Objects"

    @classmethod
    def poll(cls, context):
        return any(each.type == "MESH" for each in context.selected_objects)

    def execute(self, context):
        import cullet

        chosen = context.scene.cullet
        try:
            scene = scene_of(context)
            for line in scene.check():
                self.report({"WARNING"}, line)
            chosen.run = connect(chosen).submit(scene)
        except (cullet.SceneError, cullet.ClientError, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        chosen.state = "queued"
        self.report({"INFO"}, f"run {chosen.run}")
        return {"FINISHED"}


def connect(chosen):
    """A client of the farm that is set."""
    import cullet

    return cullet.Client(chosen.endpoint, tls=bpy.path.abspath(chosen.tls) or None, user=chosen.user)


def scene_of(context):
    """The selected meshes with their modifiers as a scene of Cullet, as they stand at the current frame."""
    import cullet

    chosen = context.scene.cullet
    name = bpy.path.display_name_from_filepath(context.blend_data.filepath) or "blender"
    gravity = tuple(context.scene.gravity) if context.scene.use_gravity else (0.0, 0.0, 0.0)
    build = cullet.SceneBuilder(
        name,
        world={"duration": _short(chosen.duration), "seed": chosen.seed, "gravity": [_short(g) for g in gravity]},
        fracture={"max_particles": chosen.points},
    )
    graph = context.evaluated_depsgraph_get()
    for each in sorted(context.selected_objects, key=lambda one: one.name):
        if each.type == "MESH":
            _add(build, each, each.evaluated_get(graph))
    return build.scene()


def _add(build, each, evaluated):
    mesh = evaluated.to_mesh()
    try:
        mesh.calc_loop_triangles()
        vertices = np.empty(3 * len(mesh.vertices), dtype=np.float32)
        mesh.vertices.foreach_get("co", vertices)
        triangles = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles)
    finally:
        evaluated.to_mesh_clear()
    if not len(triangles):
        raise ValueError(f"{each.name} has no faces")
    place, turn, _ = evaluated.matrix_world.decompose()
    # What is left of the matrix once place and turn are out: scale, shear and mirrors.
    rest = turn.to_matrix().inverted() @ evaluated.matrix_world.to_3x3()
    shape = np.array(rest, dtype=np.float64)
    vertices = vertices.reshape(-1, 3).astype(np.float64) @ shape.T
    triangles = triangles.reshape(-1, 3)
    if np.linalg.det(shape) < 0:
        triangles = triangles[:, ::-1]
    own = each.cullet
    build.add_body(
        each.name,
        mesh=(vertices, triangles),
        material=own.material,
        position=[float(x) for x in place],
        rotation={"quaternion": [turn.x, turn.y, turn.z, turn.w]},
        velocity=None if own.fixed else [float(x) for x in own.velocity],
        spin=None if own.fixed else [float(x) for x in own.spin],
        fixed=own.fixed,
        breakable=own.breakable and not own.fixed,
    )


def _short(value):
    """A number that Blender keeps as a float, as its user typed it."""
    return float(f"{value:.6g}")


def register():
    bpy.utils.register_class(CULLET_OT_submit)


def unregister():
    bpy.utils.unregister_class(CULLET_OT_submit)
