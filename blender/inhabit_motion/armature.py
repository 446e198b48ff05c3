"""Poses of an armature as a clip of inhabit, and back.

A clip (docs/files.md, "Motion in .json") is in metres, +Y up; each joint's rotation is relative to its parent, and none at
rest, whatever axes the bone has there. Blender is +Z up, the armature object may be scaled and rotated, and bones have axes
of their own: here are the changes between the two.
"""

import bpy
from mathutils import Matrix, Quaternion, Vector

RIGID = 1e-4  # metres: bones whose place changes less are rigid
LEAST_BONES = 8  # of what may be a person


def y_up(v):
    return Vector((v.x, v.z, -v.y))


def z_up(v):
    return Vector((v.x, -v.z, v.y))


def turned_y_up(q):
    return Quaternion((q.w, q.x, q.z, -q.y))


def turned_z_up(q):
    return Quaternion((q.w, q.x, -q.z, q.y))


def person_bones(rig):
    """The bones of the person, parents first: those below the root that most hang on, without what carries it as a whole."""
    roots = [bone for bone in rig.data.bones if bone.parent is None]
    root = max(roots, key=lambda bone: len(bone.children_recursive))
    while True:
        large = [child for child in root.children if len(child.children_recursive) >= LEAST_BONES]
        if len(large) != 1 or any(len(child.children_recursive) > 0 for child in root.children if child != large[0]):
            break
        root = large[0]
    out = [root]
    for bone in out:
        out.extend(bone.children)
    return out


def rest_rotations(rig, bones):
    return [(rig.matrix_world @ bone.matrix_local).to_quaternion() for bone in bones]


def frame_rate(scene):
    return scene.render.fps / scene.render.fps_base


