"""What the nodes share: ROS messages of the library's data. Imports message classes, never rospy."""
