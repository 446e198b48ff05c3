import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import inhabit

SOURCE = os.environ["INHABIT_SOURCE"]
DATA = os.path.join(SOURCE, "examples/data")


def walk():
    return inhabit.read_clip(os.path.join(DATA, "walk.npz"))


def room():
    return inhabit.read_scene(os.path.join(DATA, "walk_room.glb"))


def test_forecast_is_the_commands(tmp_path):
    out = tmp_path / "future.npz"
    subprocess.run(
        [os.environ["INHABIT_COMMAND"], "forecast", f"{DATA}/walk.npz", "--scene", f"{DATA}/walk_room.glb", "--start", "60",
         "-o", out], check=True, capture_output=True)
    result = inhabit.Forecaster().run(walk(), room(), start=60)
    assert result.clip.joints.shape == (60, 22, 3) and result.contact_maps.shape[:2] == (90, 22)
    assert np.abs(result.on_source.joints - inhabit.read_clip(out).joints).max() < 1e-4
    html = inhabit.page(result)._repr_html_()
    assert html.startswith("<iframe srcdoc=") and "&quot;" in html


def test_forecast_in_several_ways():
    result = inhabit.Forecaster().run(walk(), room(), samples=3, standard=True)
    ways = result.hypotheses
    assert len(ways) == 3 and ways[0].probability >= ways[1].probability >= ways[2].probability > 0
    assert all(way.joints.shape == (60, 22, 3) and way.clip.joints.shape == (60, 22, 3) for way in ways)


def test_futures_labels_and_horizon():
    futures = inhabit.Anticipator().run(walk(), samples=3, seconds=2)
    assert len(futures) == 3 and futures.joints.shape == (3, 50, 22, 3)
    assert futures.labels.shape == (3, 50) and futures.labels.dtype == np.int64
    assert inhabit.score_apd(futures.clips).shape == (50,)


def test_inbetween_meets_its_keys_and_reports():
    heard = []
    clip = inhabit.retarget(walk())
    result = inhabit.Inbetweener().run(clip, room(), keys=[0, 45, 89], progress=lambda done, all: heard.append((done, all)))
    assert result.keys == [0, 45, 89] and heard and heard[-1][0] == heard[-1][1]
    assert np.abs(result.clip.joints[45] - clip.joints[45]).max() < 0.02
    with pytest.raises(inhabit.Error, match="temperature: is not from 0 to 2"):
        inhabit.Inbetweener().run(clip, room(), temperature=-1.0)


def test_inbetween_in_several_ways():
    one = inhabit.Inbetweener().run(walk(), room(), keys="ends")
    several = inhabit.Inbetweener().run(walk(), room(), keys="ends", samples=2)
    assert len(one.samples) == 1 and len(several.samples) == 2 and len(several.samples[1].samples) == 1
    first, second = (result.clip.joints for result in several.samples)
    assert np.array_equal(first, several.clip.joints) and np.abs(first - second).max() > 0.01
    assert np.array_equal(second, inhabit.Inbetweener().run(walk(), room(), keys="ends", seed=2, temperature=1).clip.joints)
    assert "sample 2" in inhabit.page(several.samples).html


def test_inbetween_warns_of_what_it_cannot_do():
    names = {"left_wrist": "LeftHand"}  # as the file calls it
    clip = inhabit.retarget(walk())
    skeleton = inhabit.Skeleton([names.get(name, name) for name in clip.skeleton.names], clip.skeleton.parents,
                                clip.skeleton.offsets)
    own = inhabit.Clip(rotations=clip.rotations, trans=clip.trans, skeleton=skeleton)
    far = [("LeftHand", 1.5, 1.5, (30.0, 90.0, 20.0))]  # centimetres
    with pytest.warns(UserWarning, match=r"contacts\[0\] \('LeftHand'\) is missed by"):
        result = inhabit.Inbetweener().run(own, keys="ends", contacts=far)
    assert result.contact_gaps[0] > 80 and result.key_immersions == []
    with pytest.raises(inhabit.Error, match="contacts"):
        inhabit.Inbetweener().run(own, keys="ends", contacts=[("nose_of_nobody", 1.0, 1.0, (0.0, 1.0, 0.0))])
    wall = inhabit.Mesh([[x, y, z] for x in (-9, 9) for y in (0.5, 1.5) for z in (-9, 9)],
                        [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6],
                         [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]], name="block")
    with pytest.warns(UserWarning, match="2 of 2 key poses are inside the scene: at 0.00 s, .* in block"):
        result = inhabit.Inbetweener().run(clip, inhabit.Scene([wall]), keys="ends")
    assert [i.object for i in result.key_immersions] == ["block", "block"] and result.key_immersions[0].depth > 0


def test_an_exception_in_a_callback_comes_out():
    def fail(done, all):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        inhabit.Inbetweener().run(walk(), keys="ends", progress=fail)


