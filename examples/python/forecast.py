"""The next two seconds of a person's motion in a room: forecast.py MOTION SCENE PAGE"""
import sys

import inhabit

motion, scene, out = sys.argv[1:]
result = inhabit.Forecaster().run(inhabit.read_clip(motion), inhabit.read_scene(scene), start=60)
inhabit.page(result).write(out)
print(f"forecast: {result.clip.frames} frames, left foot in contact in {100 * result.contact_points[:, 10, 3].mean():.0f} %")
