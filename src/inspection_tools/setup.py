"""catkin's description of the Python packages; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

# Two source folders, because the devel space puts a package's source folder first on sys.path: beside the
# library, inspection_tools_ros would let Python find it there, without its generated inspection_tools.cfg.
setup(
    **generate_distutils_setup(
        packages=["inspection_tools", "inspection_tools_ros"],
        package_dir={"": "src", "inspection_tools_ros": "ros/inspection_tools_ros"},
    )
)
