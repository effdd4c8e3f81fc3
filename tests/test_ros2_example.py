"""examples/ros2: what it publishes, against the documented interface of rclpy and its messages.

rclpy is no package of PyPI. What stands in for it takes what its documentation and the messages'
definitions allow, and nothing else: fields have their types, unknown ones are refused.
"""

import importlib.util
import sys
import time
from pathlib import Path
from types import ModuleType
from typing import ClassVar

import can
import numpy as np
import pytest

import ccgen
from ccgen.cli.main import main
from ccgen.kinematics import tip_pose
from ccgen.recordings.log_files import read_frames

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


class Message:
    """A message of ROS: fields by name with defaults; a value of another type is refused."""

    fields: ClassVar[dict] = {}

    def __init__(self):
        for name, make in self.fields.items():
            object.__setattr__(self, name, make())

    def __setattr__(self, name, value):
        assert name in self.fields, f"{type(self).__name__} has no field {name}"
        assert type(value) is type(self.fields[name]()), f"{name} = {value!r}"
        object.__setattr__(self, name, value)


def message(kind, /, **fields):
    return type(kind, (Message,), {"fields": fields})


Time = message("Time", sec=int, nanosec=int)  # builtin_interfaces
Header = message("Header", stamp=Time, frame_id=str)  # std_msgs
JointState = message("JointState", header=Header, name=list, position=list, velocity=list,
                     effort=list)  # fmt: skip
Vector3 = message("Vector3", x=float, y=float, z=float)
Quaternion = message("Quaternion", x=float, y=float, z=float, w=float)
Transform = message("Transform", translation=Vector3, rotation=Quaternion)
TransformStamped = message("TransformStamped", header=Header, child_frame_id=str,
                           transform=Transform)  # fmt: skip


class Publisher:
    def __init__(self, kind):
        self.kind, self.sent = kind, []

    def publish(self, msg):
        assert isinstance(msg, self.kind)
        self.sent.append(msg)


class Clock:
    def now(self):
        return self

    def to_msg(self):
        stamp = Time()
        stamp.sec, stamp.nanosec = 7, 5
        return stamp


class Node:
    def __init__(self, node_name):
        assert node_name.isidentifier()
        self.publishers_by_topic, self.timers_of_node = {}, []

    def create_publisher(self, msg_type, topic, qos_profile):
        return self.publishers_by_topic.setdefault(topic, Publisher(msg_type))

    def create_timer(self, timer_period_sec, callback):
        self.timers_of_node.append((timer_period_sec, callback))
        return callback

    def get_clock(self):
        return Clock()

    def destroy_node(self):
        self.timers_of_node.clear()


class TransformBroadcaster:
    def __init__(self, node):
        assert isinstance(node, Node)
        self.sent = []

    def sendTransform(self, transform):  # noqa: N802 (the name that tf2_ros gives it)
        transforms = transform if isinstance(transform, list) else [transform]
        assert all(isinstance(one, TransformStamped) for one in transforms)
        self.sent.append(transforms)


def module(name, **names):
    made = ModuleType(name)
    made.__dict__.update(names)
    return made


@pytest.fixture
def example(monkeypatch):
    """The example with what stands in for ROS."""
    fakes = [
        module("rclpy", spin=lambda node: None, init=lambda: None, try_shutdown=lambda: None),
        module("rclpy.node", Node=Node),
        module("rclpy.utilities", remove_ros_args=lambda args: args),
        module("geometry_msgs"),
        module("geometry_msgs.msg", TransformStamped=TransformStamped),
        module("sensor_msgs"),
        module("sensor_msgs.msg", JointState=JointState),
        module("tf2_ros", TransformBroadcaster=TransformBroadcaster),
    ]
    for one in fakes:
        monkeypatch.setitem(sys.modules, one.__name__, one)
    spec = importlib.util.spec_from_file_location("ros", EXAMPLES / "ros2" / "ccgen_node.py")
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


def turned(q):
    x, y, z, w = q.x, q.y, q.z, q.w
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_snapshots_become_joint_states_and_frames_that_end_at_the_tip(example, tmp_path):
    folder, log = tmp_path / "shoulder", tmp_path / "run.log"
    ccgen.export(ccgen.load(EXAMPLES / "shoulder.toml"), folder)
    with pytest.raises(SystemExit) as end:
        main(["bridge", str(folder), "--seconds", "0.2", "--log", str(log)])
    assert not end.value.code
    with (
        can.Bus(interface="virtual", channel="ros") as far,
        can.Bus(interface="virtual", channel="ros") as near,
    ):
        node = example.JointNode(folder, near)
        ((period, poll),) = node.timers_of_node
        assert 0 < period < 0.01
        for frame in read_frames(log):
            far.send(frame)
        time.sleep(0.05)
        poll()
    states, frames = node.publishers_by_topic["joint_states"].sent, node.transforms.sent
    assert len(states) == len(frames) > 10
    names = [f"shoulder_{axis}{i}" for axis in "uv" for i in range(12)]
    for state, chain in zip(states, frames, strict=True):
        assert state.name == names
        u, v = np.array(state.position).reshape(2, 12)
        pose = np.eye(4)
        for i, one in enumerate(chain):
            parent = "shoulder_base" if i == 0 else f"shoulder_{i - 1}"
            assert (one.header.frame_id, one.child_frame_id) == (parent, f"shoulder_{i}")
            assert (one.header.stamp.sec, one.header.stamp.nanosec) == (7, 5)
            place = one.transform.translation
            step = np.eye(4)
            step[:3, :3], step[:3, 3] = turned(one.transform.rotation), (place.x, place.y, place.z)
            pose = pose @ step
        np.testing.assert_allclose(pose, tip_pose(u, v, 0.02), atol=1e-12)


def test_an_axis_without_an_estimate_is_left_out(example, tmp_path):
    folder = tmp_path / "shoulder"
    ccgen.export(ccgen.load(EXAMPLES / "shoulder.toml"), folder)
    node = example.JointNode(folder, None)
    lost = {"angles_deg": {"u": [1.0] * 12, "v": [None] * 12}, "elongation": None}
    node.publish(lost)
    (state,) = node.publishers_by_topic["joint_states"].sent
    assert state.name == [f"shoulder_u{i}" for i in range(12)]
    assert node.transforms.sent == []
