import bpy


class InhabitPanel(bpy.types.Panel):
    bl_idname = "VIEW3D_PT_inhabit"
    bl_label = "inhabit"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "inhabit"

    def draw(self, context):
        settings = context.scene.inhabit
        layout = self.layout
        layout.label(text="Select the armature and the room's meshes")
        column = layout.column(align=True)
        column.operator("inhabit.inbetween")
        column.prop(settings, "seed")
        layout.operator("inhabit.forecast")
        column = layout.column(align=True)
        column.operator("inhabit.clean")
        column.prop(settings, "smooth")
        column = layout.column(align=True)
        column.operator("inhabit.sit")
        for name in ("chair", "left", "right", "hold", "seconds"):
            column.prop(settings, name)


CLASSES = (InhabitPanel,)
