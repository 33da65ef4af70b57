"""catkin's description of the Python packages; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gridslam",
            "gridslam.cloud_odometry",
            "gridslam.cloud_odometry.kernels",
            "gridslam.evaluation",
            "gridslam.evaluation.volume",
            "gridslam.files",
            "gridslam.filter",
            "gridslam.filter.kept",
            "gridslam.inputs",
            "gridslam.kernels",
            "gridslam.localisation",
            "gridslam.logs",
            "gridslam.loop_closure",
            "gridslam.loop_closure.links",
            "gridslam.loop_closure.local_maps",
            "gridslam.loop_closure.path",
            "gridslam.loop_closure.space",
            "gridslam.maps",
            "gridslam.odometry",
            "gridslam.search",
            "gridslam.tracking",
            "gridslam.volume",
            "gridslam.volume.correction",
            "gridslam.volume.drawing",
            "gridslam.volume.kernels",
            "gridslam.volume.octree",
            "gridslam.volume.plates",
            "gridslam.volume.saved",
            "gridslam.volume.scans",
            "gridslam.watches",
            "gridslam_ros",
            "gridslam_ros.beside",
            "gridslam_ros.frames",
            "gridslam_ros.odometry",
            "gridslam_ros.publishing",
            "gridslam_ros.volume",
        ],
        package_dir={"": "src", "gridslam_ros": "ros/gridslam_ros"},
    )
)
