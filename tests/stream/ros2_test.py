"""Protects examples/ros2: the child process as it is, and the node on stand-ins for ROS's classes (no ROS is needed).

    python3 ros2_test.py INHABIT SOURCE_DIR"""
import json
import math
import os
import subprocess
import sys
import tempfile
import types
import unittest

COMMAND, SOURCE = sys.argv[1:3]
sys.path.insert(0, os.path.join(SOURCE, "examples", "ros2"))


def walk():
    """Joints of the recording that comes with the project, z up."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "walk.json")
        subprocess.run([COMMAND, "convert", os.path.join(SOURCE, "examples/data/walk.npz"), out], check=True,
                       stdout=subprocess.DEVNULL)
        with open(out) as file:
            return [[(x, -z, y) for x, y, z in frame] for frame in json.load(file)["joints"]]


class Record(types.SimpleNamespace):
    """A message: fields as they are set, sub-messages as they are asked for."""

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        value = [] if name == "poses" else Record()
        setattr(self, name, value)
        return value


class FakeTime:
    def __init__(self, nanoseconds=0):
        self.nanoseconds = nanoseconds

    def to_msg(self):
        return self

    @staticmethod
    def from_msg(stamp):
        return stamp


class FakeNode:
    parameters = {}

    def __init__(self, name):
        self.published, self.subscriptions, self.warnings = {}, {}, []

    def declare_parameter(self, name, default):
        return Record(value=self.parameters.get(name, default))

    def create_publisher(self, kind, topic, depth):
        return Record(publish=lambda message: self.published.setdefault(topic, []).append(message))

    def create_subscription(self, kind, topic, callback, depth):
        self.subscriptions[topic] = callback

    def get_logger(self):
        return Record(warning=self.warnings.append, error=self.warnings.append)


def fake_ros():
    for name, members in {"rclpy": {}, "rclpy.node": {"Node": FakeNode}, "rclpy.time": {"Time": FakeTime},
                          "geometry_msgs": {}, "geometry_msgs.msg": {n: Record for n in ("Point", "Pose", "PoseArray", "PoseStamped")},
                          "nav_msgs": {}, "nav_msgs.msg": {"Path": Record}, "std_msgs": {}, "std_msgs.msg": {"Header": Record}}.items():
        module = types.ModuleType(name)
        module.__dict__.update(members)
        sys.modules[name] = module


class Ros2(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.frames = walk()
        os.environ["PATH"] = os.path.dirname(COMMAND) + os.pathsep + os.environ["PATH"]

    def test_child_process(self):
        from inhabit_stream import InhabitStream
        answers = []
        stream = InhabitStream(answers.append, arguments=["--up", "z", "--rate", "1", "--points", "200"], command=COMMAND)
        for t, joints in enumerate(self.frames[:60]):
            unseen = [(math.nan,) * 3 if j == 20 and t % 3 else joint for j, joint in enumerate(joints)]
            self.assertTrue(stream.push("anna", t / 30, unseen))
        self.assertTrue(stream.push("anna", 1.5, self.frames[0]))  # in the past
        self.assertEqual(stream.close(), 0)
        self.assertFalse(stream.push("anna", 9, self.frames[0]))
        self.assertEqual(answers[0]["ready"], "forecast")
        self.assertEqual([a["person"] for a in answers if "joints" in a], ["anna", "anna"])
        self.assertEqual(sum("error" in a for a in answers), 1)
        first = next(a for a in answers if "joints" in a)
        self.assertEqual((len(first["joints"]), len(first["joints"][0])), (60, 22))
        last_seen = self.frames[round(first["time"] * 30)][0]
        self.assertLess(math.dist(first["joints"][0][0], last_seen), 0.1)

    def test_docs_show_the_node(self):
        with open(os.path.join(SOURCE, "examples/ros2/forecast_node.py")) as file:
            node = file.read()
        with open(os.path.join(SOURCE, "docs/robots.md")) as file:
            shown = [block.split("```")[0] for block in file.read().split("```python\n")[1:]]
        self.assertTrue(any(block.startswith("class ForecastNode") and block in node for block in shown))
        self.assertLessEqual(len(node.splitlines()), 60)

    def test_node(self):
        fake_ros()
        FakeNode.parameters = {"people": ["a", "b"], "rate": 5.0,
                               "scene": os.path.join(SOURCE, "examples/data/walk_room.glb")}
        import forecast_node
        node = forecast_node.ForecastNode()
        self.assertEqual(sorted(node.subscriptions), ["/a/joints", "/b/joints"])
        for t, joints in enumerate(self.frames[:45]):
            message = Record(poses=[forecast_node.pose(joint) for joint in joints])
            message.header.stamp = FakeTime(round((100 + t / 30) * 1e9))
            node.subscriptions["/b/joints"](message)
        node.subscriptions["/a/joints"](Record(poses=[forecast_node.pose((0, 0, 0))],
                                               header=Record(stamp=FakeTime(0))))
        self.assertEqual(node.stream.close(), 0)
        self.assertEqual(sorted(node.published), ["/b/forecast", "/b/path"])
        self.assertEqual(len(node.warnings), 1)
        path, forecast = node.published["/b/path"][-1], node.published["/b/forecast"][-1]
        self.assertEqual((len(path.poses), len(forecast.poses)), (60, 22))
        self.assertEqual(path.header.frame_id, "map")
        seconds = (path.poses[-1].header.stamp.nanoseconds - path.header.stamp.nanoseconds) * 1e-9
        self.assertAlmostEqual(seconds, 2, places=6)
        self.assertTrue(0.5 < path.poses[0].pose.position.z < 1.3)  # a pelvis, z up


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
