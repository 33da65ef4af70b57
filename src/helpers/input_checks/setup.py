"""catkin's description of the Python packages; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=["input_checks", "input_checks_ros"],
        package_dir={"": "src", "input_checks_ros": "ros/input_checks_ros"},
    )
)
