# SPDX-License-Identifier: Apache-2.0
from setuptools import setup

setup(
    name="waystone_ros2",
    version="0.1.0",
    packages=["waystone_ros2"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/waystone_ros2"]),
        ("share/waystone_ros2", ["package.xml"]),
    ],
    license="Apache-2.0",
    entry_points={"console_scripts": ["waystone = waystone_ros2.node:main"]},
)
