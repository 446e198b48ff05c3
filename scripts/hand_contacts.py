#!/usr/bin/env python3
"""How well refinement finds the hand contacts of people on chairs and holds them: the table in docs/refinement.md.

usage: PYTHONPATH=build/release/python scripts/hand_contacts.py DATASET [CLIPS_OF_EACH_INTERACTION]
"""
import os
import sys
import time

import numpy as np

import inhabit

folder, most = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 10
kinds = {}
for entry in inhabit.Dataset(folder, "test").entries:
    kinds.setdefault(entry.source.split("/")[1], []).append(entry)
clips = [entry for all_of in kinds.values() for entry in all_of[::max(1, len(all_of) // most)][:most]]


def matrices(turns):
    """(..., 3, 3) of axis-angle vectors."""
    angle = np.maximum(np.linalg.norm(turns, axis=-1), 1e-9)[..., None, None]
    x, y, z = np.moveaxis(turns / angle[..., 0], -1, 0)
    none = np.zeros_like(x)
    across = np.stack([none, -z, y, z, none, -x, -y, x, none], -1).reshape(turns.shape + (3,))
    return np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * (across @ across)


def palms(clip):
    """(T, 2, 3) metres: the skin of a palm is 8.5 cm from the wrist along the hand and 2.5 cm under it."""
    turned = matrices(clip.rotations.astype(float))
    parents, world = clip.skeleton.parents, []
    for j, parent in enumerate(parents):
        world.append(turned[:, j] if parent < 0 else world[parent] @ turned[:, j])
    return np.stack([clip.joints[:, 20 + side] + world[20 + side] @ np.array([0.085 - 0.17 * side, -0.025, 0]) for side in (0, 1)], 1)


def with_noise(clip, level, draw):
    """A degree on every component of the rotations, a centimetre on the root."""
    out = clip.copy()
    out.rotations = clip.rotations + draw.normal(scale=np.radians(level), size=clip.rotations.shape).astype(np.float32)
    out.trans = clip.trans + draw.normal(scale=0.01 * level, size=clip.trans.shape).astype(np.float32)
    out.joints = inhabit.forward_kinematics(out.skeleton, out.rotations, out.trans)
    return out


def drift(places, on):
    """Millimetres: mean distance of a palm from the middle of its contact, of all frames of all contacts."""
    out = []
    for side in (0, 1):
        ends = np.flatnonzero(np.diff(np.r_[0, on[:, side].astype(int), 0]))
        for first, end in zip(ends[::2], ends[1::2]):
            track = places[first:end, side]
            out += list(1000 * np.linalg.norm(track - track.mean(0), axis=1))
    return out


def speeds(places, rate):
    """(T, 2) m/s by central differences."""
    return np.linalg.norm(np.gradient(places, axis=0), axis=2) * rate


def jerk(clip):
    return np.linalg.norm(np.diff(clip.joints, 3, axis=0), axis=2).mean() * clip.rate**3


for level in (0, 1, 2):
    draw = np.random.default_rng(1)
    counts = np.zeros(4)
    rows = {name: [[], [], [], [], 0.0] for name in ("as given", "feet alone", "feet and hands")}
    length, touching, free = 0.0, [], []
    for entry in clips:
        truth = inhabit.read_clip(os.path.join(folder, entry.file))
        scene = inhabit.read_scene(os.path.join(folder, entry.scene))
        on, contact = truth.hand_targets[:, :, 3] > 0.5, truth.hand_targets[:, :, :3]
        given = with_noise(truth, level, draw)
        given.hand_targets = None
        length += truth.seconds
        for name, row in rows.items():
            begun = time.perf_counter()
            result = None if name == "as given" else inhabit.refine(given, scene, standard=True, hands=name == "feet and hands")
            row[4] += time.perf_counter() - begun
            motion = result.clip if result else given
            places = palms(motion)
            row[0] += drift(places, on)
            row[1] += list(1000 * np.linalg.norm(places - contact, axis=2)[on])
            row[2].append(1000 * np.linalg.norm(motion.joints - truth.joints, axis=2).mean())
            row[3].append(jerk(motion) / jerk(truth))
            if name == "feet alone":
                nearest = inhabit.SceneQuery(scene).closest(np.ascontiguousarray(places.reshape(-1, 3), np.float32))
                away = nearest.distances.reshape(-1, 2)
                touching += list(away[on])
                free += list(away[~on & (speeds(places, truth.rate) < 0.1)])
        found = np.zeros_like(on)
        for hand in result.hands:
            found[hand["first"]:hand["last"] + 1, hand["side"]] = True
        counts += [(found & on).sum(), found.sum(), on.sum(), on.size]
    hit, found, labelled, frames = counts
    print(f"noise {level}: {len(clips)} clips, {100 * labelled / frames:.1f} % of hands' frames in contact; precision {hit / found:.3f}, recall {hit / labelled:.3f}")
    print(f"to the nearest surface with feet alone: 99 % of palms in contact under {100 * np.percentile(touching, 99):.1f} cm, 99 % of others "
          f"slower than 0.1 m/s over {100 * np.percentile(free, 1):.1f} cm")
    print("                 palm drift (mm)  to the contact (mm)  joints off (mm)  jerk / true  s for 10 s")
    for name, row in rows.items():
        print("{:16} {:15.1f} {:20.1f} {:16.1f} {:12.2f} {:11.2f}".format(name, *(np.mean(values) for values in row[:4]), 10 * row[4] / length))
