# SPDX-License-Identifier: Apache-2.0
"""The node waystone: images in, a pose out when the server knows the place. See README.md."""
import json
import sys

import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image as RawImage
from std_msgs.msg import String
from waystone_client import Client, Image, Options, WaystoneError, read_token_file

from waystone_ros2.conversion import (
    ConversionError,
    Pose,
    PoseOptions,
    bytes_of_compressed,
    pnm_of_image,
    pose_of,
)

QUIET_S = 5.0  # between two warnings

# Cameras send as they can; only the newest image is worth a query.
NEWEST = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.BEST_EFFORT
)


class WaystoneNode(Node):
    """Queries one image at a time. Of those that arrive meanwhile only the newest is kept."""

    def __init__(self):
        super().__init__("waystone")
        value = {name: self._parameter(name, default) for name, default in (
            ("server", "http://127.0.0.1:8080"), ("map", ""), ("token_file", ""),
            ("timeout_s", 2.0), ("fov_deg", 0.0), ("compressed", True),
            ("position_deviation_m", 0.0))}  # fmt: skip
        # No retries: the next image is younger than this one would be.
        token = read_token_file(value["token_file"]) if value["token_file"] else None
        self._client = Client(value["server"], token=token, timeout_s=value["timeout_s"],
                              retries=0)  # fmt: skip
        self._map = value["map"] or None
        self._options = Options(fov_deg=value["fov_deg"] or None)
        self._pose_options = PoseOptions(
            position_deviation_m=value["position_deviation_m"] or None,
            map_in_frame=self._map is None,
        )
        self._pose = self.create_publisher(PoseWithCovarianceStamped, "~/pose", 1)
        self._answer = self.create_publisher(String, "~/answer", 1)
        if value["compressed"]:
            kind, topic, callback = CompressedImage, "image/compressed", self._on_compressed
        else:
            kind, topic, callback = RawImage, "image", self._on_raw
        self.create_subscription(kind, topic, callback, NEWEST)

    def _parameter(self, name, default):
        """A parameter of the default's type. ROS takes `63` for an integer, no float, and would
        refuse it."""
        descriptor = ParameterDescriptor(dynamic_typing=True)
        value = self.declare_parameter(name, default, descriptor).value
        if isinstance(default, float) and type(value) is int:
            return float(value)
        if type(value) is not type(default):
            kind = {str: "text", bool: "true or false", float: "a number"}[type(default)]
            raise ValueError(f"the parameter {name} is {value!r}; expected {kind}")
        return value

    def _on_compressed(self, message):
        self._ask(message.header, bytes_of_compressed, message)

    def _on_raw(self, message):
        self._ask(message.header, pnm_of_image, message)

    def _ask(self, header, convert, message):
        name = f"{header.stamp.sec}.{header.stamp.nanosec:09d}"
        try:
            photo = Image(name, convert(message))
            answer = self._client.localize(photo, map=self._map, options=self._options)
            pose = pose_of(answer, self._pose_options)
            if pose is None:
                return
            self._pose.publish(_message_of(pose, header.stamp))
            self._answer.publish(String(data=json.dumps(answer)))
        except (ConversionError, WaystoneError) as error:
            self._warn(str(error))
        except Exception as error:  # one image mustn't end the node; the next one is queried
            self._warn(f"image {name} is dropped: {type(error).__name__}: {error}")

    def _warn(self, text):
        self.get_logger().warning(text, throttle_duration_sec=QUIET_S)


def _message_of(pose: Pose, stamp):
    message = PoseWithCovarianceStamped()
    message.header.stamp = stamp
    message.header.frame_id = pose.frame_id
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    position.x, position.y, position.z = pose.position
    orientation.x, orientation.y, orientation.z, orientation.w = pose.orientation
    message.pose.covariance = list(pose.covariance)
    return message


def main():
    """The program of `ros2 run waystone_ros2 waystone`. Returns its exit code."""
    rclpy.init()
    try:
        node = WaystoneNode()
    except ValueError as error:  # of a parameter
        print(f"waystone: {error}", file=sys.stderr)
        rclpy.try_shutdown()
        return 2
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):  # SIGINT; SIGTERM
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    return 0
