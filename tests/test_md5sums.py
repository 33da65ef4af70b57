"""The message subsets are upstream's to the bit: equal md5sums let any upstream client interoperate."""

from __future__ import annotations

import importlib

import pytest

# What `rosmsg md5` and `rossrv md5` say of MAVROS 1.21, gazebo_msgs and geographic_msgs of ROS Noetic.
UPSTREAM = {
    "gazebo_msgs/ContactState": "48c0ffb054b8c444f870cecea1ee50d9",
    "gazebo_msgs/ContactsState": "acbcb1601a8e525bf72509f18e6f668d",
    "gazebo_msgs/DeleteModel": "9ce56b4e9e54616de25d796dc972a262",
    "gazebo_msgs/GetModelState": "4c515e936d3319c9610c559c60bfc3d4",
    "gazebo_msgs/GetWorldProperties": "36bb0f2eccf4d8be971410c22818ba3f",
    "gazebo_msgs/LinkState": "0818ebbf28ce3a08d48ab1eaa7309ebe",
    "gazebo_msgs/LinkStates": "48c080191eb15c41858319b4d8a609c2",
    "gazebo_msgs/ModelState": "9330fd35f2fcd82d457e54bd54e10593",
    "gazebo_msgs/ModelStates": "48c080191eb15c41858319b4d8a609c2",
    "gazebo_msgs/SetModelState": "5b3ab0281d4f5445def017e3a2e4a07b",
    "gazebo_msgs/SpawnModel": "9ed9c82c96abe1a00c3e8cdaeee24413",
    "geographic_msgs/GeoPoint": "c48027a852aeff972be80478ff38e81a",
    "mavros_msgs/AttitudeTarget": "456f3af666b22ccd0222ea053a86b548",
    "mavros_msgs/CommandBool": "e09abbb4e5bae6b558e5010966eb6e9e",
    "mavros_msgs/CommandLong": "eb9034afc87577c0a235d45b8f3437d2",
    "mavros_msgs/CommandTOL": "93ff4eaa9907f58c0e7a909cddce23e2",
    "mavros_msgs/ExtendedState": "ae780b1800fe17b917369d21b90058bd",
    "mavros_msgs/HomePosition": "c1167922de8c97acdb0ec714c1dba774",
    "mavros_msgs/ParamGet": "777d24d2a7ab1765ef009a69f464d2bc",
    "mavros_msgs/ParamPull": "c9628aea2226088718fd240fbd62afc7",
    "mavros_msgs/ParamSet": "c423cafb898fff374cbe8530ecd4d285",
    "mavros_msgs/ParamValue": "e2cb1c7a0f6ef0c62d450cd9362c980d",
    "mavros_msgs/PositionTarget": "dedb0081aaf8cb20209737746bb49117",
    "mavros_msgs/SetMode": "e4f18fa93379f9ff1780d270ce110203",
    "mavros_msgs/State": "65cd0a9fff993b062b91e354554ec7e9",
    "mavros_msgs/StatusText": "6cfd33cd09e4abf5841d7be3c770a969",
}

pytestmark = pytest.mark.ros


@pytest.mark.parametrize(("name", "md5sum"), UPSTREAM.items())
def test_md5sum_is_upstreams(name, md5sum):
    assert interface(name)._md5sum == md5sum


def test_every_interface_of_ours_is_compared(request):
    sources = request.config.rootpath.glob("src/interfaces/*/*/*.[ms][sr][gv]")
    assert {f"{path.parts[-3]}/{path.stem}" for path in sources} == set(UPSTREAM)


def interface(name):
    package, type_name = name.split("/")
    for kind in ("msg", "srv"):
        found = getattr(importlib.import_module(f"{package}.{kind}"), type_name, None)
        if found is not None:
            return found
        if package == "geographic_msgs":  # has no services
            break
    raise LookupError(f"{name} is not built")
