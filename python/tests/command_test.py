"""What the command can, Python can: the same numbers by the same names."""
import json
import os
import signal
import subprocess
import sys
import urllib.error
import urllib.request

import numpy as np
import pytest

import inhabit

DATA = os.path.join(os.environ["INHABIT_SOURCE"], "examples/data")
WALK, SIT = f"{DATA}/walk.npz", f"{DATA}/sit.npz"


def command(*words):
    return subprocess.run([os.environ["INHABIT_COMMAND"], *map(str, words)], check=True, capture_output=True, text=True).stdout


def table_of(tmp_path, *words):
    """What the command prints, and its table."""
    printed = command(*words, "--json", tmp_path / "table.json")
    return printed, json.loads((tmp_path / "table.json").read_text())


@pytest.fixture(scope="module")
def rooms(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sets") / "rooms"
    inhabit.synth_rooms(folder, clips=6, clips_per_room=1, seconds=8)
    return folder


def test_rows_of_inbetweening_are_the_commands(tmp_path):
    row = "unguided: inference.guidance=0"
    printed, table = table_of(tmp_path, "eval", "inbetween", "--motion", SIT, "--scene", f"{DATA}/sit_room.glb", "--windows", 1,
                              "--no-refine", "--keyframes", "every:60", "ends", "--row", row, "--against", "cubic spline",
                              "--layout", "collisions")
    how = dict(motion=SIT, scene=f"{DATA}/sit_room.glb", windows=1, refine=False, keyframes=["every:60", "ends"], row=row,
               against="cubic spline")
    assert inhabit.evaluate("inbetween", **how) == table
    assert "ours, unguided" in json.dumps(table)
    assert inhabit.evaluate("inbetween", **how, layout="collisions", text=True) == printed
    with pytest.raises(inhabit.Error, match="^layout: is of the text"):
        inhabit.evaluate("inbetween", **how, layout="close")
    with pytest.raises(inhabit.Error, match="is not 'NAME: KEY=VALUE ...'"):
        inhabit.evaluate("inbetween", motion=SIT, row="unnamed")
    with pytest.raises(inhabit.Error, match="no row"):
        inhabit.evaluate("inbetween", **{**how, "against": "nobody"})


def test_rows_of_other_systems_are_the_commands(tmp_path, rooms):
    printed, table = table_of(tmp_path, "eval", "detour", "--rooms", 2, "--seeds", 1, "--no-refine", "--tolerance", 0.5)
    how = dict(rooms=2, seeds=1, refine=False)
    assert inhabit.evaluate("detour", **how, tolerance=0.5) == table
    assert inhabit.evaluate("detour", **how, tolerance=0) != table
    _, table = table_of(tmp_path, "eval", "interact", "--scene", f"{DATA}/sit_room.glb", "--runs", 1, "--seconds", 4)
    assert inhabit.evaluate("interact", scene=f"{DATA}/sit_room.glb", runs=1, seconds=4) == table
    printed, table = table_of(tmp_path, "eval", "forecast", "--data", rooms, "--split", "all", "--stride", 60, "--intervals")
    how = dict(split="all", stride=60, intervals=True)
    assert inhabit.evaluate("forecast", rooms, **how) == table
    assert inhabit.evaluate("forecast", f"{rooms.parent}/r*s", **how, text=True) == printed
    _, table = table_of(tmp_path, "eval", "anticipate", "--data", rooms, "--samples", 1, "--windows", 1, "--seconds", 1, "--words", "dlow")
    assert inhabit.evaluate("anticipate", rooms, samples=1, windows=1, seconds=1, words="dlow") == table


def test_people_behind_chairs_are_the_commands(tmp_path):
    inhabit.synth_chairs(tmp_path / "chairs", minutes=1, subjects=1, chairs=3)
    given = ("eval", "interact", "--data", tmp_path / "chairs", "--split", "all", "--seconds", 4)
    for option, value in (("behind", 1), ("draws", 2)):
        _, table = table_of(tmp_path, *given, f"--{option}", value)
        assert inhabit.evaluate("interact", tmp_path / "chairs", split="all", seconds=4, **{option: value}) == table
    with pytest.raises(inhabit.Error, match="exclude each other"):
        inhabit.evaluate("interact", tmp_path / "chairs", behind=1, draws=1)


@pytest.mark.parametrize("system, options, said", [
    ("forecast", {"keyframes": "ends"}, "^keyframes: is of no use to 'forecast', which takes intervals, stride$"),
    ("detour", {"layout": "keys"}, "^layout: is of no use to 'detour'"),
    ("detour", {"tolerance": "wide"}, '^tolerance: is "wide", no number$'),
    ("detour", {"tolerance": 2}, "^tolerance: is not from 0 to 1$"),
    ("detour", {"rooms": 2.5}, "^rooms: is 2.5, no whole number$"),
    ("forecast", {"stride": np.int64(0)}, "^stride: is under 1$"),
    ("forecast", {"intervals": object()}, "^intervals: is of a type .*: object$"),
    ("forecast", {"model": ["a", "b"]}, "^model: is one file here$"),
])
def test_options_of_evaluations_are_checked(rooms, system, options, said):
    with pytest.raises(inhabit.Error, match=said):
        inhabit.evaluate(system, () if system == "detour" else rooms, **options)


def test_pages_of_files(tmp_path):
    command("view", WALK, SIT, "--scene", f"{DATA}/walk_room.glb", "-o", tmp_path / "page.html", "--title", "two")
    scene = inhabit.read_scene(f"{DATA}/walk_room.glb")
    assert inhabit.page([WALK, SIT], scene=scene, title="two").html == (tmp_path / "page.html").read_text()
    command("view", WALK, "-o", tmp_path / "page.html")
    assert inhabit.page(WALK).html == (tmp_path / "page.html").read_text()
    folder = tmp_path / "motions"
    folder.mkdir()
    inhabit.write_clip(folder / "walk.bvh", inhabit.read_clip(WALK))
    command("view", folder, "-o", tmp_path / "page.html")
    assert inhabit.page(folder).html == (tmp_path / "page.html").read_text()
    command("view", "-o", tmp_path / "page.html")
    assert inhabit.page().html == (tmp_path / "page.html").read_text()
    with pytest.raises(inhabit.Error, match="^nowhere.bvh: "):
        inhabit.page("nowhere.bvh")
    with pytest.raises(inhabit.Error, match="^scene: is for motions"):
        inhabit.page(folder, scene=scene)


def test_rooms_are_fitted_around_folders(tmp_path):
    for place in ("recorded/walks", "recorded/test"):
        (tmp_path / place).mkdir(parents=True)
        inhabit.write_clip(tmp_path / place / "walk.npz", inhabit.read_clip(WALK))
    how = dict(rooms_per_clip=1, mirrored=False, chord_frames=(30, 60))
    made = inhabit.synth_fit(tmp_path / "fitted", tmp_path / "recorded", **how)
    assert {entry.split for entry in made.entries} == {"train", "test"}
    command("synth", "fit", "--mocap", tmp_path / "recorded", "--out", tmp_path / "theirs", "--rooms-per-clip", 1, "--not-mirrored",
            "--chord-frames", 30, 60)
    theirs = inhabit.Dataset(tmp_path / "theirs")
    assert len(theirs) == len(made) and all((made[i].joints == theirs[i].joints).all() for i in range(len(made)))
    by_pattern = inhabit.synth_fit(tmp_path / "pattern", f"{tmp_path}/recorded/w*/*.npz", **how)
    assert {entry.split for entry in by_pattern.entries} == {"train"}


def test_many_files_are_converted(tmp_path):
    (tmp_path / "in/deep").mkdir(parents=True)
    inhabit.write_clip(tmp_path / "in/walk.npz", inhabit.read_clip(WALK))
    inhabit.write_clip(tmp_path / "in/deep/walk.npz", inhabit.read_clip(WALK))
    (tmp_path / "in/broken.bvh").write_text("HIERARCHY")
    heard = []
    written, skipped = inhabit.convert_files([tmp_path / "in", SIT], tmp_path / "out", format="bvh", rate=15,
                                             progress=lambda done, all: heard.append((done, all)))
    assert {file.relative_to(tmp_path / "out").as_posix() for file in written} == {"walk.bvh", "deep/walk.bvh", "sit.bvh"}
    assert len(skipped) == 1 and "broken.bvh: " in skipped[0] and heard[-1] == (4, 4)
    assert inhabit.read_clip(written[0]).rate == pytest.approx(15)
    with pytest.raises(inhabit.Error, match="is named like a file"):
        inhabit.convert_files(f"{DATA}/*.npz", tmp_path / "out.npz")
    with pytest.raises(inhabit.Error, match="^format: 'fbx' is none of npz"):
        inhabit.convert_files(WALK, tmp_path / "out", format="fbx")
    with pytest.raises(KeyError):
        inhabit.convert_files(WALK, tmp_path / "out", progress=lambda done, all: {}[done])


def test_info_is_the_commands(tmp_path):
    clip, slope = inhabit.read_clip(WALK), 0.1
    turn = np.array([[1, 0, 0], [0, np.cos(slope), -np.sin(slope)], [0, np.sin(slope), np.cos(slope)]], np.float32)
    inhabit.write_clip(tmp_path / "slope.npz", inhabit.Clip(joints=clip.joints @ turn.T, rate=clip.rate))
    level = inhabit.info(tmp_path / "slope.npz", level=True)
    assert level == json.loads(command("info", tmp_path / "slope.npz", "--level", "--json"))
    assert level != inhabit.info(tmp_path / "slope.npz")


def test_intentions_are_the_commands(tmp_path, rooms):
    command("intentions", rooms, "--labels", 3, "-o", tmp_path / "page.html", "--json", tmp_path / "table.json")
    heard = []
    found = inhabit.intentions(rooms, labels=3, progress=lambda done, all: heard.append(done))
    assert found.labels == json.loads((tmp_path / "table.json").read_text())["labels"] and heard
    assert inhabit.page(found).html == (tmp_path / "page.html").read_text()
    tracks = found.tracks
    assert len(tracks) == 6 and all(t.dtype == np.int64 and 0 <= t.min() and t.max() < 3 for t in tracks.values())
    assert found.agreement is None and str(found).splitlines()
    with pytest.raises(inhabit.Error, match="labels"):
        inhabit.intentions(rooms, labels=0)
    # The same labels, 120 a second, as others would have them.
    others = {}
    for r in inhabit.read_recordings(str(rooms), found.rate):
        track = tracks[r.name if r.split == "train" else f"{r.name} ({r.split})"]
        frames = np.minimum(np.arange(len(track) * 120 / found.rate) * found.rate / 120, len(track) - 1).astype(int)
        others[f"{'test' if r.split == 'test' else 'train'}/{r.action}/{r.name}"] = track[frames]
    np.savez(tmp_path / "others.npz", **others)
    agreement = inhabit.intentions(rooms, labels=3, compare=tmp_path / "others.npz").agreement
    assert agreement["labels"] > 0.9 and agreement["recordings"] == 6
    said = command("intentions", rooms, "--labels", 3, "-o", tmp_path / "page.html", "--compare", tmp_path / "others.npz")
    assert f": {agreement['labels']:.3f} (6 recordings, {agreement['frames']} frames)" in said


def test_measures_of_data_sets_are_the_commands(rooms):
    printed = command("synth", "blocked", rooms, "--split", "all", "--frames", 90, "--every", 45)
    found = inhabit.blocked_windows(rooms, "all", frames=90, every=45)
    assert f"{found['windows']} windows of {found['clips']} clips" in printed and found["windows"] > 0
    assert f"straight {found['straight']:.4f}, real {found['real']:.4f}" in printed
    printed = command("synth", "activity", rooms).splitlines()
    for row in inhabit.dynamics_by_activity(rooms):
        line = next(line for line in printed if line.startswith(row["activity"] + "  "))
        assert f"{row['frames']:.0f}" in line and f"{row['speed']:.2f}" in line and f"{row['low_jerk']:.1f}" in line
    with pytest.raises(inhabit.Error, match="split"):
        inhabit.blocked_windows(rooms, "tran")


def test_models_go_by_their_names():
    assert inhabit.Forecaster("forecast-compact").config == inhabit.Forecaster().config


def test_chairs_of_any_height():
    seat = inhabit.Mesh([[x, y, z] for x in (-0.25, 0.25) for y in (0, 1.2) for z in (-0.25, 0.25)],
                        [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6],
                         [0, 6, 4], [1, 5, 7], [1, 7, 3]], name="bar")
    scene, interactor = inhabit.Scene([seat]), inhabit.Interactor()
    with pytest.raises(inhabit.Error, match="bar"):
        interactor.chair_of(scene, "bar")
    chair = interactor.chair_of(scene, "bar", force=True)
    contacts = interactor.draw_contacts(chair, 3)
    assert chair.name == "bar" and len(contacts) == 3
    page = inhabit.contacts_page(contacts, chair, scene)
    assert "contact" in page.html and page.html != inhabit.page(scene=scene).html


