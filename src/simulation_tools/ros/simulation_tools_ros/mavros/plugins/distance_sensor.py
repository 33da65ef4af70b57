"""MAVROS's plugin `distance_sensor`."""

from __future__ import annotations

from functools import partial

import rospy
from pymavlink.dialects.v20 import common
from sensor_msgs.msg import Range
from std_msgs.msg import Header

from simulation_tools.mavros.distance_sensors import DEFAULT_SENSORS, DistanceSensor, RangesToFcu
from simulation_tools_ros.mavros.uas import Topic, Uas, stamp_from_ms

_RADIATION = {
    common.MAV_DISTANCE_SENSOR_LASER: Range.INFRARED,
    common.MAV_DISTANCE_SENSOR_RADAR: Range.INFRARED,
    common.MAV_DISTANCE_SENSOR_UNKNOWN: Range.INFRARED,
    common.MAV_DISTANCE_SENSOR_ULTRASOUND: Range.ULTRASOUND,
}


class DistanceSensorPlugin:
    """Publishes or takes distance_sensor/NAME (sensor_msgs/Range) for each sensor of its configuration.

    Parameters: ~distance_sensor/NAME/{id,subscriber,orientation,frame_id,field_of_view,covariance}; by
    default those of MAVROS's px4_config.yaml: hrlv_ez4_pub, lidarlite_pub, sonar_1_sub, laser_1_sub. Its
    send_tf does not exist here.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._sensors: dict[int, tuple[DistanceSensor, Topic]] = {}
        for name, values in rospy.get_param("~distance_sensor", DEFAULT_SENSORS).items():
            if isinstance(values, dict):
                self._add(name, values)
        uas.client.on("DISTANCE_SENSOR", self._on_distance)

    def _add(self, name: str, values: dict) -> None:
        try:
            sensor = DistanceSensor.of(name, values)
        except (TypeError, ValueError) as error:
            rospy.logerr(f"mavros leaves a distance sensor out: {error}.")
            return
        topic = f"distance_sensor/{name}"
        if sensor.to_fcu:
            take = partial(self._on_range, topic, RangesToFcu(sensor))
            self._uas.subscribe(topic, Range, take, queue_size=10)
        else:
            self._sensors[sensor.sensor_id] = (sensor, self._uas.advertise(topic, Range))

    def _on_range(self, topic: str, ranges: RangesToFcu, message: Range) -> None:
        self._uas.send_built(
            f"A range on {topic}",
            lambda: ranges.message(
                message.header.stamp.to_nsec() // 1_000_000,
                message.range,
                (message.min_range, message.max_range),
                message.radiation_type == Range.ULTRASOUND,
                message.field_of_view,
            ),
        )

    def _on_distance(self, message: common.MAVLink_message) -> None:
        if message.id not in self._sensors:
            rospy.logerr_once(f"mavros has no topic for the distance sensor with the id {message.id}.")
            return
        sensor, topic = self._sensors[message.id]
        if sensor.orientation not in (None, message.orientation):
            rospy.logerr_once(
                f"The distance sensor {message.id} looks another way ({message.orientation}) than "
                f"distance_sensor/{sensor.name}/orientation says; its ranges are dropped."
            )
            return
        if message.type in _RADIATION:
            topic.publish(lambda: _range(message, sensor))


def _range(message: common.MAVLink_message, sensor: DistanceSensor) -> Range:
    return Range(
        header=Header(stamp=stamp_from_ms(message.time_boot_ms), frame_id=sensor.frame_id),
        radiation_type=_RADIATION[message.type],
        field_of_view=sensor.field_of_view_rad,
        min_range=0.01 * message.min_distance,
        max_range=0.01 * message.max_distance,
        range=0.01 * message.current_distance,
    )
