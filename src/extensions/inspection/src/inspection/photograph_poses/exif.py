"""What a camera writes into its pictures: EXIF 2.32, and the XMP of DJI's UAVs.

DJI tells the gimbal's angles as its aircraft's: yaw clockwise from north, pitch up from level, roll to the
right, all in degrees. What a picture tells more than once is chosen by `best_of`.
"""

from __future__ import annotations

import math
import mmap
import re
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path
from typing import Any, Iterator, Mapping

from PIL import Image

from flight_basics.errors import ParameterError
from inspection.camera.lens import MIDDLE, Lens
from inspection.camera.survey_camera import SurveyCamera
from inspection.photographs.calibration import CALIBRATED, camera_with, focal_apart, focal_in_words
from inspection.photographs.listing import opened
from inspection.photographs.record import PhotographError, stamp_of
from inspection.photographs.sourced import Doubt, Sourced, best_of

EXIF_BLOCK, GPS_BLOCK = 0x8769, 0x8825
EXPOSURE_TIME, ISO_SPEED, FOCAL_LENGTH, FOCAL_35MM = 0x829A, 0x8827, 0x920A, 0xA405
FOCAL_PLANE_X, FOCAL_PLANE_UNIT, BODY_SERIAL = 0xA20E, 0xA210, 0xA431
DATE, SUBSECONDS, OFFSET = 0x9003, 0x9291, 0x9011
PIXELS_X, PIXELS_Y, POSITIONING_ERROR = 0xA002, 0xA003, 0x001F
"""Tags of EXIF. PIXELS: of the picture as the camera stored it; a reduced copy mostly keeps them."""
BELOW = (1, b"\x01", 3, b"\x03")
"""GPSAltitudeRef of heights below: the sea, or since EXIF 3.0 the ellipsoid."""
ALIKE = 0.01
"""Shares of two sides of a reduced copy differ by less."""
UNITS_MM = {2: 25.4, 3: 10.0, 4: 1.0, 5: 0.001}
"""Of the focal plane's resolution: inch, cm, mm, um."""
FULL_FRAME_MM, DIAGONAL_35MM = 36.0, math.hypot(36.0, 24.0)
"""Width; and diagonal, to which the 35 mm equivalent focal length belongs (CIPA DCG-001)."""
ZONE = re.compile(r"([+-])(\d\d):?([0-5]\d)")
"""An offset from UTC; some programs leave the colon out."""
ZONE_MAX = timedelta(hours=24)
METRES_A_DEG = 111_195.0
"""Of a great circle, on a sphere of 6371 km."""
DEGREES_MAX = {2: 90.0, 4: 180.0}
"""Of latitude and longitude, by EXIF's tag."""
GNSS_M, GNSS_UP_M = 3.3, 6.6
"""Standard deviation of a satellite fix without corrections, along one axis.

The GPS SPS Performance Standard of 2020 promises 8 m to the side and 13 m in height for 95 %.
"""
RTK_M, ABOVE_START_M = 0.05, 1.0
"""Of a fix with corrections; of a barometer's height above the take-off.

DJI promises 3 cm and 1 ppm of the way to the base (data sheet of D-RTK 3), which is 20 km away in a network.
The barometers of its UAVs are right within 0.5 m, and 2 m in gusts (SiteSee's manual); this is between.
"""
OF_DESIGN = 0.02
"""Of a focal length as the maker has designed it, as a share; also of one where the optical centre alone
tells the size of the whole picture. The centres of public data sets are 0.01 of the width beside the middle,
which makes the picture larger by twice as much.
"""
XMP = re.compile(rb"<x:xmpmeta.*?</x:xmpmeta>", re.DOTALL)
XMP_ATTRIBUTE = re.compile(r"[\w-]+:(\w+)\s*=\s*[\"']([^\"']*)[\"']")
XMP_ELEMENT = re.compile(r"<[\w-]+:(\w+)>([^<]*)</")


@dataclass(frozen=True)
class Exif:
    """What a picture tells of itself; None: nothing.

    size: of the picture, px. taken: time of the shot, s since 1970. has_zone: the picture tells its offset
    from UTC; else it counts as UTC. place: latitude and longitude of the camera, deg, WGS 84, with a
    deviation in m. height, above_start: m; the second one above the take-off. yaw_deg, pitch_deg, roll_deg:
    of the gimbal, see above. camera: with its lens, as far as the picture tells it, and the deviation of its
    focal length, as a share. serial: of the camera. doubts: what contradicts itself, or makes no sense.
    """

    size: tuple[int, int]
    taken: Sourced[float] | None = None
    has_zone: bool = False
    place: Sourced[tuple[float, float]] | None = None
    height: Sourced[float] | None = None
    above_start: Sourced[float] | None = None
    yaw_deg: float | None = None
    pitch_deg: float | None = None
    roll_deg: float = 0.0
    exposure_s: float | None = None
    iso: float | None = None
    camera: Sourced[SurveyCamera] | None = None
    serial: str = ""
    doubts: tuple[Doubt, ...] = ()


