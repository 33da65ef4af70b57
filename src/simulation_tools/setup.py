"""catkin's description of the Python packages; run by catkin, not by hand."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

# Two source folders, because the devel space puts a package's source folder first on sys.path: beside the
# library, simulation_tools_ros would let Python find it there, without its generated simulation_tools.cfg.
setup(
    **generate_distutils_setup(
        packages=[
            "simulation_tools",
            "simulation_tools.ardupilot_sitl",
            "simulation_tools.camera",
            "simulation_tools.camera.effects",
            "simulation_tools.launch_check",
            "simulation_tools.mavros",
            "simulation_tools.publisher",
            "simulation_tools.px4",
            "simulation_tools.px4.control",
            "simulation_tools.px4.estimation",
            "simulation_tools.px4.estimation.kernels",
            "simulation_tools.px4.mavlink",
            "simulation_tools.px4.mavlink.missions",
            "simulation_tools.px4.plan",
            "simulation_tools.px4.safety",
            "simulation_tools.px4_sitl",
            "simulation_tools.running",
            "simulation_tools.sdf",
            "simulation_tools.sdf.elements",
            "simulation_tools.sdf.urdf",
            "simulation_tools.sensors",
            "simulation_tools.simulation",
            "simulation_tools.transforms",
            "simulation_tools.vehicle",
            "simulation_tools.vehicle.energy",
            "simulation_tools.world",
            "simulation_tools.world.shapes",
            "simulation_tools_ros",
            "simulation_tools_ros.gazebo",
            "simulation_tools_ros.mavros",
            "simulation_tools_ros.mavros.plugins",
            "simulation_tools_ros.mavros.plugins.extras",
            "simulation_tools_ros.mavros.plugins.setpoints",
            "simulation_tools_ros.mavros.plugins.vision",
            "simulation_tools_ros.mavros_publisher",
        ],
        package_dir={"": "src", "simulation_tools_ros": "ros/simulation_tools_ros"},
    )
)
