"""Photographs of a steel hull and what they show; free of ROS. Import its modules by their names.

Nothing is imported here. So `rostopic` and `rosservice` can read this package's messages: their Python has no
numpy.
"""
