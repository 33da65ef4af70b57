"""The code between the library and ROS: messages, parameters, topics and services of the nodes."""
