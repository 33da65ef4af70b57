"""The node `mavros`: its plugins and their shared parts."""
