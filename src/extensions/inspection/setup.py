"""catkin's description of the Python packages; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

# Two source folders, because the devel space puts a package's source folder first on sys.path. With
# inspection_ros in the library's folder, Python would find the library there, without the generated
# messages.
setup(
    **generate_distutils_setup(
        packages=[
            "inspection",
            "inspection.camera",
            "inspection.files",
            "inspection.findings",
            "inspection.findings.picture",
            "inspection.flight",
            "inspection.flight.legs",
            "inspection.photograph_poses",
            "inspection.photographs",
            "inspection.report",
            "inspection.report.gauging",
            "inspection.ship",
            "inspection.survey",
            "inspection.survey.kernels",
            "inspection.survey.surface",
            "inspection.survey.tour",
            "inspection.survey.views",
            "inspection_ros",
        ],
        package_dir={"": "src", "inspection_ros": "ros/inspection_ros"},
        package_data={
            "inspection.findings.picture": ["rust_cells.npz"],
            "inspection.report": ["page.html", "plan.html", "page.css", "viewer.js"],
        },
    )
)
