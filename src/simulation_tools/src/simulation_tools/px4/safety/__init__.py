"""What ends a flight early: an empty battery, a fence."""
