"""catkin's description of the Python packages; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

# Two source folders, because the devel space puts a package's source folder first on sys.path. With
# inspection_tools_ros in the library's folder, Python would find the library there, without the generated
# messages.
setup(
    **generate_distutils_setup(
        packages=[
            "inspection_tools",
            "inspection_tools.mission",
            "inspection_tools.yaw",
            "inspection_tools_ros",
        ],
        package_dir={"": "src", "inspection_tools_ros": "ros/inspection_tools_ros"},
    )
)
