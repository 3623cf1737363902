# SPDX-License-Identifier: Apache-2.0
"""From ROS images to what the server reads, and from its answer to a pose. Plain Python, no ROS.

What the two kinds of maps give, and what they can't give:

- A map of panoramas: the position, in the frame "MAP/appearance" of its panoramas, with the
  covariance that the answer states. Where the map's scale isn't known the position has no metres:
  it is the origin, and unknown.
- A map of planes: the keyframe near which the photo was taken. The pose is that of the camera in a
  frame of this keyframe's, "MAP/keyframe_ID", at its origin. Whoever has poses of the keyframes
  publishes them as static transforms. The distance from the keyframe isn't known: homographies
  between uncalibrated images have no scale. The position's covariance is what the options say, and
  unknown unless they do.
- A map that was built with poses in metres: the camera's pose in their frame, in six degrees of
  freedom, with its whole covariance. The camera has x right, y down, z forward, as optical frames
  of ROS have; a panorama's looks ahead where its middle column does. The frame is "FRAME" as the
  map was built, or "MAP/FRAME": several maps' frames may have one name, mostly "map".
- In the other frames an orientation is a yaw about z, of a body that looks along x (REP 103).
- A heading only where the answer has one. Without it, and always for roll and pitch, the angle is
  unknown: its variance is that of an angle which is equally likely everywhere, pi^2 / 3. Maps
  without poses don't know the height.
"""
import dataclasses
import math
from collections.abc import Mapping
from typing import Any

UNKNOWN_ANGLE_VARIANCE = math.pi**2 / 3  # rad^2, of a uniform angle in (-pi, pi]


class ConversionError(Exception):
    """An image that can't be sent, or an invalid answer; one line with cause and remedy."""


@dataclasses.dataclass(frozen=True)
class PoseOptions:
    """How sure a position is. Smaller deviations pull a filter harder towards the place."""

    # For maps of planes: standard deviation of the camera's distance from the keyframe along each
    # axis, m, above 0. It is a property of the place (how far away its walls are recognised), so
    # only its operator can say; None says unknown.
    position_deviation_m: float | None = None
    # Standard deviation that stands for "unknown", m, above 0: larger than the map, small enough
    # that filters can invert the covariance.
    unknown_deviation_m: float = 1000.0
    # Whether the frame of a map's poses is called "MAP/FRAME" as all others are, which tells the
    # frames of several maps apart. "FRAME" is for those who query one map only.
    map_in_frame: bool = False

    def __post_init__(self) -> None:
        for name in ("position_deviation_m", "unknown_deviation_m"):
            value = getattr(self, name)
            if value is not None and not 0 < value < math.inf:
                raise ValueError(f"{name} is {value}; it is a length above 0 in m")


@dataclasses.dataclass(frozen=True)
class Pose:
    """The camera's pose in `frame_id`, as geometry_msgs/PoseWithCovariance has it."""

    frame_id: str
    position: tuple[float, float, float]  # x, y, z, m
    orientation: tuple[float, float, float, float]  # quaternion x, y, z, w: the heading about z
    covariance: tuple[float, ...]  # 6 x 6 by rows: x, y, z, and rotations about x, y, z
    position_known: bool  # whether the variances of x and y are more than "unknown"
    heading_known: bool  # whether the answer had a heading


def pose_of(answer: Mapping[str, Any], options: PoseOptions = PoseOptions()) -> Pose | None:
    """The pose of a server's answer; None unless its verdict is "localized".

    A heading turns counter-clockwise seen from above (REP 103). One "of" the building is in the
    frame "MAP/building", where nothing is known of the position. Raises ConversionError if `answer`
    isn't one that the contract allows.
    """
    try:
        return _pose_of(answer, options)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        detail = f"the answer isn't one of Waystone's ({type(error).__name__}: {error})"
        raise ConversionError(f"{detail}; check the address of the server") from error


def _pose_of(answer: Mapping[str, Any], options: PoseOptions) -> Pose | None:
    place = answer["place"]
    if answer["verdict"] != "localized" or place is None:
        return None
    given = answer.get("pose")
    if given and given["unit"] == "metres":
        return _checked(_full_pose(given, f"{answer['map']}/" if options.map_in_frame else ""))
    heading = place["heading"]
    x, y, across_m, up_m = _position_of(place, options)
    yaw_rad = heading["rad"] if heading else 0.0
    variances = [deviation_m**2 for deviation_m in (across_m, across_m, up_m)]
    pose = Pose(
        frame_id=f"{answer['map']}/{_frame_of(place)}",
        position=(x, y, 0.0),
        orientation=(0.0, 0.0, math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)),
        covariance=_diagonal(variances + [UNKNOWN_ANGLE_VARIANCE] * 2 + [_yaw_variance(heading)]),
        position_known=across_m < options.unknown_deviation_m,
        heading_known=heading is not None,
    )
    return _checked(pose)


