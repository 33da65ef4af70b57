"""The node `gazebo`: its parameters, topics and services."""
