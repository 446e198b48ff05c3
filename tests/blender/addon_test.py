"""The add-on in a real Blender, without a window, on armatures of three kinds:

    blender -b --factory-startup --python-exit-code 1 -P tests/blender/addon_test.py -- COMMAND SOURCE_DIR
"""
import contextlib
import io
import os
import subprocess
import sys
import tempfile

import addon_utils
import bpy
import numpy
from mathutils import Matrix, Vector

numpy.bool = bool  # which Debian 12's NumPy lacks and its Blender's glTF importer wants
COMMAND, SOURCE = sys.argv[sys.argv.index("--") + 1:]
DATA = os.path.join(SOURCE, "examples/data")
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "blender"))
from inhabit_motion import armature  # noqa: E402

MIXAMO = {"pelvis": "Hips", "spine1": "Spine", "spine2": "Spine1", "spine3": "Spine2", "neck": "Neck", "head": "Head"}
for side in ("left", "right"):
    for part, name in (("hip", "UpLeg"), ("knee", "Leg"), ("ankle", "Foot"), ("foot", "ToeBase"), ("collar", "Shoulder"), ("shoulder", "Arm"),
                       ("elbow", "ForeArm"), ("wrist", "Hand")):
        MIXAMO[f"{side}_{part}"] = side.capitalize() + name


def empty_file():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = 30
    addon_utils.enable("inhabit_motion", default_set=True)
    bpy.context.preferences.addons["inhabit_motion"].preferences.command = COMMAND


def walker(folder):
    """This project's walk as Blender imports it from .glb."""
    empty_file()
    file = os.path.join(folder, "walk.glb")
    subprocess.run([COMMAND, "convert", os.path.join(DATA, "walk.npz"), file], check=True, stdout=subprocess.DEVNULL)
    bpy.ops.import_scene.gltf(filepath=file)
    return next(o for o in bpy.data.objects if o.type == "ARMATURE")


def heads(rig, frame, names):
    bpy.context.scene.frame_set(frame)
    posed = rig.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return {name: rig.matrix_world @ posed.pose.bones[name].head for name in names}


def mixamo_like(folder):
    """The walk on bones as a Mixamo file has them: other names, an object of scale 0.01 that is rotated, rolled bones."""
    source = walker(folder)
    clip = armature.clip_of(bpy.context, source, range(1, 61))
    bpy.data.objects.remove(source)
    data = bpy.data.armatures.new("Mixamo")
    rig = bpy.data.objects.new("Armature", data)
    bpy.context.collection.objects.link(rig)
    rig.matrix_world = Matrix.LocRotScale(Vector((0, 0, 0)), Matrix.Rotation(numpy.pi / 2, 3, "X").to_quaternion(), Vector((0.01,) * 3))
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    at, made = [], []
    for j, joint in enumerate(clip["skeleton"]):
        offset = Vector(joint["offset"])
        at.append(at[joint["parent"]] + offset if j else Vector((0, 0.95, 0)))
        bone = data.edit_bones.new("mixamorig:" + MIXAMO[joint["name"]])
        bone.head, bone.tail = 100 * at[j], 100 * (at[j] + Vector((0.02, 0.06, 0.03)))
        bone.roll = 0.7 * j
        if j:
            bone.parent = made[joint["parent"]]
        made.append(bone)
        joint["name"] = bone.name
    bpy.ops.object.mode_set(mode="OBJECT")
    for number, bone in enumerate(rig.pose.bones):
        bone.rotation_mode = ("QUATERNION", "XYZ", "AXIS_ANGLE")[number % 3]
    armature.new_action(rig, clip, 1, "walk")
    return rig


def metarig(folder):
    """Rigify's, in three poses of a step, its place keyed too."""
    empty_file()
    addon_utils.enable("rigify", default_set=True)
    bpy.ops.object.armature_human_metarig_add()
    rig = bpy.context.object
    for frame, swing, forward in ((1, 0.4, 0), (31, -0.4, 0.6), (61, 0.4, 1.2)):
        for side, sign in (("L", 1), ("R", -1)):
            for name, angle in (("thigh", sign * swing), ("shin", 0.3), ("upper_arm", -sign * swing)):
                bone = rig.pose.bones[f"{name}.{side}"]
                bone.rotation_mode = "XYZ"
                bone.rotation_euler = (angle, 0, 0)
                bone.keyframe_insert("rotation_euler", frame=frame)
        spine = rig.pose.bones["spine"]
        spine.location = spine.bone.matrix_local.to_3x3().inverted() @ Vector((0, -forward, 0))
        spine.keyframe_insert("location", frame=frame)
    return rig


def keep_keys(rig, frames):
    """Thins the action out to keys in these frames."""
    for curve in rig.animation_data.action.fcurves:
        for point in reversed(curve.keyframe_points):
            if round(point.co.x) not in frames:
                curve.keyframe_points.remove(point)


