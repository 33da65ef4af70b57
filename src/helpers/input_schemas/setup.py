"""catkin's description of the Python package; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(**generate_distutils_setup(packages=["input_schemas"], package_dir={"": "src"}))
