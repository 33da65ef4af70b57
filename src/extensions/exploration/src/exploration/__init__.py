"""Where a UAV flies next, by which way and with which energy; free of ROS. Import modules by their names.

Nothing is imported here. So `rostopic` and `rosservice` can read this package's messages: their Python has no
numpy.
"""