def select(*things):
    for thing in bpy.context.selected_objects:
        thing.select_set(False)
    for thing in things:
        thing.select_set(True)
    bpy.context.view_layer.objects.active = things[0]


def upright(rig, frames, low, high):
    """Nobody lies, nobody is under the floor: the head over the feet, both as high as they should be."""
    bones = [bone.name for bone in armature.person_bones(rig)]
    head = next(n for n in bones if n.lower().endswith("head") or n == "spine.006")
    for frame in frames:
        at = heads(rig, frame, bones)
        lowest = min(place.z for place in at.values())
        assert -0.1 < lowest < 0.2, (frame, lowest)
        assert low < at[head].z - lowest < high, (frame, at[head].z - lowest)


def check_inbetween(rig, keys):
    old = rig.animation_data.action
    before = [(c.data_path, c.array_index, [tuple(p.co) for p in c.keyframe_points]) for c in old.fcurves]
    names = [bone.name for bone in armature.person_bones(rig)]
    truth = {frame: heads(rig, frame, names) for frame in keys}
    select(rig)
    assert bpy.ops.inhabit.inbetween() == {"FINISHED"}
    new = rig.animation_data.action
    assert new != old and old.use_fake_user and new.name.endswith("in-between")
    assert before == [(c.data_path, c.array_index, [tuple(p.co) for p in c.keyframe_points]) for c in old.fcurves]
    for frame in keys:
        found = heads(rig, frame, names)
        off = max((found[name] - truth[frame][name]).length for name in names)
        assert off < 2e-3, (frame, off)
    assert len(armature.keyed_frames(rig)) == keys[-1] - keys[0] + 1
    upright(rig, range(keys[0], keys[-1] + 1, 10), 1.2, 1.8)


def check_forecast(rig, now):
    """Two seconds from frame `now` on; what was before stays. Where the first bone is at `now`, a frame later, and in the end."""
    names = [bone.name for bone in armature.person_bones(rig)]
    seen = heads(rig, now, names)
    bpy.context.scene.frame_set(now)
    select(rig)
    assert bpy.ops.inhabit.forecast() == {"FINISHED"}
    assert armature.keyed_frames(rig)[0] == 1 and armature.keyed_frames(rig)[-1] == now + 60
    found = heads(rig, now, names)
    assert max((found[n] - seen[n]).length for n in names) < 1e-3
    upright(rig, (now + 5, now + 30, now + 60), 1.2, 1.8)
    return [heads(rig, frame, names[:1])[names[0]] for frame in (now, now + 1, now + 60)]


def check_clean(rig, frames):
    """The whole action anew, upright, each bone within a hand's breadth of where it was recorded."""
    names = [bone.name for bone in armature.person_bones(rig)]
    truth = {frame: heads(rig, frame, names) for frame in frames}
    select(rig)
    assert bpy.ops.inhabit.clean() == {"FINISHED"}
    assert rig.animation_data.action.name.endswith("clean")
    for frame in frames:
        found = heads(rig, frame, names)
        assert max((found[n] - truth[frame][n]).length for n in names) < 0.12, frame
    upright(rig, frames, 1.2, 1.8)


