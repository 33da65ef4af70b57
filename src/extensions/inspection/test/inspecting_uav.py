"""A UAV without dynamics that photographs a room, with a camera that can fail."""

import math

import numpy as np
from drawn_voxels import tiles_of
from voxel_room import PLANNER, SIDE_M

from exploration.planning import FREE, OCCUPIED, PathPlanner
from inspection.flight import Inspection, InspectionParameters, PhotographQuality, PhotographQueue
from inspection.flight.motion import Motion
from inspection.survey.views.candidates import View

HOME_M = np.array((1.0, 1.0, 1.0))
VIEWS = (
    View((3.0, 1.0, 1.0), 0.0, 0.0),
    View((5.0, 1.0, 2.0), math.pi / 2, 0.5),
    View((5.0, 3.0, 1.0), math.pi, -0.5),
)
GOOD, BLURRED = PhotographQuality(0.2, 100.0, 800.0), PhotographQuality(9.0, 100.0, 800.0)
SPEED, STEP_S, TURN_RAD_S = 1.0, 0.1, 1.0
QUICK = InspectionParameters(patience=2.0, tries=2, exposure=0.002)


def room(walls=()):
    """The tiles of a room of 6.4 x 4 x 3 m; walls: boxes (low, high) in m that are filled."""
    kinds = np.full((16, 20, 32), FREE, np.uint8)
    kinds[0] = kinds[-1] = kinds[:, 0] = kinds[:, -1] = kinds[:, :, 0] = kinds[:, :, -1] = OCCUPIED
    for low, high in walls:
        a, b = (np.round(np.array(corner[::-1]) / SIDE_M).astype(int) for corner in (low, high))
        kinds[a[0] : b[0], a[1] : b[1], a[2] : b[2]] = OCCUPIED
    return tiles_of(kinds)


def planner(walls=()):
    """A planner that knows the room."""
    known = PathPlanner(PLANNER)
    known.update_map(SIDE_M, 4, *room(walls))
    return known


class Uav:
    """It flies to the setpoint at a constant speed and turns at a constant rate. shots: by the number."""

    def __init__(self, inspection, place_m=HOME_M, yaw_rad=0.0, drain=0.0):
        self.inspection, self.place_m, self.yaw_rad = inspection, np.array(place_m), yaw_rad
        self.stamp_s, self.charge, self.drain = 0.0, 1.0, drain
        self.asked, self.faults = [], {}

    def step(self):
        lead = self.inspection
        self.stamp_s += STEP_S
        self.charge -= self.drain * STEP_S
        way = np.zeros(3) if lead.setpoint_m is None else lead.setpoint_m - self.place_m
        far_m = float(np.linalg.norm(way))
        self.place_m = self.place_m + way * min(1.0, SPEED * STEP_S / max(far_m, 1e-9))
        turn = 0.0 if lead.front_rad is None else math.remainder(lead.front_rad - self.yaw_rad, math.tau)
        rate = float(np.clip(turn / STEP_S, -TURN_RAD_S, TURN_RAD_S))
        self.yaw_rad += rate * STEP_S
        motion = Motion(self.stamp_s, self.place_m, self.yaw_rad, min(SPEED, far_m / STEP_S), rate)
        if lead.follow(motion):
            lead.look(self.stamp_s, self.place_m)
        task = lead.shutter(motion)
        if task is not None:
            self.asked.append(task)
            self.shot_m = self.place_m
            lead.judge_quality(task, self.faults.get(task.number, GOOD))

    def fly(self, longest_s=120.0):
        while not (self.inspection.is_home or self.inspection.must_land) and self.stamp_s < longest_s:
            self.step()
        return self


def inspection(views=VIEWS, walls=(), parameters=QUICK, energy=None, done=()):
    lead = Inspection(planner(walls), PhotographQueue(views, done, parameters.tries), parameters, energy)
    lead.begin(0.0, HOME_M)
    return lead
