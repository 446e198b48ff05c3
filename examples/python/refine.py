"""A motion made clean in its room: refine.py MOTION SCENE OUT"""
import sys

import inhabit

motion, scene, out = sys.argv[1:]
result = inhabit.refine(inhabit.read_clip(motion), inhabit.read_scene(scene))
inhabit.write_clip(out, result.on_source)
print(f"refine: {result.contacts} contacts, joints moved by {1000 * result.moved:.1f} mm")
