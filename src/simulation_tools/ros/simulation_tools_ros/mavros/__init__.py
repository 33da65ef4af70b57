"""The node `mavros`, a module for each of MAVROS's plugins, by its name."""