def test_the_live_page():
    with inhabit.Server() as server:
        with urllib.request.urlopen(server.address) as answer:
            assert answer.status == 200 and b"<canvas" in answer.read()
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(server.address)
    with pytest.raises(inhabit.Error, match="has ended"):
        server.start()
    with pytest.raises(inhabit.Error, match="nowhere"):
        inhabit.Server(inbetween_model="nowhere")


def test_ctrl_c_ends_the_live_page():
    program = "import inhabit\nserver = inhabit.Server()\nprint(server.address, flush=True)\nserver.run()"
    serving = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    with urllib.request.urlopen(serving.stdout.readline().strip()) as answer:
        assert answer.status == 200
    serving.send_signal(signal.SIGINT)
    said = serving.communicate(timeout=60)[1]
    assert said.strip().endswith("KeyboardInterrupt")


def test_clouds_in_other_units(tmp_path):
    clip = inhabit.retarget(inhabit.read_clip(WALK))[:4]
    np.savez(tmp_path / "metres.npz", points=clip.joints.astype(np.float32))
    np.savez(tmp_path / "millimetres.npz", points=(1000 * clip.joints).astype(np.float32))
    metres = inhabit.refine_to_depth(clip, tmp_path / "metres.npz", points=20)
    again = inhabit.refine_to_depth(clip, tmp_path / "millimetres.npz", scale=0.001, points=20)
    assert np.abs(metres.clip.joints - again.clip.joints).max() < 1e-4
    with pytest.raises(inhabit.Error, match="^scale: "):
        inhabit.refine_to_depth(clip, tmp_path / "metres.npz", scale=-1)


@pytest.mark.parametrize("call, said", [
    (lambda: inhabit.read_clip(3), r"^read_clip\(path: os.PathLike, .*\) was given \(int\)$"),
    (lambda: inhabit.read_clip(WALK, upwards="y"), r"was given \(str, upwards: str\)$"),
    (lambda: inhabit.Clip("text"), r"^inhabit.Clip\(joints: .*\) was given \(str\)$"),
    (lambda: inhabit.Forecaster().run("walk.bvh"), r"^run\(self: inhabit.Forecaster, clip: inhabit.Clip.*\) was given \(inhabit.Forecaster, str\)$"),
    (lambda: setattr(inhabit.Scene(), "name", 3), r"was given \(inhabit.Scene, int\)$"),
    (lambda: inhabit.evaluate(), r"^evaluate\(system: str, .*\) was given \(\)$"),
])
def test_wrong_types_are_told_in_one_line(call, said):
    with pytest.raises(TypeError, match=said) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_type_errors_of_callbacks_are_their_own():
    with pytest.raises(TypeError, match="takes 0 positional arguments"):
        inhabit.Inbetweener().run(inhabit.read_clip(WALK), keys="ends", progress=lambda: None)
