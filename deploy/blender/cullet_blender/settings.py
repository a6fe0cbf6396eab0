"""What a user sets: of a scene, and of an object in it."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty
from bpy.props import StringProperty


class CULLET_scene(bpy.types.PropertyGroup):
    endpoint: StringProperty(
        name="Farm", default="tcp/127.0.0.1:7447", description="Zenoh endpoint of the coordinator"
    )
    tls: StringProperty(
        name="Identity", subtype="DIR_PATH", description="Folder with ca.pem, cert.pem and key.pem, for a tls/ endpoint"
    )
    user: StringProperty(name="User", default="user", description="Who asks; with TLS the name in the certificate")
    duration: FloatProperty(
        name="Duration", default=1.0, min=0.001, max=60.0, subtype="TIME_ABSOLUTE", description="Simulated time [s]"
    )
    points: IntProperty(
        name="Points",
        default=20_000,
        min=1000,
        max=1_000_000,
        description="Material points of a fracture at most: more are finer and take longer",
    )
    seed: IntProperty(name="Seed", default=0, min=0, description="What everything random is drawn from")
    run: IntProperty(name="Run", default=0, min=0, description="The number of the run at the farm; 0: none")
    folder: StringProperty(
        name="Runs", default="//cullet", subtype="DIR_PATH", description="Folder that runs are fetched into"
    )
    state: StringProperty(name="State", description="Where the run stands")


def material_items(_self, _context):
    if not _ITEMS:
        import cullet

        _ITEMS.extend((name, name, "") for name in cullet.materials())
    return _ITEMS


# Blender keeps no texts of its own.
_ITEMS = []


class CULLET_object(bpy.types.PropertyGroup):
    material: EnumProperty(name="Material", items=material_items, description="What the object is made of")
    fixed: BoolProperty(name="Fixed", description="It never moves")
    breakable: BoolProperty(name="Breaks", default=True, description="It can break")
    velocity: FloatVectorProperty(
        name="Velocity", subtype="VELOCITY", description="Velocity at the start of the run [m/s]"
    )
    spin: FloatVectorProperty(name="Spin", description="Angular velocity at the start of the run [rad/s]")


_CLASSES = (CULLET_scene, CULLET_object)


def register():
    for each in _CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.cullet = PointerProperty(type=CULLET_scene)
    bpy.types.Object.cullet = PointerProperty(type=CULLET_object)


def unregister():
    del bpy.types.Object.cullet
    del bpy.types.Scene.cullet
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
