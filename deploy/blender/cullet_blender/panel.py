"""The panel in the sidebar of the 3D view."""

import bpy


class CULLET_PT_farm(bpy.types.Panel):
    bl_label = "Cullet"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Cullet"

    def draw(self, context):
        layout, chosen = self.layout, context.scene.cullet
        layout.use_property_split = True
        each = context.active_object
        if each is not None and each.type == "MESH":
            box = layout.box()
            box.label(text=each.name)
            for name in ("material", "fixed", "breakable", "velocity", "spin"):
                box.prop(each.cullet, name)
        for name in ("duration", "points", "seed", "endpoint", "tls", "user"):
            layout.prop(chosen, name)
        layout.operator("cullet.submit")
        layout.prop(chosen, "folder")
        row = layout.row()
        row.prop(chosen, "run")
        row.label(text=chosen.state)
        layout.operator("cullet.fetch")
        layout.operator("cullet.import_run")


def register():
    bpy.utils.register_class(CULLET_PT_farm)


def unregister():
    bpy.utils.unregister_class(CULLET_PT_farm)
