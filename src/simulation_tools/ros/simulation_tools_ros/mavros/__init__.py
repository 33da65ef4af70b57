"""The node `mavros`: what its plugins share, and the plugins."""