def read_exif(path: Path) -> Exif:
    """Return what a picture tells of itself; raises PhotographError if it cannot be read."""
    try:
        with opened(path) as image:
            size, exif = image.size, image.getexif()
            block, gps = dict(exif.get_ifd(EXIF_BLOCK)), dict(exif.get_ifd(GPS_BLOCK))
        xmp = _xmp_of(path)
    except (OSError, ValueError, SyntaxError, EOFError, Image.DecompressionBombError) as error:
        raise PhotographError(f"{path}: cannot be read ({error}).") from None
    by_exif, has_zone = _stamp_of(block)
    times = [each for each in (by_exif, _named_stamp(path)) if each is not None]
    taken, of_time = best_of(times, _off, "the time", lambda each: f"{each.value:.3f} s")
    place, of_place = best_of(
        list(_places(gps, xmp)), _off_m, "the place", lambda each: "{:.6f}, {:.6f} deg".format(*each.value)
    )
    height, of_height = best_of(list(_heights(gps, xmp)), _off, "the height", lambda e: f"{e.value:.2f} m")
    above_m = _number(xmp.get("RelativeAltitude"))
    camera, of_camera = _camera_of(size, block, xmp)
    return Exif(
        size=size,
        taken=taken,
        has_zone=has_zone,
        place=place,
        height=height,
        above_start=None if above_m is None else Sourced(above_m, "XMP", _deviation_m(xmp, 2, ABOVE_START_M)),
        yaw_deg=_number(xmp.get("GimbalYawDegree")),
        pitch_deg=_number(xmp.get("GimbalPitchDegree")),
        roll_deg=_number(xmp.get("GimbalRollDegree")) or 0.0,
        exposure_s=_positive(block.get(EXPOSURE_TIME)),
        iso=_positive(_first(block.get(ISO_SPEED))),
        camera=camera,
        serial=_text(block.get(BODY_SERIAL)),
        doubts=(*of_time, *of_place, *of_height, *of_camera),
    )


def _off(one: Sourced[float], other: Sourced[float]) -> float:
    return abs(one.value - other.value)


def _off_m(one: Sourced[tuple[float, float]], other: Sourced[tuple[float, float]]) -> float:
    """Return how far two places, in degrees, are apart, m."""
    (north, east), (other_north, other_east) = one.value, other.value
    east_deg = (east - other_east + 180.0) % 360.0 - 180.0
    return METRES_A_DEG * math.hypot(north - other_north, east_deg * math.cos(math.radians(north)))


def _deviation_m(xmp: Mapping[str, str], axis: int, otherwise_m: float) -> float:
    """Return the deviation of a satellite fix along an axis, as RTK tells it; else another one."""
    if xmp.get("RtkFlag", "").strip() != "50":  # fixed
        return otherwise_m
    return _positive(xmp.get(("RtkStdLon", "RtkStdLat", "RtkStdHgt")[axis])) or min(RTK_M, otherwise_m)


def _places(gps: Mapping[int, Any], xmp: Mapping[str, str]) -> Iterator[Sourced[tuple[float, float]]]:
    """Yield latitude and longitude, deg; 0, 0 is no fix."""
    told_m = _positive(gps.get(POSITIONING_ERROR)) or GNSS_M
    off_m = max(_deviation_m(xmp, axis, told_m) for axis in (0, 1))
    by_xmp = xmp.get("GpsLatitude"), xmp.get("GpsLongitude") or xmp.get("GpsLongtitude")  # DJI's own spelling
    by_exif = _degrees(gps, 1, 2, "S"), _degrees(gps, 3, 4, "W")
    for source, (latitude, longitude) in (("EXIF's GPS", by_exif), ("XMP", tuple(map(_number, by_xmp)))):
        if latitude is not None and longitude is not None and (latitude, longitude) != (0.0, 0.0):
            yield Sourced((latitude, longitude), source, off_m)


