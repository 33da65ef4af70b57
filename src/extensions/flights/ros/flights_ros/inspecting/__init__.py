"""The node that controls an inspection."""
