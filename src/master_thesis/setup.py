"""catkin's description of the Python package; run by catkin, not by hand."""

from distutils.core import setup

from catkin_pkg.python_setup import generate_distutils_setup

setup(**generate_distutils_setup(packages=["master_thesis", "master_thesis_ros"], package_dir={"": "src"}))