def _heights(gps: Mapping[int, Any], xmp: Mapping[str, str]) -> Iterator[Sourced[float]]:
    """Yield heights by satellites, m. Exactly 0 is none: many cameras write it when they know none."""
    by_exif = _number(gps.get(6))
    if by_exif is not None and gps.get(5) in BELOW:
        by_exif = -by_exif
    for source, height_m in (("XMP", _number(xmp.get("AbsoluteAltitude"))), ("EXIF's GPS", by_exif)):
        if height_m:
            yield Sourced(height_m, source, _deviation_m(xmp, 2, GNSS_UP_M))


def _xmp_of(path: Path) -> dict[str, str]:
    """Return what the first XMP tells, by name without prefix. It may stand behind the pixels."""
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content:
        found = XMP.search(content)
        text = "" if found is None else found.group().decode("utf-8", "replace")
    return dict(XMP_ELEMENT.findall(text)) | dict(XMP_ATTRIBUTE.findall(text))


def _first(value: Any) -> Any:
    return value[0] if isinstance(value, tuple) and value else value


def _number(value: Any) -> float | None:
    """Return a finite number; None: it is none, as of the fraction 0 / 0."""
    try:
        number = float(value)
    except (TypeError, ValueError, ZeroDivisionError):
        return None
    return number if math.isfinite(number) else None


def _positive(value: Any) -> float | None:
    number = _number(value)
    return number if number is not None and number > 0.0 else None


def _text(value: Any) -> str:
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    return value.strip("\0 ") if isinstance(value, str) else ""


def _degrees(gps: Mapping[int, Any], sign: int, angle: int, negative: str) -> float | None:
    parts = gps.get(angle)
    if not isinstance(parts, tuple) or len(parts) != 3:
        return None
    degrees, minutes, seconds = map(_number, parts)
    if degrees is None:
        return None
    value = degrees + (minutes or 0.0) / 60.0 + (seconds or 0.0) / 3600.0
    if abs(value) > DEGREES_MAX[angle]:
        return None
    return -value if _text(gps.get(sign)).upper() == negative else value


def _stamp_of(block: Mapping[int, Any]) -> tuple[Sourced[float] | None, bool]:
    """Return the time of the shot, s since 1970, and whether its offset from UTC is told."""
    try:
        taken = datetime.strptime(_text(block.get(DATE)), "%Y:%m:%d %H:%M:%S")
    except ValueError:
        return None, False
    zone = ZONE.fullmatch(_text(block.get(OFFSET)))
    behind = timedelta()
    if zone:
        sign, hours, minutes = zone.groups()
        behind = timedelta(hours=int(hours), minutes=int(minutes)) * (-1 if sign == "-" else 1)
    is_known = zone is not None and abs(behind) < ZONE_MAX
    offset = timezone(behind) if is_known else UTC
    stamp_s = taken.replace(tzinfo=offset).astimezone(UTC).timestamp()
    digits = _text(block.get(SUBSECONDS))
    if digits.isdigit():
        return Sourced(stamp_s + float(f"0.{digits}"), "EXIF's time", _evenly(10.0 ** -len(digits))), is_known
    return Sourced(stamp_s + 0.5, "EXIF's time in whole seconds", _evenly(1.0)), is_known  # any time in it


def _named_stamp(path: Path) -> Sourced[float] | None:
    """Return the time that a file's name is, s; one without a point is only a number."""
    stamp_s = stamp_of(path) if "." in path.stem else None
    if stamp_s is None:
        return None
    return Sourced(stamp_s, "the file's name", _evenly(10.0 ** -len(path.stem.rpartition(".")[2])))


def _evenly(width: float) -> float:
    """Return the standard deviation of what lies anywhere in an interval of this width."""
    return width / math.sqrt(12.0)


def _camera_of(
    size: tuple[int, int], block: Mapping[int, Any], xmp: Mapping[str, str]
) -> tuple[Sourced[SurveyCamera] | None, tuple[Doubt, ...]]:
    """Return the camera that a picture tells of."""
    stored = _stored_size(size, block)
    if stored is None:
        why = (
            f"Its EXIF tells another shape than its {size[0]} x {size[1]} px, so that its lens is not known."
        )
        return None, (Doubt("shape", why),)
    cameras, doubts = [], list[Doubt]()
    for lens, whole, source, deviation in _lenses(size, stored, block, xmp):
        try:
            scaled = lens if whole == size else lens.scaled(size[0] / whole[0])
            cameras.append(Sourced(camera_with(*size, scaled), source, deviation))
        except ParameterError as error:
            doubts.append(Doubt(f"lens by {source}", f"The lens by {source} is not used: {error}."))
    best, others = best_of(cameras, focal_apart, "the focal length", focal_in_words)
    return best, (*doubts, *others)


