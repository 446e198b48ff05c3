"""Where the command is, and what the panel asks for."""

import bpy


class InhabitPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    command: bpy.props.StringProperty(name="Command", subtype="FILE_PATH", default="inhabit",
                                      description="The program inhabit: a path, or a name that is found on PATH")

    def draw(self, context):
        self.layout.prop(self, "command")


def of_a_kind(kind):
    return lambda settings, thing: thing.type == kind


class InhabitSettings(bpy.types.PropertyGroup):
    chair: bpy.props.PointerProperty(name="Chair", type=bpy.types.Object, poll=of_a_kind("MESH"),
                                     description="What is sat on; without one, the nearest seat")
    left: bpy.props.PointerProperty(name="Left hand", type=bpy.types.Object, poll=of_a_kind("EMPTY"),
                                    description="An empty at the place that the left hand touches")
    right: bpy.props.PointerProperty(name="Right hand", type=bpy.types.Object, poll=of_a_kind("EMPTY"),
                                     description="An empty at the place that the right hand touches")
    hold: bpy.props.BoolProperty(name="Keep the hands there", default=True,
                                 description="Hands stay at their empties until the end; else they let go after two seconds")
    seconds: bpy.props.FloatProperty(name="Seconds", default=8, min=2, max=60, description="How long sitting down may take")
    seed: bpy.props.IntProperty(name="Seed", default=1, min=0, description="Another seed fills in another motion")
    smooth: bpy.props.FloatProperty(name="Smooth", default=1, min=0, max=100, description="Factor on the smoothing of a clean motion")


def command_of(context):
    return bpy.path.abspath(context.preferences.addons[__package__].preferences.command)


CLASSES = (InhabitPreferences, InhabitSettings)
