"""The node `gazebo`: its parameters, and what it publishes and when."""
