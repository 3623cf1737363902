#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The conversion of clients/ros2, without ROS and without a server."""
import math
import pathlib
import runpy
import shutil
import sys
import tempfile
import types
import unittest
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "clients/ros2"))

from waystone_ros2.conversion import (  # noqa: E402
    UNKNOWN_ANGLE_VARIANCE,
    ConversionError,
    PoseOptions,
    bytes_of_compressed,
    pnm_of_image,
    pose_of,
)

VERDICTS = ["localized", "ambiguous", "not_in_map", "bad_image", "undecided"]


def answer(verdict="localized", heading=None, keyframe=17):
    place = {"layer": "planes", "id": keyframe, "image": "17.jpg", "sequence": "s", "time_s": None,
             "position": None, "heading": heading}  # fmt: skip
    return {"verdict": verdict, "map": "lab", "place": place if keyframe else None}


def panorama(heading=None, metres_per_unit=0.5, deviation=0.2):
    position = {"x": 3.0, "y": -1.0, "deviation": deviation, "metres_per_unit": metres_per_unit}
    place = {"layer": "appearance", "id": 7, "image": "7.jpg", "sequence": "s", "time_s": 1.0,
             "position": position, "heading": heading}  # fmt: skip
    return {"verdict": "localized", "map": "lab", "place": place}


def heading(rad, deviation_rad=0.02, of="keyframe"):
    return {"rad": rad, "deviation_rad": deviation_rad, "of": of}


def rotated(quaternion, vector):
    """Rotates by q v q*, written out for a quaternion about z alone."""
    x, y, z, w = quaternion
    assert x == 0 and y == 0
    cos, sin = w * w - z * z, 2 * w * z
    return (cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1], vector[2])


def variances(pose):
    return [pose.covariance[7 * i] for i in range(6)]


def raw(encoding, width, height, data, step=None, channels=1):
    return types.SimpleNamespace(encoding=encoding, width=width, height=height, data=data,
                                 step=width * channels if step is None else step)


class FullPoseTest(unittest.TestCase):
    GIVEN = {"frame": "hall", "unit": "metres", "position": [1.0, 2.0, 3.0],
             "orientation": [0.1, 0.2, 0.3, 0.927], "inliers": 50, "camera": "query",
             "covariance": [[0.01 * (6 * i + j) for j in range(6)] for i in range(6)]}  # fmt: skip

    def test_a_pose_in_metres_is_handed_on_whole(self):
        pose = pose_of(answer() | {"pose": self.GIVEN})
        self.assertEqual(pose.frame_id, "hall")
        self.assertEqual(pose.position, (1.0, 2.0, 3.0))
        self.assertEqual(pose.orientation, (0.1, 0.2, 0.3, 0.927))
        self.assertEqual(len(pose.covariance), 36)
        self.assertEqual(pose.covariance[7], 0.01 * 7)
        self.assertEqual(pose.covariance[1], 0.01)
        self.assertTrue(pose.position_known and pose.heading_known)

    def test_the_frames_of_several_maps_are_told_apart(self):
        options = PoseOptions(map_in_frame=True)
        for name in ("lab", "hall"):
            found = answer() | {"map": name, "pose": self.GIVEN | {"frame": "map"}}
            self.assertEqual(pose_of(found, options).frame_id, f"{name}/map")
            self.assertEqual(pose_of(found).frame_id, "map")

    def test_without_metres_or_pose_the_place_is_what_is_known(self):
        for given in (self.GIVEN | {"unit": "unknown"}, None):
            self.assertEqual(pose_of(answer() | {"pose": given}).frame_id, "lab/keyframe_17")

    def test_only_localized_gives_it(self):
        self.assertIsNone(pose_of(answer("ambiguous", keyframe=None) | {"pose": self.GIVEN}))