def warnings_of(operator):
    """What the operator says as warnings, which Blender writes to Python's standard output."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        assert operator() == {"FINISHED"}
    return [line for line in said.getvalue().splitlines() if line.startswith("Warning: ")]


def check_round_trip(rig):
    """What is written to the command and read from it is where Blender itself has the bones."""
    names = [bone.name for bone in armature.person_bones(rig)]
    frames = range(1, 30, 7)
    truth = {frame: heads(rig, frame, names) for frame in frames}
    clip = armature.clip_of(bpy.context, rig, range(1, 30))
    armature.new_action(rig, clip, 1, "again")
    for frame in frames:
        found = heads(rig, frame, names)
        assert max((found[n] - truth[frame][n]).length for n in names) < 1e-3, frame


def refused(operator, *said):
    actions = len(bpy.data.actions)
    try:
        operator()
    except RuntimeError as error:
        assert all(each in str(error) for each in said), error
    else:
        raise AssertionError(f"not refused: {said}")
    assert len(bpy.data.actions) == actions
    assert not [name for name in os.listdir(tempfile.gettempdir()) if name.startswith("inhabit_motion_")]


def in_a_temporary_folder(test):
    with tempfile.TemporaryDirectory() as folder:
        tempfile.tempdir = folder  # what the add-on leaves behind is seen here, whatever other programs left elsewhere
        test(folder)
    tempfile.tempdir = None
    print(f"ok: {test.__name__}", flush=True)


def test_walk_of_a_glb(folder):
    rig = walker(folder)
    check_round_trip(rig)
    keep_keys(rig, (1, 29))
    check_inbetween(rig, [1, 29])
    check_clean(rig, (1, 15, 29))


def test_mixamo(folder):
    rig = mixamo_like(folder)
    check_round_trip(rig)
    rig.animation_data.action = bpy.data.actions["walk"]
    hips = check_forecast(rig, 40)
    assert (hips[1] - hips[0]).length < 0.1 and 0.5 < (hips[2] - hips[0]).length < 4, hips
    rig.animation_data.action = bpy.data.actions["walk"]
    keep_keys(rig, (1, 31, 60))
    check_inbetween(rig, [1, 31, 60])
    rig.animation_data.action = bpy.data.actions["again"]
    check_clean(rig, (1, 15, 29))
    check_sitting(rig, "mixamorig:Hips", ("mixamorig:LeftHand", "mixamorig:RightHand"))


def test_metarig(folder):
    rig = metarig(folder)
    keyed = rig.animation_data.action
    hips = check_forecast(rig, 61)
    assert (hips[1] - hips[0]).length < 0.1 and (hips[2] - hips[0]).length < 4, hips
    rig.animation_data.action = keyed
    check_inbetween(rig, [1, 31, 61])
    check_clean(rig, (1, 15, 29, 61))
    rig.animation_data.action = keyed
    check_sitting(rig, "spine", ("hand.L", "hand.R"))


def box(name, low, high):
    bpy.ops.mesh.primitive_cube_add(size=1)
    made = bpy.context.object
    made.name = name
    made.location = [(a + b) / 2 for a, b in zip(low, high)]
    made.scale = [b - a for a, b in zip(low, high)]
    return made


def check_sitting(rig, hips, wrists):
    """On a chair of the scene, from where the rig's action begins, with both hands at empties."""
    at = heads(rig, 1, [hips])[hips]
    x, y = at.x, at.y - 2.5  # a chair that faces the person
    seat = box("my chair", (x - 0.3, y - 0.3, 0), (x + 0.3, y + 0.3, 0.45))
    back = box("back", (x - 0.3, y - 0.38, 0), (x + 0.3, y - 0.3, 0.95))
    select(seat, back)
    bpy.ops.object.join()
    settings = bpy.context.scene.inhabit
    settings.chair = seat
    hands = {}
    for side, off in (("left", -0.25), ("right", 0.25)):
        bpy.ops.object.empty_add(location=(x + off, y, 0.45))
        hands[side] = bpy.context.object
        setattr(settings, side, hands[side])
    bpy.context.scene.frame_set(1)
    select(rig, seat)
    started = rig.animation_data.action
    said = warnings_of(bpy.ops.inhabit.sit)
    assert said == [], said
    last = armature.keyed_frames(rig)[-1]
    there = heads(rig, last, [hips])[hips]
    assert abs(there.x - x) < 0.35 and abs(there.y - y) < 0.35 and 0.4 < there.z < 0.75, there
    for wrist, (side, hand) in zip(wrists, hands.items()):
        nearest = min((heads(rig, frame, [wrist])[wrist] - hand.location).length for frame in range(2, last, 5))
        assert nearest < 0.15, (side, nearest)
    rig.animation_data.action = started
    bpy.context.scene.frame_set(1)
    return settings, hands


def test_sitting(folder):
    rig = walker(folder)
    settings, hands = check_sitting(rig, "pelvis", ("left_wrist", "right_wrist"))
    # Too far to be there in time: a motion all the same, and a warning.
    settings.seconds = 2
    said = warnings_of(bpy.ops.inhabit.sit)
    assert any("nobody sits on" in line for line in said) and "inhabit: " not in "".join(said), said
    settings.seconds = 8
    hands["left"].location.z += 1.5
    bpy.context.view_layer.update()
    refused(bpy.ops.inhabit.sit, "left")


def test_keys_inside_furniture_are_said(folder):
    rig = walker(folder)
    keep_keys(rig, (1, 45, 89))
    at = heads(rig, 45, ["pelvis"])["pelvis"]
    block = box("block", (at.x - 0.4, at.y - 0.4, 0), (at.x + 0.4, at.y + 0.4, 0.9))
    select(rig, block)
    said = warnings_of(bpy.ops.inhabit.inbetween)
    assert any("1 of 3 key poses are inside the scene" in line for line in said), said


def test_what_is_wrong_is_said(folder):
    rig = walker(folder)
    select(rig)
    bpy.context.preferences.addons["inhabit_motion"].preferences.command = "/nowhere/inhabit"
    refused(bpy.ops.inhabit.clean, "/nowhere/inhabit", "preferences")
    bpy.context.preferences.addons["inhabit_motion"].preferences.command = COMMAND
    rig.animation_data.action = None
    refused(bpy.ops.inhabit.inbetween, "keys")
    empty_file()
    bpy.ops.object.armature_add()
    stick = bpy.context.object
    for frame in (1, 20):
        stick.pose.bones[0].keyframe_insert("location", frame=frame)
    refused(bpy.ops.inhabit.inbetween, "Bone")


for each in (test_walk_of_a_glb, test_mixamo, test_metarig, test_sitting, test_keys_inside_furniture_are_said, test_what_is_wrong_is_said):
    in_a_temporary_folder(each)
