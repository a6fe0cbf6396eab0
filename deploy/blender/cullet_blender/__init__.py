"""Cullet in Blender: submit the selected objects to a farm, fetch the run, and import what was recorded.

It needs Cullet's package for Python, which the packed extension brings along.
"""

from . import fetching, importing, panel, settings, submitting

_PARTS = (settings, importing, submitting, fetching, panel)


def register():
    for part in _PARTS:
        part.register()


def unregister():
    for part in reversed(_PARTS):
        part.unregister()
