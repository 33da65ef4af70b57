"""One module for each of MAVROS's plugins, with the plugin's name."""
