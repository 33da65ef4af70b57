"""The node `mavros_publisher`: its topics, services and parameters around the state machine."""