def clip_of(context, rig, frames):
    """The armature's poses in these frames of the scene, as the dictionary of a clip."""
    bones = person_bones(rig)
    place = {bone.name: j for j, bone in enumerate(bones)}
    parents = [place[bone.parent.name] if j else -1 for j, bone in enumerate(bones)]
    rest = rest_rotations(rig, bones)
    trans, rotations, places = [], [], []
    current = context.scene.frame_current
    for frame in frames:
        context.scene.frame_set(frame)
        world = [rig.matrix_world @ rig.pose.bones[bone.name].matrix for bone in bones]
        world_rotations = [turned_y_up(m.to_quaternion() @ r.inverted()) for m, r in zip(world, rest)]
        at = [y_up(m.translation) for m in world]
        trans.append(list(at[0]))
        local, own = [], []
        for j, parent in enumerate(parents):
            back = world_rotations[parent].inverted() if j else Quaternion()
            local.append(list((back @ world_rotations[j]).to_exponential_map()))
            own.append(back @ (at[j] - at[parent]) if j else Vector())
        rotations.append(local)
        places.append(own)
    context.scene.frame_set(current)
    offsets = [sorted(p[j][axis] for p in places)[len(places) // 2] for j in range(len(bones)) for axis in range(3)]
    offsets = [Vector(offsets[3 * j:3 * j + 3]) for j in range(len(bones))]
    clip = {
        "format": "inhabit clip",
        "version": 1,
        "rate": frame_rate(context.scene),
        "frames": len(trans),
        "skeleton": [{"name": bone.name, "parent": parent, "offset": list(offset)}
                     for bone, parent, offset in zip(bones, parents, offsets)],
        "trans": trans,
        "rotations": rotations,
    }
    if any((p[j] - offsets[j]).length > RIGID for p in places for j in range(1, len(bones))):
        clip["translations"] = [[list(v) for v in p] for p in places]
    return clip


def poses_of(rig, clip):
    """The matrices of the armature's bones, in its own space, frame by frame: lists in the order of the clip's joints."""
    names = [joint["name"] for joint in clip["skeleton"]]
    parents = [joint["parent"] for joint in clip["skeleton"]]
    offsets = [Vector(joint["offset"]) for joint in clip["skeleton"]]
    bones = [rig.data.bones[name] for name in names]
    rest = rest_rotations(rig, bones)
    scale = rig.matrix_world.to_scale()
    to_rig = rig.matrix_world.inverted()
    translations = clip.get("translations")
    out = []
    for t, (root, local) in enumerate(zip(clip["trans"], clip["rotations"])):
        rotations, at = [], []
        for j, parent in enumerate(parents):
            rotation = Quaternion(Vector(local[j]))
            if parent < 0:
                rotations.append(rotation)
                at.append(Vector(root) + offsets[j])
            else:
                rotations.append(rotations[parent] @ rotation)
                at.append(at[parent] + rotations[parent] @ (Vector(translations[t][j]) if translations else offsets[j]))
        out.append([to_rig @ Matrix.LocRotScale(z_up(at[j]), turned_z_up(rotations[j]) @ rest[j], scale) for j in range(len(names))])
    return bones, out


def curve(action, path, index, group, frames, values):
    fcurve = action.fcurves.new(path, index=index, action_group=group)
    fcurve.keyframe_points.add(len(frames))
    fcurve.keyframe_points.foreach_set("co", [x for pair in zip(frames, values) for x in pair])
    for point in fcurve.keyframe_points:
        point.interpolation = "LINEAR"
    fcurve.update()


def new_action(rig, clip, first_frame, name):
    """The clip as a new action of the armature, a key in every frame; the action before it is kept in the file."""
    bones, poses = poses_of(rig, clip)
    frames = [first_frame + t for t in range(len(poses))]
    rig.animation_data_create()
    if rig.animation_data.action:
        rig.animation_data.action.use_fake_user = True
    action = bpy.data.actions.new(name)
    place = {bone.name: j for j, bone in enumerate(bones)}
    for j, bone in enumerate(bones):
        pose_bone = rig.pose.bones[bone.name]
        parent = bone.parent
        locations, rotations = [], []
        for matrices in poses:
            known = {}
            if parent:
                above = matrices[place[parent.name]] if parent.name in place else rig.pose.bones[parent.name].matrix
                known = {"parent_matrix": above, "parent_matrix_local": parent.matrix_local}
            basis = bone.convert_local_to_pose(matrices[j], bone.matrix_local, invert=True, **known)
            location, rotation, _ = basis.decompose()
            if rotations and rotations[-1].dot(rotation) < 0:
                rotation.negate()
            locations.append(location)
            rotations.append(rotation)
        base = f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"].'
        still = max((location - locations[0]).length for location in locations) * max(rig.matrix_world.to_scale()) < RIGID
        kept = slice(0, 1) if still else slice(None)
        for axis in range(3):
            curve(action, base + "location", axis, bone.name, frames[kept], [v[axis] for v in locations][kept])
        rows, path = rotations, "rotation_quaternion"
        if pose_bone.rotation_mode == "AXIS_ANGLE":
            rows, path = [(q.angle, *q.axis) for q in rotations], "rotation_axis_angle"
        elif pose_bone.rotation_mode != "QUATERNION":
            rows, path, before = [], "rotation_euler", None
            for q in rotations:
                before = q.to_euler(pose_bone.rotation_mode, before) if before else q.to_euler(pose_bone.rotation_mode)
                rows.append(before)
        for index in range(len(rows[0])):
            curve(action, base + path, index, bone.name, frames, [row[index] for row in rows])
        for axis in range(3):
            curve(action, base + "scale", axis, bone.name, frames[:1], [1])
    rig.animation_data.action = action
    return action


def keyed_frames(rig):
    """Frames of the scene in which a bone has a key."""
    action = rig.animation_data.action if rig.animation_data else None
    curves = action.fcurves if action else []
    return sorted({round(point.co.x) for c in curves if c.data_path.startswith("pose.bones[") for point in c.keyframe_points})


def joined(first, second):
    """The second clip behind the first, on the same skeleton."""
    out = dict(first)
    for name in ("trans", "rotations"):
        out[name] = first[name] + second[name]
    if "translations" in first or "translations" in second:
        out["translations"] = []
        for clip in (first, second):
            rigid = [joint["offset"] for joint in clip["skeleton"]]
            out["translations"] += clip.get("translations") or [rigid] * len(clip["trans"])
    out["frames"] = len(out["trans"])
    return out
