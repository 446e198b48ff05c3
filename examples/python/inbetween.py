"""The motion between key frames in a room: inbetween.py MOTION SCENE OUT"""
import sys

import inhabit

motion, scene, out = sys.argv[1:]
result = inhabit.Inbetweener().run(inhabit.read_clip(motion), inhabit.read_scene(scene), keys="every:45")
inhabit.write_clip(out, result.on_source)
print(f"inbetween: {len(result.keys)} key frames, {result.clip.frames} frames")
