"""Walk up to a chair and sit down: interact.py SCENE OUT"""
import math
import sys

import inhabit

path, out = sys.argv[1:]
scene = inhabit.read_scene(path)
chair = inhabit.find_chairs(scene)[0]
x, _, z = chair.seat
start = inhabit.standing_clip(x + 1.5 * math.sin(chair.heading), z + 1.5 * math.cos(chair.heading), chair.heading)
result = inhabit.Interactor().run(start, scene, chair=chair.name, seconds=8)
inhabit.write_clip(out, result.clip, scene)
print(f"interact: {result.clip.frames} frames, seated from frame {result.seated}")
