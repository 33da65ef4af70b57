"""The node `mavros`: its plugins, and what they share."""
