"""A joint's bus as ROS 2 topics: JointState and TF of what its node estimates.

Listens to the ANGLES frames of an exported folder and sends nothing on the bus. Per complete
snapshot it publishes

- `joint_states` (sensor_msgs/JointState): two positions a segment, `NAME_u0`, `NAME_v0`, ...,
  radians, and `NAME_h0`, ... where the joint elongates, metres a section;
- TF: the end of every segment in the frame of the one before, `NAME_0` in `NAME_base`, ...

An axis without an estimate is left out of `joint_states`, and TF keeps silent until all are there
again. Times are those at which the frames came, on the clock of ROS.

    python3 ccgen_node.py firmware/finger --interface socketcan --channel can0
    python3 ccgen_node.py firmware/finger --interface slcan --channel /dev/ttyACM0 \\
        --ros-args -r joint_states:=finger/joint_states
"""

import argparse
import math
import sys
from pathlib import Path

import can
import numpy as np
import rclpy
from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.utilities import remove_ros_args
from sensor_msgs.msg import JointState
from tf2_ros import TransformBroadcaster

from ccgen.can.monitor import Monitor
from ccgen.can.seen import plain
from ccgen.kinematics import segment_transform
from ccgen.sensing.simulation import segment_lengths
from ccgen.targets.exported import open_exported

POLL_SECONDS = 0.002


class JointNode(Node):
    """Publishes what passes on one joint's bus."""

    def __init__(self, folder, bus):
        self.exported = open_exported(Path(folder))
        self.joint = self.exported.joint
        super().__init__(f"ccgen_{self.joint.name}")
        self.bus = bus
        self.watch = Monitor(self.exported.guarded, self.exported.codec, self.exported.fingerprint)
        self.states = self.create_publisher(JointState, "joint_states", 10)
        self.transforms = TransformBroadcaster(self)
        self.timer = self.create_timer(POLL_SECONDS, self.poll)

    def poll(self):
        """Take all frames that have come."""
        while (message := self.bus.recv(0.0)) is not None:
            for seen in self.watch.take(message):
                self.publish(plain(seen, self.exported.model, self.exported.layout))

    def publish(self, record):
        """Publish one snapshot."""
        stamp = self.get_clock().now().to_msg()
        bends = {axis: whole(values) for axis, values in record["angles_deg"].items()}
        shares = whole(record["elongation"])
        self.states.publish(self.joint_state(stamp, bends, shares))
        estimated = [bends[axis] for axis in bends]
        if None in estimated or ("h" in self.joint.axes and shares is None):
            return
        self.transforms.sendTransform(self.segment_frames(stamp, bends, shares))

    def joint_state(self, stamp, bends, shares):
        """Positions of all that is estimated."""
        message = JointState()
        message.header.stamp = stamp
        for axis, values in bends.items():
            for i, value in enumerate(values or []):
                message.name.append(f"{self.joint.name}_{axis}{i}")
                message.position.append(math.radians(value))
        lengths = np.array(self.joint.geometry.sections) * self.joint.geometry.segment_length
        for i, share in enumerate(shares or []):
            message.name.append(f"{self.joint.name}_h{i}")
            message.position.append(float(share * lengths[i]))
        return message

    def segment_frames(self, stamp, bends, shares):
        """The end of every segment in the frame of the one before."""
        geometry, name = self.joint.geometry, self.joint.name
        straight = [0.0] * geometry.segments
        u, v = (np.radians(bends.get(axis, straight)) for axis in "uv")
        lengths = segment_lengths(self.joint, np.array(shares or [0.0] * len(geometry.sections)))
        frames = []
        for i, pose in enumerate(segment_transform(u, v, lengths)):
            frame = TransformStamped()
            frame.header.stamp = stamp
            frame.header.frame_id = f"{name}_base" if i == 0 else f"{name}_{i - 1}"
            frame.child_frame_id = f"{name}_{i}"
            place, turn = frame.transform.translation, frame.transform.rotation
            place.x, place.y, place.z = (float(x) for x in pose[:3, 3])
            turn.x, turn.y, turn.z, turn.w = bend_quaternion(float(u[i]), float(v[i]))
            frames.append(frame)
        return frames


def bend_quaternion(u, v):
    """x, y, z, w of a segment that is bent about (u, v, 0), radians."""
    angle = math.hypot(u, v)
    share = math.sin(angle / 2) / angle if angle else 0.5
    return share * u, share * v, 0.0, math.cos(angle / 2)


def whole(values):
    """Values of an axis; None where one is missing."""
    return None if values is None or None in values else values


def main():
    """Run until ROS shuts down."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", help="that `ccgen export` wrote")
    parser.add_argument("--interface", required=True, help="python-can's name of the bus")
    parser.add_argument("--channel")
    stated = parser.parse_args(remove_ros_args(sys.argv)[1:])
    rclpy.init()
    with can.Bus(interface=stated.interface, channel=stated.channel) as bus:
        node = JointNode(stated.folder, bus)
        try:
            rclpy.spin(node)
        except KeyboardInterrupt:
            pass
        finally:
            node.destroy_node()
            rclpy.try_shutdown()


if __name__ == "__main__":
    main()
