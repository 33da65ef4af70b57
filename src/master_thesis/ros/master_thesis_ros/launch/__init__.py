"""Before, during and after roslaunch: what it is asked to fly, what comes when, and who ends it."""