def test_a_video_is_reconstructed_as_by_the_command(tmp_path):
    command, sample = os.environ["INHABIT_COMMAND"], tmp_path / "sample"
    subprocess.run([command, "eval", "reconstruct", "--rooms", "1", "--seconds", "4", "--width", "120", "--no-objects", "--keep", sample],
                   check=True, capture_output=True)
    files = {"motion": sample / "estimated.npz", "camera": sample / "camera.json", "depth": f"{sample}/depth_*.npy",
             "masks": f"{sample}/mask_*.png"}
    out = tmp_path / "out.npz"
    subprocess.run([command, "reconstruct", *(str(word) for name, file in files.items() for word in (f"--{name}", file)), "-o", out],
                   check=True, capture_output=True)
    heard = []
    result = inhabit.reconstruct(**files, progress=lambda done, all: heard.append(done))
    assert heard and np.abs(result.on_source.joints - inhabit.read_clip(out).joints).max() < 1e-4
    assert 0 < result.depth_scale and len(result.keys) > 1 and not result.scene.empty
    assert "Reconstruction" in inhabit.page(result).html
    with pytest.raises(inhabit.Error, match="nowhere.json"):
        inhabit.reconstruct(**{**files, "camera": tmp_path / "nowhere.json"})


def test_sitting_down():
    scene = inhabit.read_scene(f"{DATA}/sit_room.glb")
    chair = inhabit.find_chairs(scene)[0]
    x, y, z = chair.seat
    start = inhabit.standing_clip(x + 1.5 * np.sin(chair.heading), z + 1.5 * np.cos(chair.heading), chair.heading)
    result = inhabit.Interactor().run(start, scene, chair=chair.name, seconds=8)
    assert result.clip.frames == 240 and result.chair.name == chair.name and result.seated is not None


def test_who_is_nowhere_stands_before_the_chair():
    scene, interactor = inhabit.read_scene(f"{DATA}/sit_room.glb"), inhabit.Interactor()
    result = interactor.run(None, scene, draw_contacts=True, seconds=1, samples=2, force=True)
    assert result.chair.name == interactor.chair_of(scene).name and len(result.samples) == 2
    first, second = (one.clip.joints[0] for one in result.samples)
    assert np.abs(first - second).max() < 1e-3
    assert result.samples[0].contacts != result.samples[1].contacts
    with pytest.raises(inhabit.Error, match="^samples: is not from 1 to 1000"):
        interactor.run(None, scene, samples=0)


def test_refining_takes_noise_away():
    clip = inhabit.retarget(walk())
    noisy = clip.copy()
    noisy.rotations = clip.rotations + np.random.default_rng(1).normal(scale=0.03, size=clip.rotations.shape)
    noisy.joints = inhabit.forward_kinematics(noisy.skeleton, noisy.rotations, noisy.trans)
    result = inhabit.refine(noisy, room())
    assert result.noise_rotations > 0.01
    assert inhabit.dynamics(result.clip)["jerk"] < 0.5 * inhabit.dynamics(noisy)["jerk"]


def test_queries_of_a_box():
    vertices = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
             [1, 5, 7], [1, 7, 3]]
    query = inhabit.SceneQuery(inhabit.Scene([inhabit.Mesh(vertices, faces, name="box")]))
    assert np.allclose(query.signed_distance([[0.5, 0.5, 0.5], [0.5, 2.0, 0.5]]), [-0.5, 1.0], atol=1e-5)
    assert query.inside([[0.5, 0.5, 0.5], [2, 2, 2]]).tolist() == [True, False]
    hits = query.cast([[0.5, 3, 0.5]], [[0, -2, 0]])
    assert hits.hit[0] and abs(hits.distances[0] - 2) < 1e-5
    with pytest.raises(inhabit.Error, match="^points: are not"):
        query.inside([1.0, 2.0])
    with pytest.raises(inhabit.Error, match="name a vertex that is not there"):
        inhabit.Mesh(vertices, [[0, 1, 8]])


@pytest.mark.parametrize("call, said", [
    (lambda: inhabit.read_clip("nowhere.bvh"), "^nowhere.bvh: "),
    (lambda: inhabit.Forecaster().run(walk(), start=3), "^motion: "),
    (lambda: inhabit.Forecaster().run(walk(), start=-5), "^start: is under 0"),
    (lambda: inhabit.Forecaster("nowhere.safetensors"), "nowhere.safetensors"),
    (lambda: inhabit.preset("forecast", "compact", {"nothing": 1}), "nothing"),
    (lambda: inhabit.read_clip("a.bvh", up="x"), "^up: is 'x'"),
    (lambda: inhabit.page([]), "^page: "),
])
def test_errors_are_one_line(call, said):
    with pytest.raises(inhabit.Error, match=said) as caught:
        call()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("variable, threads", [({}, len(os.sched_getaffinity(0))), ({"OMP_NUM_THREADS": "1"}, 1)])
