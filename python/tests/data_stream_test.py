import json
import os
import subprocess

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


def command_scores(tmp_path, score, *words):
    table = tmp_path / "scores.json"
    subprocess.run([os.environ["INHABIT_COMMAND"], "score", score, *words, "--json", table], check=True, capture_output=True)
    return json.loads(table.read_text())


def numbers_of(facts):
    """What is measured, without what motions are called."""
    rows = [{name: value for name, value in row.items() if name != "file"} for row in facts["files"]]
    return {name: value for name, value in facts.items() if name != "files"}, rows


def test_scores_are_the_commands(tmp_path):
    scene = inhabit.read_scene(f"{DATA}/walk_room.glb")
    files = [f"{DATA}/walk.npz", f"{DATA}/sit.npz"]
    inhabit.write_clip(tmp_path / "fast.npz", walk(), rate=120)  # at another rate, over another floor
    raised = inhabit.read_clip(tmp_path / "fast.npz")
    raised.trans[:, 1] += 0.5
    raised.joints[:, :, 1] += 0.5
    inhabit.write_clip(tmp_path / "raised.npz", raised)
    files.append(str(tmp_path / "raised.npz"))
    clips = [inhabit.read_clip(file) for file in files]
    given = ("--motion", *files)
    room = ("--scene", f"{DATA}/walk_room.glb")
    for own, others in [
        (inhabit.score_skating(clips), command_scores(tmp_path, "skating", *given)),
        (inhabit.score_skating(clips, scene), command_scores(tmp_path, "skating", *given, *room)),
        (inhabit.score_jerk(clips), command_scores(tmp_path, "jerk", *given)),
        (inhabit.score_jerk(clips, clips[:1]), command_scores(tmp_path, "jerk", *given, "--reference", files[0])),
        (inhabit.score_penetration(clips, scene), command_scores(tmp_path, "penetration", *given, *room)),
    ]:
        (ours, own_rows), (theirs, other_rows) = numbers_of(own), numbers_of(others)
        assert ours == pytest.approx(theirs, rel=1e-6)
        for row, other in zip(own_rows, other_rows, strict=True):
            assert row.pop("deepest_in", "") == other.pop("deepest_in", "")
            assert row == pytest.approx(other, rel=1e-6)
    own = inhabit.score_ndms(clips[:1], clips[1:2])
    others = command_scores(tmp_path, "ndms", "--motion", files[0], "--reference", files[1])
    for name, command_name in [("ndms", "ndms"), ("coded", "ndms_as_coded"), ("words", "words"),
                               ("reference_words", "reference_words")]:
        assert own[name] == pytest.approx(others[command_name], rel=1e-6)
    with pytest.raises(inhabit.Error, match="^scene: has no meshes"):
        inhabit.score_penetration(clips, inhabit.Scene())
    with pytest.raises(inhabit.Error, match="^motion: holds no clip"):
        inhabit.score_jerk([])


def test_floors_are_made_level(tmp_path):
    slope = 0.1
    clip = walk()
    turn = np.array([[1, 0, 0], [0, np.cos(slope), -np.sin(slope)], [0, np.sin(slope), np.cos(slope)]], np.float32)
    inhabit.write_clip(tmp_path / "slope.npz", inhabit.Clip(joints=clip.joints @ turn.T, rate=clip.rate))
    as_it_is, level = (inhabit.read_clip(tmp_path / "slope.npz", level=given) for given in (False, True))
    assert np.abs(as_it_is.joints - level.joints).max() > 0.05
    inhabit.convert(tmp_path / "slope.npz", tmp_path / "level.npz", level=True)
    assert np.abs(inhabit.read_clip(tmp_path / "level.npz").joints - level.joints).max() < 1e-4


def test_shards_of_rooms_and_tables(tmp_path):
    rooms = dict(clips=4, clips_per_room=1, seconds=4.2)
    assert inhabit.synth_rooms(tmp_path / "rooms", **rooms, shard=(1, 2)) is None
    assert len(inhabit.synth_rooms(tmp_path / "rooms", **rooms, shard=(2, 2))) == 4
    how = dict(split="all", json=tmp_path / "table.json")
    assert inhabit.evaluate("forecast", str(tmp_path / "rooms"), **how, shard=(1, 2)) is None
    table = inhabit.evaluate("forecast", str(tmp_path / "rooms"), **how, shard=(2, 2))
    assert table == json.loads((tmp_path / "table.json").read_text())
    assert not list(tmp_path.glob("*.part"))
    with pytest.raises(inhabit.Error, match="^shard: needs json"):
        inhabit.evaluate("forecast", str(tmp_path / "rooms"), shard=(1, 2))


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
    refined = inhabit.ForecastStream(forecaster, rate=None, refine=True)
    for t in range(30, 60):
        refined.push("anna", t / 30, clip.joints[t])
    (one,) = refined.take()
    assert one.error is None and one.result.clip.rotations is not None


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
