"""Human motion in 3D scenes: read, forecast, anticipate, in-between, interact, refine, score, train and show it.

    import inhabit
    clip, scene = inhabit.read_clip("walk.bvh"), inhabit.read_scene("room.glb")
    future = inhabit.Forecaster().run(clip, scene, start=90)
    future.clip.joints                     # (60, 22, 3) float32, metres

Metres, seconds, radians; right-handed, +Y up, the person faces +Z at rest. Arrays come as NumPy views of the library's
memory and go in as NumPy arrays, as anything with __dlpack__ (PyTorch, JAX), or as lists. Errors are inhabit.Error.
"""

import os as _os

# Spinning OpenMP threads cost small products up to four times their time; read when LibTorch is loaded.
_os.environ.setdefault("OMP_WAIT_POLICY", "passive")

from . import _core  # noqa: E402
from ._core import *  # noqa: E402, F401, F403

# LibTorch counts cores by itself, and on some virtual machines finds one of two.
if "OMP_NUM_THREADS" not in _os.environ:
    set_threads(len(_os.sched_getaffinity(0)))  # noqa: F405

__all__ = sorted(name for name in vars(_core) if not name.startswith("_"))
__version__ = _core.__version__

for _name in __all__:  # as their users know them, in messages and pickles
    getattr(_core, _name).__module__ = __name__
del _name

# A child of fork has none of its parent's OpenMP threads and must not wait for them (DataLoader's workers).
_os.register_at_fork(after_in_child=lambda: set_threads(1))  # noqa: F405
