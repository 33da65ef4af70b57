"""The door by which nodes take the messages of lidars."""
