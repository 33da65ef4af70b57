"""Shared by this package's nodes: conversions of messages, frames, pose source, terminal."""