class PoseTest(unittest.TestCase):
    def test_only_localized_gives_a_pose(self):
        given = [verdict for verdict in VERDICTS if pose_of(answer(verdict)) is not None]
        self.assertEqual(given, ["localized"])
        self.assertIsNone(pose_of(answer(keyframe=None)))

    def test_the_plane_layer_gives_a_place_and_says_what_it_cannot(self):
        pose = pose_of(answer())
        self.assertEqual(pose.frame_id, "lab/keyframe_17")
        self.assertEqual(pose.position, (0, 0, 0))
        self.assertFalse(pose.position_known)
        self.assertFalse(pose.heading_known)
        self.assertEqual(variances(pose), [1e6] * 3 + [UNKNOWN_ANGLE_VARIANCE] * 3)

    def test_unknown_angle_is_the_uniform_one(self):
        steps = 100_000
        angles = [math.pi * (2 * (i + 0.5) / steps - 1) for i in range(steps)]
        self.assertAlmostEqual(sum(a * a for a in angles) / steps, UNKNOWN_ANGLE_VARIANCE, 6)

    def test_heading_turns_counter_clockwise_about_z(self):
        for rad in (-3.0, -0.5, 0.0, 0.31, math.pi / 2, 3.1):
            pose = pose_of(answer(heading=heading(rad)))
            x, y, _ = rotated(pose.orientation, (1, 0, 0))
            self.assertAlmostEqual(x, math.cos(rad))
            self.assertAlmostEqual(y, math.sin(rad))
            self.assertAlmostEqual(sum(part**2 for part in pose.orientation), 1)

    def test_heading_sets_the_variance_about_z_alone(self):
        pose = pose_of(answer(heading=heading(0.3, 0.02)))
        self.assertTrue(pose.heading_known)
        self.assertAlmostEqual(variances(pose)[5], 0.0004)
        self.assertEqual(variances(pose)[3:5], [UNKNOWN_ANGLE_VARIANCE] * 2)
        wild = pose_of(answer(heading=heading(0.3, 50)))
        self.assertEqual(variances(wild)[5], UNKNOWN_ANGLE_VARIANCE)

    def test_heading_of_the_building_has_no_position(self):
        pose = pose_of(answer(heading=heading(1, of="building")), PoseOptions(2.0))
        self.assertEqual(pose.frame_id, "lab/building")
        self.assertFalse(pose.position_known)
        self.assertEqual(variances(pose)[0], 1e6)

    def test_position_is_as_sure_as_its_operator_says(self):
        pose = pose_of(answer(), PoseOptions(position_deviation_m=1.5))
        self.assertTrue(pose.position_known)
        self.assertEqual(variances(pose)[:3], [2.25] * 3)

    def test_covariance_is_positive_definite_and_diagonal(self):
        for pose in (pose_of(answer()), pose_of(answer(heading=heading(1)), PoseOptions(0.5))):
            self.assertEqual(len(pose.covariance), 36)
            self.assertGreater(min(variances(pose)), 0)
            self.assertEqual(sum(map(bool, pose.covariance)), 6)

    def test_panoramas_give_a_position_in_metres(self):
        pose = pose_of(panorama(heading(0.5, 0.02, "layer")), PoseOptions(9.0))
        self.assertEqual(pose.frame_id, "lab/appearance")
        self.assertEqual(pose.position, (1.5, -0.5, 0))
        self.assertTrue(pose.position_known)
        for variance, wanted in zip(variances(pose), [0.01, 0.01, 1e6]):
            self.assertAlmostEqual(variance, wanted)
        self.assertAlmostEqual(variances(pose)[5], 0.0004)
        self.assertAlmostEqual(rotated(pose.orientation, (1, 0, 0))[1], math.sin(0.5))

    def test_panoramas_without_a_scale_give_no_metres(self):
        pose = pose_of(panorama(metres_per_unit=None), PoseOptions(9.0))
        self.assertEqual(pose.frame_id, "lab/appearance")
        self.assertEqual(pose.position, (0, 0, 0))
        self.assertFalse(pose.position_known)
        self.assertEqual(variances(pose)[:3], [1e6] * 3)
        self.assertEqual(variances(pose_of(panorama(deviation=1e9)))[0], 1e6)

    def test_what_is_no_answer_is_told(self):
        full = answer() | {"pose": FullPoseTest.GIVEN}
        strangers = [None, [], "localized", {}, {"fine": True}, {"verdict": "localized"},
                     answer() | {"place": [1]}, answer() | {"place": {}}, answer(heading="north"),
                     answer(heading=heading(None)), answer(heading=heading(1, math.nan)),
                     answer(heading=heading(math.inf)), answer(heading=heading(0, 1e200)),
                     answer() | {"pose": "here"},
                     panorama(metres_per_unit="2"), panorama(deviation=None)]  # fmt: skip
        for wrong in ({"frame": 7}, {"position": [1, 2]}, {"position": [1, 2, math.nan]},
                      {"orientation": [0, 0, 0, "w"]}, {"covariance": [[0.1] * 6] * 5},
                      {"covariance": [[math.inf] * 6] * 6}, {"covariance": None}):
            strangers.append(full | {"pose": FullPoseTest.GIVEN | wrong})
        for stranger in strangers:
            with self.subTest(stranger), self.assertRaisesRegex(ConversionError, "isn't one of"):
                pose_of(stranger)

    def test_numbers_without_a_point_become_floats(self):
        given = FullPoseTest.GIVEN | {"position": [1, 2, 3], "orientation": [0, 0, 0, 1]}
        for pose in (pose_of(answer() | {"pose": given}), pose_of(answer(heading=heading(1, 0)))):
            numbers = pose.position + pose.orientation + pose.covariance
            self.assertEqual({type(number) for number in numbers}, {float})

    def test_lengths_are_above_zero(self):
        for bad in (0, -1, math.inf, math.nan):
            with self.assertRaisesRegex(ValueError, "position_deviation_m"):
                PoseOptions(position_deviation_m=bad)


