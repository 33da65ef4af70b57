"""catkin's description of the Python packages; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "master_thesis",
            "master_thesis.chapter_8",
            "master_thesis.experiment_1",
            "master_thesis.experiment_2",
            "master_thesis.experiments_3_4",
            "master_thesis.experiments_3_4.report",
            "master_thesis.experiments_3_4.volume",
            "master_thesis.experiments_3_4.without_gnss",
            "master_thesis.exploring",
            "master_thesis.measurements",
            "master_thesis.report",
            "master_thesis_ros",
            "master_thesis_ros.experiment_2",
            "master_thesis_ros.experiments_3_4",
            "master_thesis_ros.launch",
        ],
        package_dir={"": "src", "master_thesis_ros": "ros/master_thesis_ros"},
        package_data={"master_thesis.report": ["page.html", "page.css", "claims.yaml"]},
    )
)
