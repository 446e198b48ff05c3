"""Fills in, predicts, cleans and seats the motion of an armature with the command `inhabit` (docs/blender.md)."""

bl_info = {
    "name": "inhabit",
    "description": "In-betweens, forecasts, clean motion and people who sit down, in the rooms of the scene",
    "author": "the authors of inhabit",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > inhabit",
    "category": "Animation",
}

from . import operators, panel, preferences

CLASSES = preferences.CLASSES + operators.CLASSES + panel.CLASSES


def register():
    import bpy

    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.inhabit = bpy.props.PointerProperty(type=preferences.InhabitSettings)


def unregister():
    import bpy

    del bpy.types.Scene.inhabit
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
