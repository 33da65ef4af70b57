"""One module for each of MAVROS's plugins, called as MAVROS calls it."""
