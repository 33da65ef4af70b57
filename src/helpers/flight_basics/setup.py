"""catkin's description of the Python packages; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "flight_basics",
            "flight_basics.errand",
            "flight_basics.pose",
            "flight_basics_ros",
        ],
        package_dir={"": "src", "flight_basics_ros": "ros/flight_basics_ros"},
    )
)
