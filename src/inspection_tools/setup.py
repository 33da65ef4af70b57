"""catkin's description of the Python packages; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

# Two source folders, because the devel space puts a package's source folder first on sys.path. With
# inspection_tools_ros in the library's folder, Python would find the library there, without the generated
# inspection_tools.cfg.
setup(
    **generate_distutils_setup(
        packages=[
            "inspection_tools",
            "inspection_tools.camera",
            "inspection_tools.energy",
            "inspection_tools.exploration",
            "inspection_tools.exploration.kernels",
            "inspection_tools.exploration.unknown",
            "inspection_tools.exploration.views",
            "inspection_tools.files",
            "inspection_tools.findings",
            "inspection_tools.findings.picture",
            "inspection_tools.inspection",
            "inspection_tools.inspection.legs",
            "inspection_tools.mission",
            "inspection_tools.photograph_poses",
            "inspection_tools.photographs",
            "inspection_tools.planning",
            "inspection_tools.planning.kernels",
            "inspection_tools.pose",
            "inspection_tools.report",
            "inspection_tools.report.gauging",
            "inspection_tools.ship",
            "inspection_tools.survey",
            "inspection_tools.survey.kernels",
            "inspection_tools.survey.surface",
            "inspection_tools.survey.tour",
            "inspection_tools.survey.views",
            "inspection_tools.yaw",
            "inspection_tools_ros",
            "inspection_tools_ros.energy",
            "inspection_tools_ros.surveying",
        ],
        package_dir={"": "src", "inspection_tools_ros": "ros/inspection_tools_ros"},
        package_data={"inspection_tools.report": ["page.html", "plan.html", "page.css", "viewer.js"]},
    )
)