def _checked(pose: Pose) -> Pose:
    """The pose as finite floats: ROS takes no others, and filters keep a NaN for good."""
    pose = dataclasses.replace(
        pose,
        position=tuple(map(float, pose.position)),
        orientation=tuple(map(float, pose.orientation)),
        covariance=tuple(map(float, pose.covariance)),
    )
    if len(pose.covariance) != 36:
        raise ValueError("the covariance isn't 6 x 6")
    if not all(map(math.isfinite, pose.position + pose.orientation + pose.covariance)):
        raise ValueError("a number isn't finite")
    return pose


def _full_pose(given: Mapping[str, Any], prefix: str) -> Pose:
    x, y, z = given["position"]
    qx, qy, qz, qw = given["orientation"]
    return Pose(
        frame_id=prefix + given["frame"],
        position=(x, y, z),
        orientation=(qx, qy, qz, qw),
        covariance=tuple(value for row in given["covariance"] for value in row),
        position_known=True,
        heading_known=True,
    )


def _is_of_building(place: Mapping[str, Any]) -> bool:
    return place["heading"] is not None and place["heading"]["of"] == "building"


def _frame_of(place: Mapping[str, Any]) -> str:
    if _is_of_building(place):
        return "building"
    return "appearance" if place["layer"] == "appearance" else f"keyframe_{place['id']}"


def _position_of(
    place: Mapping[str, Any], options: PoseOptions
) -> tuple[float, float, float, float]:
    """x, y, and the deviations of both and of z, m."""
    unknown_m = options.unknown_deviation_m
    position = place["position"]
    if _is_of_building(place):
        return 0.0, 0.0, unknown_m, unknown_m
    if position is None:
        known_m = options.position_deviation_m
        near_m = unknown_m if known_m is None or place["layer"] != "planes" else known_m
        return 0.0, 0.0, near_m, near_m
    scale = position["metres_per_unit"]
    if scale is None:
        return 0.0, 0.0, unknown_m, unknown_m
    deviation_m = min(scale * position["deviation"], unknown_m)
    return scale * position["x"], scale * position["y"], deviation_m, unknown_m


def _yaw_variance(heading: Mapping[str, Any] | None) -> float:
    if heading is None:
        return UNKNOWN_ANGLE_VARIANCE
    return min(float(heading["deviation_rad"]) ** 2, UNKNOWN_ANGLE_VARIANCE)


def _diagonal(variances: list[float]) -> tuple[float, ...]:
    size = len(variances)
    return tuple(variances[i // size] if i % (size + 1) == 0 else 0.0 for i in range(size**2))


# sensor_msgs/Image encodings: number of channels, and the indices of red, green and blue (or grey).
_ENCODINGS: dict[str, tuple[int, tuple[int, ...]]] = {
    "mono8": (1, (0,)),
    "8UC1": (1, (0,)),
    "rgb8": (3, (0, 1, 2)),
    "bgr8": (3, (2, 1, 0)),
    "8UC3": (3, (2, 1, 0)),
    "rgba8": (4, (0, 1, 2)),
    "bgra8": (4, (2, 1, 0)),
}


def pnm_of_image(image: Any) -> bytes:
    """A sensor_msgs/Image of 8 bits per channel as PGM or PPM, which need no compression here."""
    if image.encoding not in _ENCODINGS:
        names = ", ".join(_ENCODINGS)
        detail = f"encoding {image.encoding!r} can't be sent; republish as one of {names}"
        raise ConversionError(detail + ", or as compressed")
    channels, order = _ENCODINGS[image.encoding]
    row_bytes = image.width * channels
    data = bytes(image.data)
    if not row_bytes or image.step < row_bytes or len(data) < image.step * image.height:
        raise ConversionError(
            f"{image.width}x{image.height} {image.encoding} with step {image.step} doesn't fit "
            f"{len(data)} bytes; the camera driver is at fault"
        )
    # Rows may end with padding.
    rows = (data[y * image.step : y * image.step + row_bytes] for y in range(image.height))
    magic = "P5" if len(order) == 1 else "P6"
    header = f"{magic}\n{image.width} {image.height}\n255\n"
    return header.encode() + _reordered(b"".join(rows), channels, order)


def bytes_of_compressed(image: Any) -> bytes:
    """The bytes of a sensor_msgs/CompressedImage, which the server decodes."""
    if "compressedDepth" in image.format:
        raise ConversionError(f"format {image.format!r} is depth; subscribe to the colour image")
    return bytes(image.data)


def _reordered(pixels: bytes, channels: int, order: tuple[int, ...]) -> bytes:
    if order == tuple(range(channels)):
        return pixels
    out = bytearray(len(pixels) // channels * len(order))
    for to, source in enumerate(order):
        out[to :: len(order)] = pixels[source::channels]
    return bytes(out)
