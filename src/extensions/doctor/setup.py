"""catkin's description of the Python packages; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "doctor",
            "doctor.preflight",
            "doctor_ros",
            "doctor_ros.preflight",
        ],
        package_dir={"": "src", "doctor_ros": "ros/doctor_ros"},
    )
)
