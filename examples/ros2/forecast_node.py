#!/usr/bin/env python3
"""A ROS 2 node that says where people will be in the next two seconds.

    ros2 run ... or: python3 forecast_node.py --ros-args -p people:='[person_1]' -p scene:=room.glb -p frame:=map

Takes /PERSON/joints (geometry_msgs/PoseArray): the 22 standard joints (docs/robots.md), metres, z up, in a frame that does
not move; a position of NaN was not seen. Gives /PERSON/path (nav_msgs/Path), where the pelvis goes, and /PERSON/forecast
(geometry_msgs/PoseArray), the joints in two seconds."""
import rclpy
from geometry_msgs.msg import Point, Pose, PoseArray, PoseStamped
from nav_msgs.msg import Path
from rclpy.node import Node
from rclpy.time import Time
from std_msgs.msg import Header

from inhabit_stream import InhabitStream


def pose(place):
    x, y, z = map(float, place)
    return Pose(position=Point(x=x, y=y, z=z))


class ForecastNode(Node):
    def __init__(self):
        super().__init__("inhabit_forecast")
        people = self.declare_parameter("people", ["person"]).value
        scene = self.declare_parameter("scene", "").value
        self.frame = self.declare_parameter("frame", "map").value
        arguments = ["--live", "--up", "z", "--rate", str(self.declare_parameter("rate", 5.0).value)]
        arguments += ["--scene", scene] if scene else []
        self.outputs = {p: (self.create_publisher(Path, f"/{p}/path", 10),
                            self.create_publisher(PoseArray, f"/{p}/forecast", 10)) for p in people}
        self.stream = InhabitStream(self.told, arguments=arguments)
        self.inputs = [self.create_subscription(PoseArray, f"/{p}/joints", lambda m, p=p: self.seen(p, m), 10) for p in people]

    def header(self, seconds):
        return Header(frame_id=self.frame, stamp=Time(nanoseconds=round(seconds * 1e9)).to_msg())

    def seen(self, person, message):
        places = [(p.position.x, p.position.y, p.position.z) for p in message.poses]
        if not self.stream.push(person, Time.from_msg(message.header.stamp).nanoseconds * 1e-9, places):
            self.get_logger().error("inhabit stream has ended")

    def told(self, answer):
        if "error" in answer:
            self.get_logger().warning(answer["error"])
        if "joints" not in answer:  # the first line, or an error
            return
        now, joints = answer["time"], answer["joints"]
        times = [now + k / answer["rate"] for k in range(1, len(joints) + 1)]
        steps = [PoseStamped(header=self.header(t), pose=pose(frame[0])) for t, frame in zip(times, joints)]
        path, forecast = self.outputs[answer["person"]]
        path.publish(Path(header=self.header(now), poses=steps))
        forecast.publish(PoseArray(header=self.header(times[-1]), poses=[pose(joint) for joint in joints[-1]]))


if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(ForecastNode())
