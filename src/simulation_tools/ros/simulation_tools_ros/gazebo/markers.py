"""RViz markers of SDF visuals, so that a world looks in RViz as its files describe it."""

from __future__ import annotations

from typing import Mapping

from genpy import Duration, Time
from geometry_msgs.msg import Point, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Box, Cylinder, Mesh, Model, Plane, Sphere, Visual
from simulation_tools.world.shapes.meshes import mesh_of
from simulation_tools_ros.conversions import pose_message

PLANE_THICKNESS_M = 0.002


def model_markers(
    model: Model,
    frame_id: str,
    model_pose: Pose,
    moves_with_frame: bool,
    own_frames: Mapping[str, str] | None = None,
) -> list[Marker]:
    """Return a marker for each visual of a model.

    model_pose: of the model in frame_id. moves_with_frame: RViz follows the frame between messages.
    own_frames: TF frames of the links that turn against the model, by link.
    """
    markers: list[Marker] = []
    for link in model.links:
        own_frame = (own_frames or {}).get(link.name)
        pose = Pose.identity() if own_frame else model_pose @ link.pose
        for visual in link.visuals:
            marker = _shape(visual)
            marker.header = Header(frame_id=own_frame or frame_id, stamp=Time())
            marker.ns = model.name
            marker.id = len(markers)
            marker.frame_locked = moves_with_frame
            marker.lifetime = Duration()
            marker.pose = pose_message(pose @ visual.pose @ _drawn_pose(visual))
            markers.append(marker)
    return markers


def all_markers(markers: list[Marker], replace: bool) -> MarkerArray:
    """Return an array of markers; replace: it first deletes everything drawn before (which flickers)."""
    return MarkerArray([Marker(action=Marker.DELETEALL), *markers] if replace else markers)


def _shape(visual: Visual) -> Marker:
    marker = Marker(action=Marker.ADD, color=ColorRGBA(*visual.rgba))
    geometry = visual.geometry
    if isinstance(geometry, Box):
        # RViz draws all but one side of a single CUBE black. It draws the boxes of a list correctly.
        marker.type, marker.scale = Marker.CUBE_LIST, Vector3(*geometry.size_m)
        marker.points = [Point(0.0, 0.0, 0.0)]
    elif isinstance(geometry, Cylinder):
        diameter = 2.0 * geometry.radius_m
        marker.type, marker.scale = Marker.CYLINDER, Vector3(diameter, diameter, geometry.length_m)
    elif isinstance(geometry, Sphere):
        diameter = 2.0 * geometry.radius_m
        marker.type, marker.scale = Marker.SPHERE, Vector3(diameter, diameter, diameter)
    elif isinstance(geometry, Plane):
        marker.type, marker.scale = Marker.CUBE, Vector3(*geometry.size_m, PLANE_THICKNESS_M)
    elif isinstance(geometry, Mesh) and not geometry.submesh:
        marker.type, marker.scale = Marker.MESH_RESOURCE, Vector3(*geometry.scale)
        marker.mesh_resource = "file://" + geometry.path
    else:  # a heightmap, or a part of a mesh file
        marker.type, marker.scale = Marker.TRIANGLE_LIST, Vector3(1.0, 1.0, 1.0)
        mesh = mesh_of(geometry)
        marker.points = [Point(*corner) for corner in mesh.vertices[mesh.triangles.ravel()].tolist()]
    return marker


def _drawn_pose(visual: Visual) -> Pose:
    """Pose of the drawn shape in the visual: a plane is drawn as a thin box just below its surface."""
    if not isinstance(visual.geometry, Plane):
        return Pose.identity()
    return visual.geometry.turn_from_z @ Pose((0.0, 0.0, -0.5 * PLANE_THICKNESS_M))
