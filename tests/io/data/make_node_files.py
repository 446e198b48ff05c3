"""What Blender 3.4 exports of a motion, for tests of the reader of .fbx and .dae:

    inhabit convert examples/data/walk.npz walk.glb --from 0.5 --to 0.8
    blender -b --factory-startup -P tests/io/data/make_node_files.py -- walk.glb tests/io/data
"""
import sys

import bpy
import numpy

numpy.bool = bool  # which Debian 12's NumPy lacks and its Blender wants
source, out = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps = 30
bpy.ops.import_scene.gltf(filepath=source)
scene.frame_start, scene.frame_end = (int(x) for x in bpy.data.actions[0].frame_range)
for mesh in [o for o in bpy.data.objects if o.type == "MESH"]:
    bpy.data.objects.remove(mesh)
bpy.ops.mesh.primitive_cube_add(size=0.2)  # a skin, so that there is a pose that it was bound in
skin = bpy.context.object
person = next(o for o in bpy.data.objects if o.type == "ARMATURE")
skin.parent = person
skin.vertex_groups.new(name="pelvis").add(range(8), 1, "REPLACE")
skin.modifiers.new("Armature", "ARMATURE").object = person
bpy.ops.export_scene.fbx(filepath=out + "/blender.fbx", bake_anim_simplify_factor=0, bake_anim_use_all_actions=False, bake_anim_use_nla_strips=False)
bpy.ops.wm.collada_export(filepath=out + "/blender.dae", include_animations=True, sampling_rate=1)
