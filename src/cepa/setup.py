"""catkin's description of the Python packages; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

# Two source folders, because the devel space puts a package's source folder first on sys.path: beside the
# library, cepa_ros would let Python find it there, without its generated cepa.cfg.
setup(
    **generate_distutils_setup(
        packages=[
            "cepa",
            "cepa.dynamic",
            "cepa.dynamic.constants",
            "cepa.dynamic.cost_to_go",
            "cepa.dynamic.cost_to_go.kernels",
            "cepa.dynamic.free_space",
            "cepa.dynamic.free_space.kernels",
            "cepa.dynamic.kernels",
            "cepa.dynamic.obstacle_tracks",
            "cepa.dynamic.obstacle_tracks.kernels",
            "cepa.dynamic.remembered",
            "cepa.dynamic.remembered.kernels",
            "cepa.dynamic.ways_out",
            "cepa.identification",
            "cepa.kernels",
            "cepa.steering",
            "cepa.thesis",
            "cepa.thesis.kernels",
            "cepa_ros",
        ],
        package_dir={"": "src", "cepa_ros": "ros/cepa_ros"},
    )
)