def _stored_size(size: tuple[int, int], block: Mapping[int, Any]) -> tuple[int, int] | None:
    """Return the size, px, of the picture as the camera stored it; None: this one is cut out of it."""
    told = tuple(_positive(_first(block.get(each))) for each in (PIXELS_X, PIXELS_Y))
    if told[0] is None or told[1] is None:
        return size
    shares = size[0] / told[0], size[1] / told[1]
    if abs(shares[0] / shares[1] - 1.0) > ALIKE:
        return None
    return size if abs(shares[0] - 1.0) < ALIKE else (int(told[0]), int(told[1]))


def _lenses(
    size: tuple[int, int], stored: tuple[int, int], block: Mapping[int, Any], xmp: Mapping[str, str]
) -> Iterator[tuple[Lens, tuple[float, float], str, float]]:
    """Yield lenses, the sizes of the pictures that they draw, their sources and deviations.

    The equivalent focal length comes first: it does not change when a picture is made smaller.
    """

    def plain(focal_px: float, of: tuple[float, float]) -> Lens:
        return Lens((focal_px, focal_px), (0.5 * (of[0] - 1), 0.5 * (of[1] - 1)))

    equivalent_mm = _positive(block.get(FOCAL_35MM))
    if equivalent_mm:
        focal_px = equivalent_mm * math.hypot(*size) / DIAGONAL_35MM
        yield plain(focal_px, size), size, "EXIF's 35 mm equivalent", _off_35mm(equivalent_mm, size)
    x, y = (_positive(xmp.get(f"CalibratedOpticalCenter{axis}")) for axis in "XY")
    whole, deviation = _whole_size(size, stored, x, y)
    lens = _dewarp_lens(xmp, (0.5 * stored[0] if x is None else x, 0.5 * stored[1] if y is None else y))
    if lens is not None:
        yield lens, whole, "XMP's DewarpData", deviation
    focal = _positive(xmp.get("CalibratedFocalLength"))
    if focal is not None and x is not None and y is not None:
        yield Lens((focal, focal), (x - 0.5, y - 0.5)), whole, "XMP", OF_DESIGN  # so DJI's manuals call it
    focal_mm, per_unit = _positive(block.get(FOCAL_LENGTH)), _positive(block.get(FOCAL_PLANE_X))
    unit_mm = UNITS_MM.get(_first(block.get(FOCAL_PLANE_UNIT)) or 2)
    if focal_mm and per_unit and unit_mm:
        yield plain(focal_mm * per_unit / unit_mm, stored), stored, "EXIF's sensor", OF_DESIGN


def _off_35mm(equivalent_mm: float, size: tuple[int, int]) -> float:
    """Return the deviation of a focal length by the 35 mm equivalent, as a share.

    It is told in whole mm. Some makers mean the width by it, and not the diagonal.
    """
    by_width = FULL_FRAME_MM * math.hypot(*size) / (max(size) * DIAGONAL_35MM)
    return math.hypot(math.log(by_width), _evenly(1.0) / equivalent_mm)


def _whole_size(
    size: tuple[int, int], stored: tuple[int, int], x: float | None, y: float | None
) -> tuple[tuple[float, float], float]:
    """Return the size, px, of the picture that XMP's calibration is of, and the focal length's deviation.

    XMP's numbers stay as they are when a picture is made smaller, and its optical centre is near the middle.
    """
    if x is None or y is None:
        return stored, CALIBRATED
    for known in (stored, size):
        if max(abs(x / known[0] - 0.5), abs(y / known[1] - 0.5)) <= MIDDLE:
            return known, CALIBRATED
    shape = (x / size[0]) / (y / size[1])
    return ((2.0 * x, 2.0 * y), OF_DESIGN) if abs(shape - 1.0) < MIDDLE else (stored, CALIBRATED)


def _dewarp_lens(xmp: Mapping[str, str], middle: tuple[float, float]) -> Lens | None:
    """Return the lens of DJI's DewarpData: date; fx, fy, cx and cy from the middle, k1, k2, p1, p2, k3.

    middle: of the whole picture, from its corner.
    """
    numbers = [_number(each) for each in xmp.get("DewarpData", "").split(";")[-1].split(",")]
    values = [each for each in numbers if each is not None]
    if len(values) != 9 or len(numbers) != 9:
        return None
    fx, fy, cx, cy, *distortion = values
    is_dewarped = xmp.get("DewarpFlag", "0").strip() == "1"
    bent = (0.0,) * 8 if is_dewarped else (*distortion, 0.0, 0.0, 0.0)
    return Lens((fx, fy), (middle[0] + cx - 0.5, middle[1] + cy - 0.5), bent)
