"""Compiled inner loops on plain arrays, z first."""
