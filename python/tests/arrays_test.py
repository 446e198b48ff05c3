import os
import pickle
import gc

import numpy as np
import pytest

import inhabit

SOURCE = os.environ["INHABIT_SOURCE"]
WALK = os.path.join(SOURCE, "examples/data/walk.npz")


def joints(frames=5):
    return np.random.default_rng(1).normal(size=(frames, 22, 3)).astype(np.float32)


class DLPackOnly:
    """Speaks DLPack and nothing else, as tensors of other libraries do."""

    def __init__(self, array):
        self.array = array

    def __dlpack__(self, **kwargs):
        return self.array.__dlpack__()

    def __dlpack_device__(self):
        return self.array.__dlpack_device__()


class ForeignArray(DLPackOnly):
    """As JAX's arrays: DLPack without positional arguments, beside NumPy's protocol, which copies, and a device."""

    def __init__(self, array, device=(1, 0)):
        super().__init__(array)
        self.device = device

    def __dlpack__(self, *, stream=None, max_version=None, dl_device=None, copy=None):
        return self.array.__dlpack__()

    def __dlpack_device__(self):
        return self.device

    def __array__(self, *args, **kwargs):
        raise AssertionError("would be a copy")


def test_numpy_goes_in_and_out_without_copies():
    given = joints()
    clip = inhabit.Clip(given, rate=25)
    assert np.shares_memory(given, clip.joints) and clip.joints.dtype == np.float32
    given[2, 3, 1] = 7
    assert clip.joints[2, 3, 1] == 7
    view = clip[1:4].joints
    assert np.shares_memory(given, view) and view.shape == (3, 22, 3)


def test_arrays_outlive_their_clips():
    array = inhabit.Clip(joints()).joints
    expected = joints()
    gc.collect()
    assert (array == expected).all()


def test_dlpack_shares_memory_both_ways():
    given = joints()
    clip = inhabit.Clip(DLPackOnly(given))
    assert np.shares_memory(given, clip.joints)
    assert np.shares_memory(np.from_dlpack(clip.joints), given)


def test_torch_tensors_share_memory():
    torch = pytest.importorskip("torch")
    given = torch.randn(5, 22, 3)
    clip = inhabit.Clip(given)
    given[0, 0, 0] = 3.5
    assert clip.joints[0, 0, 0] == 3.5
    back = torch.from_dlpack(clip.joints)
    assert back.data_ptr() == given.data_ptr()


def test_arrays_of_other_libraries_share_memory():
    given = joints()
    clip = inhabit.Clip(ForeignArray(given))
    assert np.shares_memory(given, clip.joints) and clip.joints.dtype == np.float32
    back = np.from_dlpack(DLPackOnly(clip.joints))
    assert back.shape == (5, 22, 3) and np.shares_memory(back, given)
    del given, clip
    gc.collect()
    assert (back == joints()).all()
    wide = inhabit.Clip(ForeignArray(joints().astype(np.float64)))
    assert wide.joints.dtype == np.float32 and (wide.joints == joints()).all()


def test_arrays_on_other_devices_are_refused():
    with pytest.raises(inhabit.Error, match="not in the CPU's memory"):
        inhabit.Clip(ForeignArray(joints(), device=(2, 0)))


def test_other_types_layouts_and_read_only_arrays_are_copied():
    given = joints()
    for other in (given.astype(np.float64), given.astype(">f4"), given[::-1][::-1], given.tolist(), np.asfortranarray(given)):
        assert np.allclose(inhabit.Clip(other).joints, given)
    frozen = joints()
    frozen.flags.writeable = False
    clip = inhabit.Clip(frozen)
    clip.joints[0, 0, 0] = 9
    assert frozen[0, 0, 0] != 9


@pytest.mark.parametrize("wrong", ["text", np.array(["a"]), {}, np.array([1 + 2j])])
def test_what_is_no_array_is_refused(wrong):
    with pytest.raises(TypeError):
        inhabit.Clip(wrong)


def test_clips_are_checked():
    with pytest.raises(inhabit.Error, match="^clip: joints has the wrong shape$"):
        inhabit.Clip(np.zeros((4, 21, 3), np.float32))
    clip = inhabit.Clip(joints())
    with pytest.raises(inhabit.Error, match="trans has the wrong shape"):
        clip.trans = np.zeros((4, 3))
    assert clip.trans is None
    with pytest.raises(inhabit.Error, match="not finite"):
        clip.rotations = np.full((5, 22, 3), np.nan)
    with pytest.raises(inhabit.Error, match="frame rate"):
        clip.rate = 0


def test_forward_kinematics_gives_the_joints():
    clip = inhabit.retarget(inhabit.read_clip(WALK))
    made = inhabit.Clip(rotations=clip.rotations, trans=clip.trans, skeleton=clip.skeleton)
    again = inhabit.forward_kinematics(clip.skeleton, clip.rotations, clip.trans)
    assert np.abs(made.joints - again).max() == 0
    assert np.abs(made.joints - clip.joints).max() < 0.05


def test_clips_are_pickled_bit_by_bit():
    clip = inhabit.read_clip(WALK)
    again = pickle.loads(pickle.dumps(clip))
    assert (again.joints == clip.joints).all() and (again.rotations == clip.rotations).all() and again.rate == clip.rate


def test_copies_have_memory_of_their_own():
    clip = inhabit.Clip(joints())
    other = clip.copy()
    other.joints[:] = 0
    assert np.abs(clip.joints).max() > 0


def test_what_is_set_brings_the_rest_along():
    walk = inhabit.read_clip(WALK)
    clip = inhabit.Clip(rotations=walk.rotations.copy(), trans=walk.trans.copy(), skeleton=walk.skeleton)
    before = clip.joints.copy()
    clip.trans += [5, 0, 0]
    assert np.abs(clip.joints - before - [5, 0, 0]).max() < 1e-4
    turned = clip.rotations.copy()
    turned[:, 16] = 0  # an arm
    clip.rotations = turned
    moved = np.abs(clip.joints - before - [5, 0, 0]).max(axis=(0, 2))
    assert moved[18] > 0.05 and moved[17] < 1e-4
    clip.joints = before
    assert clip.rotations is None and clip.trans is None and (clip.joints == before).all()


def test_bodies_and_skeletons_are_nobody_elses():
    offsets = inhabit.standard_skeleton().offsets
    offsets *= 2
    body = inhabit.Body()
    body.template_vertices[:] *= 2
    assert np.abs(inhabit.standard_skeleton().offsets - offsets / 2).max() == 0
    assert np.abs(inhabit.Body().template_vertices - body.template_vertices / 2).max() == 0
