"""Many futures of one motion: anticipate.py MOTION OUT"""
import sys

import inhabit

motion, out = sys.argv[1:]
futures = inhabit.Anticipator().run(inhabit.read_clip(motion), samples=5, seconds=4)
inhabit.write_clips(out, futures.on_source)
print(f"anticipate: {len(futures)} futures, {inhabit.score_apd(futures.clips).mean():.2f} m apart")
