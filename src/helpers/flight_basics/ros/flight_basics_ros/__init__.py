"""Shared by nodes that fly or watch a UAV: source of poses, frames, setpoints, the goal that a node keeps."""
