"""catkin's description of the Python packages; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "flights",
            "flights.baselines",
            "flights.campaign",
            "flights.exploring",
            "flights.flight",
            "flights.flight.judging",
            "flights.flight.lidar",
            "flights.goal_flight",
            "flights.graph",
            "flights.inspecting",
            "flights.launch_arguments",
            "flights.mapping",
            "flights.photographing",
            "flights.results",
            "flights.trials",
            "flights.worlds",
            "flights.worlds.drawn",
            "flights_ros",
            "flights_ros.drivers",
            "flights_ros.exploring",
            "flights_ros.goal_flight",
            "flights_ros.inspecting",
            "flights_ros.launch",
        ],
        package_dir={"": "src", "flights_ros": "ros/flights_ros"},
    )
)
