"""Chooses the tests that a change can touch, for `./bringup.sh test --changed`."""
