"""catkin's description of the Python packages; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gridslam",
            "gridslam.evaluation",
            "gridslam.files",
            "gridslam.filter",
            "gridslam.inputs",
            "gridslam.kernels",
            "gridslam.localisation",
            "gridslam.logs",
            "gridslam.loop_closure",
            "gridslam.maps",
            "gridslam.odometry",
            "gridslam.search",
            "gridslam.tracking",
            "gridslam_ros",
            "gridslam_ros.odometry",
            "gridslam_ros.publishing",
        ],
        package_dir={"": "src", "gridslam_ros": "ros/gridslam_ros"},
    )
)