def test_computes_on_every_core_unless_told_otherwise(variable, threads):
    environment = {name: value for name, value in os.environ.items() if name != "OMP_NUM_THREADS"} | variable
    said = subprocess.run([sys.executable, "-c", "import inhabit; print(inhabit.threads())"], env=environment,
                          capture_output=True, text=True, check=True)
    assert int(said.stdout) == threads


def test_other_threads_run_meanwhile():
    ticks, over = [], threading.Event()

    def tick():
        while not over.wait(0.002):
            ticks.append(1)

    thread = threading.Thread(target=tick)
    thread.start()
    inhabit.Anticipator().run(walk(), samples=20, seconds=10)
    over.set()
    thread.join()
    assert len(ticks) > 5


@pytest.mark.parametrize("work", [
    lambda folder: inhabit.synth_rooms(folder / "rooms", clips=100000),
    lambda folder: inhabit.Anticipator().run(walk(), samples=1000, seconds=60),
])
def test_ctrl_c_ends_long_work(tmp_path, work):
    asked = []

    def ask():
        asked.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    threading.Timer(1.0, ask).start()
    with pytest.raises(KeyboardInterrupt):
        work(tmp_path)
    assert time.monotonic() - asked[0] < 5  # sanitizers and busy machines are slow


def test_data_sets_feed_a_loader_and_a_training(tmp_path):
    made = inhabit.synth_rooms(tmp_path / "rooms", clips=10, clips_per_room=1, seconds=4)
    assert len(made) == 10 and made[0].frames == 120 and not made.scene(0).empty
    told = []
    bars = inhabit.check_motion(tmp_path / "rooms", progress=lambda done, all: told.append((done, all)))
    assert "foot skating" in [bar.name for bar in bars] and told == [(done, 10) for done in range(1, 11)]
    windows = inhabit.Windows([tmp_path / "rooms"], frames=90, stride=30)
    assert windows[0]["joints"].shape == (90, 22, 3) and len(list(windows)) == len(windows)
    first = windows[0]["joints"].copy()
    windows[0]["joints"][:] = 5  # as a transform in place does
    windows.clip(0).joints[:] = 7
    assert (windows[0]["joints"] == first).all()
    with pytest.raises(inhabit.Error, match="split: 'tran' is none of train, val, test and all"):
        inhabit.Windows([tmp_path / "rooms"], "tran")
    samples = inhabit.ForecastWindows([tmp_path / "rooms"], settings={"points": 64})
    assert samples[0]["points"].shape == (64, 3)
    keys = inhabit.InbetweenWindows([tmp_path / "rooms"], "all", settings={"frames": 61})
    for one in (windows, samples, keys):  # a spawned worker makes its own
        again = pickle.loads(pickle.dumps(one))
        assert len(again) == len(one) and all(np.array_equal(again[0][name], value) for name, value in one[0].items())
    heard = []

    def stop(report):
        heard.append(report)
        return False

    done = inhabit.train("forecast", [str(tmp_path / "rooms")], tmp_path / "m.safetensors", stages=["ltd"],
                         settings={"training.motion_steps": 60, "training.motion_batch": 2, "points": 64}, callback=stop)
    assert not done and heard[0]["stage"] == "ltd" and heard[0]["step"] < 60
    assert (tmp_path / "m.safetensors.checkpoint.safetensors").exists()
    torch = pytest.importorskip("torch")
    batch = next(iter(torch.utils.data.DataLoader(windows, batch_size=3)))
    assert batch["joints"].shape == (3, 90, 22, 3)


def test_an_evaluation_is_the_commands(tmp_path):
    inhabit.synth_rooms(tmp_path / "rooms", clips=3, clips_per_room=1, seconds=4.2)
    seen = []
    table = inhabit.evaluate("forecast", str(tmp_path / "rooms"), split="all", stride=20, progress=lambda done, all: seen.append((done, all)))
    subprocess.run([os.environ["INHABIT_COMMAND"], "eval", "forecast", "--data", tmp_path / "rooms", "--split", "all", "--stride", "20", "--json",
                    tmp_path / "table.json"], check=True, capture_output=True)
    assert table == json.loads((tmp_path / "table.json").read_text()) and seen[-1][0] == seen[-1][1]
    filled = inhabit.evaluate("inbetween", [str(tmp_path / "rooms")], split="all", windows=2, refine=False)
    assert "ours, raw" in json.dumps(filled)
    touches = inhabit.evaluate("contacts", str(tmp_path / "rooms"), split="all")
    assert "feet on the floor" in json.dumps(touches)
    assert "ours" in json.dumps(inhabit.evaluate("detour", rooms=2, refine=False))
    assert "mean" in json.dumps(inhabit.evaluate("reconstruct", rooms=1, seconds=2, seed=4, width=120))
    with pytest.raises(inhabit.Error, match="how the networks were made"):
        inhabit.evaluate("forecast", str(tmp_path / "rooms"), settings={"hidden": 3})
    with pytest.raises(inhabit.Error, match="none of anticipate"):
        inhabit.evaluate("dance", str(tmp_path / "rooms"))
