#!/usr/bin/env python3
"""What steering and refinement do for futures of people who walk in a data set's rooms: the table in docs/anticipation.md.

usage: PYTHONPATH=build/release/python scripts/futures_in_rooms.py DATASET [CLIPS]
"""
import json
import os
import sys

import numpy as np

import inhabit

folder, most = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 24
with open(os.path.join(folder, "dataset.json"), encoding="utf-8") as index:
    clips = json.load(index)["clips"][:most]
anticipator = inhabit.Anticipator()


def through(future, query):
    """Whether the pelvis goes through a surface."""
    root = np.ascontiguousarray(future.joints[:, 0])
    step = np.diff(root, axis=0)
    length = np.linalg.norm(step, axis=1)
    moved = length > 1e-4
    hits = query.cast(np.ascontiguousarray(root[:-1][moved]), np.ascontiguousarray(step[moved]))
    return bool(np.any(hits.distances <= length[moved]))


def leaves(future, query):
    """Whether the pelvis is ever over no floor, nor anything that stands on it."""
    root = np.ascontiguousarray(future.joints[:, 0])
    return not np.all(query.cast(root, np.tile(np.float32([0, -1, 0]), (len(root), 1))).hit)


kinds = {"as forecast": (False, False), "steered": (True, False), "steered, refined": (True, True)}
rows = {name: [] for name in kinds}
for entry in clips:
    clip = inhabit.read_clip(os.path.join(folder, entry["file"]))
    scene = inhabit.read_scene(os.path.join(folder, entry["scene"]))
    root = clip.joints[:, 0, ::2]
    walking = np.flatnonzero(np.linalg.norm(root[30:] - root[:-30], axis=1) > 0.8) + 31  # 0.8 m in the second before
    start = int(walking[len(walking) // 2]) if len(walking) else 0
    if not 62 <= start <= len(root):
        continue
    query = inhabit.SceneQuery(scene)
    for name, (steer, refine) in kinds.items():
        futures = anticipator.run(clip, scene if steer else None, start=start, samples=6, seconds=8, refine=refine, standard=True)
        for future in futures.clips:
            inside = np.mean(inhabit.collisions(future, scene)["depth"] > 0.02)
            rows[name].append((inside, inside == 0, through(future, query), leaves(future, query), inhabit.score_skating([future], scene)["foot_skating"]))
print(f"{len(rows['steered'])} futures      frames inside  futures never inside  through something  off the floor  skating")
for name, values in rows.items():
    print("{:18} {:13.3f} {:21.2f} {:18.2f} {:14.2f} {:8.3f}".format(name, *np.mean(values, axis=0)))
