"""catkin's description of the Python packages; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

# Two source folders, because the devel space puts a package's source folder first on sys.path. With
# exploration_ros in the library's folder, Python would find the library there, without the generated
# messages.
setup(
    **generate_distutils_setup(
        packages=[
            "exploration",
            "exploration.energy",
            "exploration.next_view",
            "exploration.next_view.kernels",
            "exploration.next_view.unknown",
            "exploration.next_view.views",
            "exploration.planning",
            "exploration.planning.kernels",
            "exploration_ros",
        ],
        package_dir={"": "src", "exploration_ros": "ros/exploration_ros"},
    )
)
