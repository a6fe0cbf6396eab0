"""How far a run is, and what came of it."""

from pathlib import Path

import bpy

from .importing import import_run
from .submitting import connect


def new_place(runs, run):
    """A folder for a run that holds none: it may have been fetched before, or another farm have one of its number."""
    places = [runs / f"run-{run}"]
    while (places[-1] / "run.mcap").exists() or (places[-1] / "run.mcap.partial").exists():
        places.append(runs / f"run-{run}-{len(places) + 1}")
    return places[-1]


class CULLET_OT_fetch(bpy.types.Operator):
    """Fetch the run from the farm and import it, once it is over; until then, see how far it is"""

    bl_idname = "cullet.fetch"
    bl_label = "Fetch the Run"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.scene.cullet.run > 0

    def execute(self, context):
        import cullet

        chosen = context.scene.cullet
        if chosen.folder.startswith("//") and not bpy.data.filepath:
            text = f"{chosen.folder}: that is beside this file, which is not saved; save it, or name another folder"
            self.report({"ERROR"}, text)
            return {"CANCELLED"}
        place = new_place(Path(bpy.path.abspath(chosen.folder)), chosen.run)
        try:
            client = connect(chosen)
            info = client.run(chosen.run)
            chosen.state = info.state
            if not info.over:
                at = info.answer.get("position")
                share = f", {at['time']:.2f} of {at['end']:.2f} s" if at else ""
                self.report({"INFO"}, f"run {chosen.run} is {info.state}{share}")
                return {"CANCELLED"}
            count = import_run(context, client.fetch(chosen.run, place))
        except (cullet.CulletError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"run {chosen.run} is {info.state}: {count} objects")
        return {"FINISHED"}


def register():
    bpy.utils.register_class(CULLET_OT_fetch)


def unregister():
    bpy.utils.unregister_class(CULLET_OT_fetch)
