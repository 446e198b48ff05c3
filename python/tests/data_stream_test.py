import os

import numpy as np
import pytest

import inhabit

DATA = os.path.join(os.environ["INHABIT_SOURCE"], "examples/data")


def walk():
    return inhabit.read_clip(os.path.join(DATA, "walk.npz"))


def write_amass(folder):
    """AMASS's layout: DATASET/PERSON/RECORDING_poses.npz, 156 numbers a pose, +Z up."""
    clip = walk()
    poses = np.zeros((len(clip.trans), 156))
    poses[:, :66] = clip.rotations.reshape(-1, 66)
    for person in ("01", "02", "03"):
        (folder / "A" / person).mkdir(parents=True)
        np.savez(folder / "A" / person / "walk_poses.npz", poses=poses, trans=clip.trans, betas=np.zeros(16),
                 gender="neutral", mocap_framerate=30.0, dmpls=np.zeros((len(poses), 8)))
    (folder / "A" / "02" / "broken_poses.npz").write_bytes(b"PK")


def test_a_data_set_is_imported(tmp_path):
    write_amass(tmp_path / "amass")
    assert "amass" in inhabit.import_formats()
    listed = inhabit.import_list("amass", tmp_path / "amass")
    assert {r["person"] for r in listed["recordings"]} == {"A/01", "A/02", "A/03"} and listed["splits"]
    heard = []
    data, skipped = inhabit.import_dataset("amass", tmp_path / "amass", tmp_path / "out",
                                           progress=lambda done, all: heard.append((done, all)))
    assert len(data) == 3 and heard[-1] == (4, 4)
    assert len(skipped) == 1 and "broken_poses.npz" in skipped[0]
    assert data[0].joints.shape[1:] == (22, 3) and data[0].contact.sum() > 0
    with pytest.raises(inhabit.Error, match="--shard"):
        inhabit.import_dataset("amass", tmp_path / "amass", tmp_path / "elsewhere", shard="1/0")


def test_shards_are_joined_by_the_last(tmp_path):
    write_amass(tmp_path / "amass")
    first, _ = inhabit.import_dataset("amass", tmp_path / "amass", tmp_path / "out", shard="1/2")
    assert first is None
    last, _ = inhabit.import_dataset("amass", tmp_path / "amass", tmp_path / "out", shard="2/2")
    assert len(last) == 3


def test_forecasts_of_a_stream_are_those_of_the_clip():
    forecaster, clip = inhabit.Forecaster(), walk()
    stream = inhabit.ForecastStream(forecaster, rate=None)
    for t in range(60):
        stream.push("anna", t / 30, clip.joints[t])
    assert stream.due("anna") and not stream.due("ben")
    (one,) = stream.take()
    assert one.person == "anna" and one.time == pytest.approx(59 / 30) and one.error is None
    whole = forecaster.run(inhabit.Clip(joints=clip.joints[30:60], rate=30))
    assert one.result.joints.shape == (60, 22, 3)
    assert np.abs(one.result.joints - whole.joints).max() < 0.01
    assert stream.take() == []
    with pytest.raises(inhabit.Error):
        stream.push("anna", 3, clip.joints[0, :5])


def test_futures_of_a_stream_and_what_is_not_seen():
    clip = walk()
    stream = inhabit.AnticipateStream(inhabit.Anticipator(), samples=3, seconds=1)
    for t in range(90):
        joints = clip.joints[t].copy()
        joints[20 if t % 2 else 21] = np.nan  # a wrist is hidden now and then
        stream.push("anna", t / 30, joints)
    results = stream.take()
    assert len(results) == 1 and results[0].error is None
    assert len(results[0].result) == 3 and results[0].result.joints.shape[0] == 3
    with pytest.raises(inhabit.Error):
        inhabit.ForecastStream(inhabit.Forecaster(), rate=-1)


def test_features_tell_motions_apart():
    joints = walk().joints
    there_and_back = inhabit.Clip(joints=np.concatenate([joints, joints[::-1]]), rate=30)
    still = inhabit.Clip(joints=np.repeat(joints[:1], 300, axis=0), rate=30)
    walks = [inhabit.mirrored(there_and_back), there_and_back]
    assert inhabit.score_diversity(walks + [still]) > 0
    assert inhabit.score_fid(walks, walks)["fid"] == pytest.approx(0, abs=1e-3)
    assert inhabit.score_fid([still, still], walks)["fid"] > 1


def test_motions_are_cut_and_looped_where_they_are_written(tmp_path):
    clip = walk()
    inhabit.write_clip(tmp_path / "cut.npz", clip, start=0.5, end=1.5, rate=60)
    cut = inhabit.read_clip(tmp_path / "cut.npz")
    assert cut.rate == 60 and len(cut.joints) == 61
    assert np.abs(cut.joints[0] - clip.joints[15]).max() < 1e-4
    inhabit.write_clip(tmp_path / "loop.bvh", clip, loop=True)
    assert len(inhabit.read_clip(tmp_path / "loop.bvh").joints) < len(clip.joints)
    inhabit.write_clips(tmp_path / "both.bvh", [clip, inhabit.mirrored(clip)])
    assert (tmp_path / "both_000.bvh").exists() and (tmp_path / "both_001.bvh").exists()
    with pytest.raises(inhabit.Error, match="beyond the end"):
        inhabit.write_clip(tmp_path / "none.npz", clip, start=99)
    line = inhabit.convert(f"{DATA}/walk.npz", tmp_path / "c.npz", start=1)
    assert line.startswith("60 frames")
