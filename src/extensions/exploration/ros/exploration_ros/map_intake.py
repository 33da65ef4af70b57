"""Gives the map to a planner in the thread of an errand's worker, which no one else's calls reach."""

from __future__ import annotations

from functools import partial
from typing import Any, Callable

from flight_basics_ros.errand_server import ErrandServer

from exploration_ros import planner_messages
from exploration_ros.map_feed import QUEUE, MapFeed
from flight_basics.errand.messages import MapCame
from flight_basics.errors import FlightBasicsError


def listen_to_map(server: ErrandServer, feed: MapFeed, after: Callable[[], None] = lambda: None) -> None:
    """Subscribe to updates (gridslam/VoxelTiles). after: called when a part of the map is taken."""

    def take(message: Any) -> None:
        try:
            feed.take(message)
            after()
        except FlightBasicsError as error:
            server.say(f"{error} This part of the map is left out.")
            return
        server.put(MapCame(message.header.stamp.to_sec()))

    def on_map(message: Any) -> None:
        server.worker.do(partial(take, message))

    server.subscribe("updates", planner_messages.tiles_class(), on_map, QUEUE, buff_size=1 << 24)
