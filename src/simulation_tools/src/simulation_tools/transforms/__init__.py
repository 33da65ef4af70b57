"""The frames that `tf_publisher` sends: of odometry and ground truth, and of a model's links."""