class ImageTest(unittest.TestCase):
    def test_every_encoding_gives_the_same_colours(self):
        pixels = [(10, 20, 30), (40, 50, 60), (70, 80, 90), (1, 2, 3)]
        orders = {"rgb8": (0, 1, 2), "bgr8": (2, 1, 0), "8UC3": (2, 1, 0),
                  "rgba8": (0, 1, 2, None), "bgra8": (2, 1, 0, None)}
        wanted = b"P6\n2 2\n255\n" + bytes(value for pixel in pixels for value in pixel)
        for encoding, order in orders.items():
            data = bytes(255 if i is None else pixel[i] for pixel in pixels for i in order)
            image = raw(encoding, 2, 2, data, channels=len(order))
            self.assertEqual(pnm_of_image(image), wanted, encoding)

    def test_padding_of_rows_is_left_out(self):
        image = raw("mono8", 3, 2, b"abc__def__", step=5)
        self.assertEqual(pnm_of_image(image), b"P5\n3 2\n255\nabcdef")

    def test_data_may_be_any_sequence_of_bytes(self):
        for data in (bytearray(b"abcd"), memoryview(b"abcd"), list(b"abcd")):
            self.assertTrue(pnm_of_image(raw("mono8", 2, 2, data)).endswith(b"\nabcd"))

    def test_what_cannot_be_sent_is_named(self):
        with self.assertRaisesRegex(ConversionError, "bayer_rggb8.*republish"):
            pnm_of_image(raw("bayer_rggb8", 2, 2, b"abcd"))
        for image in (raw("mono8", 2, 2, b"abc"), raw("rgb8", 2, 2, b"abcd", step=2),
                      raw("mono8", 0, 0, b"")):
            with self.assertRaisesRegex(ConversionError, "doesn't fit"):
                pnm_of_image(image)

    def test_compressed_images_pass_unchanged_but_depth(self):
        image = types.SimpleNamespace(format="bgr8; jpeg compressed bgr8", data=b"\xff\xd8x")
        self.assertEqual(bytes_of_compressed(image), b"\xff\xd8x")
        image.format = "16UC1; compressedDepth png"
        with self.assertRaisesRegex(ConversionError, "depth"):
            bytes_of_compressed(image)


class SetupTest(unittest.TestCase):
    def test_a_client_beside_setup_py_is_installed_too(self):
        stand_in = types.SimpleNamespace(setup=mock.Mock())
        with (tempfile.TemporaryDirectory() as folder,
              mock.patch.dict(sys.modules, {"setuptools": stand_in})):  # fmt: skip
            script = shutil.copy(ROOT / "clients/ros2/setup.py", folder)
            runpy.run_path(script)
            shutil.copy(ROOT / "clients/python/waystone_client.py", folder)
            runpy.run_path(script)
        modules = [call.kwargs["py_modules"] for call in stand_in.setup.call_args_list]
        self.assertEqual(modules, [[], ["waystone_client"]])


if __name__ == "__main__":
    unittest.main()
