# SPDX-License-Identifier: Apache-2.0
import pathlib

from setuptools import setup

# Where the client isn't installed for itself, it may lie beside this file.
MODULES = [path.stem for path in pathlib.Path(__file__).parent.glob("waystone_client.py")]

setup(
    name="waystone_ros2",
    version="0.1.0",
    packages=["waystone_ros2"],
    py_modules=MODULES,
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/waystone_ros2"]),
        ("share/waystone_ros2", ["package.xml"]),
    ],
    license="Apache-2.0",
    entry_points={"console_scripts": ["waystone = waystone_ros2.node:main"]},
)
