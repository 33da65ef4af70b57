"""What a camera writes into its pictures: EXIF 2.32, and the XMP of DJI's UAVs.

DJI tells the gimbal's angles as its aircraft's: yaw clockwise from north, pitch up from level, roll to the
right, all in degrees.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path
from typing import Any, Mapping

from PIL import Image

from flight_basics.errors import ParameterError
from inspection.camera.lens import Lens
from inspection.camera.survey_camera import SurveyCamera
from inspection.photographs.calibration import camera_with
from inspection.photographs.listing import opened
from inspection.photographs.record import PhotographError

EXIF_BLOCK, GPS_BLOCK = 0x8769, 0x8825
EXPOSURE_TIME, ISO_SPEED, FOCAL_LENGTH, FOCAL_35MM = 0x829A, 0x8827, 0x920A, 0xA405
FOCAL_PLANE_X, FOCAL_PLANE_UNIT, BODY_SERIAL, LENS_SERIAL = 0xA20E, 0xA210, 0xA431, 0xA435
DATE, SUBSECONDS, OFFSET = 0x9003, 0x9291, 0x9011
PIXELS_X, PIXELS_Y = 0xA002, 0xA003
"""Tags of EXIF. PIXELS: of the picture as the camera stored it; a reduced copy mostly keeps them."""
BELOW = (1, b"\x01", 3, b"\x03")
"""GPSAltitudeRef of heights below: the sea, or since EXIF 3.0 the ellipsoid."""
ALIKE = 0.01
"""Shares of two sides of a reduced copy differ by less."""
UNITS_MM = {2: 25.4, 3: 10.0, 4: 1.0, 5: 0.001}
"""Of the focal plane's resolution: inch, cm, mm, um."""
DIAGONAL_35MM = math.hypot(36.0, 24.0)
"""To which the 35 mm equivalent focal length belongs (CIPA DCG-001)."""
ZONE = re.compile(r"([+-])(\d\d):?([0-5]\d)")
"""An offset from UTC; some programs leave the colon out."""
ZONE_MAX = timedelta(hours=24)
DEGREES_MAX = {2: 90.0, 4: 180.0}
"""Of latitude and longitude, by EXIF's tag."""
HEAD_BYTES = 512 * 1024
XMP = re.compile(rb"<x:xmpmeta.*?</x:xmpmeta>", re.DOTALL)
XMP_ATTRIBUTE = re.compile(r"[\w-]+:(\w+)\s*=\s*[\"']([^\"']*)[\"']")
XMP_ELEMENT = re.compile(r"<[\w-]+:(\w+)>([^<]*)</")


@dataclass(frozen=True)
class Exif:
    """What a picture tells of itself; None: nothing.

    latitude_deg, longitude_deg, height_m: of the camera, WGS 84. above_start_m: height above the take-off.
    yaw_deg, pitch_deg, roll_deg: of the gimbal, see above. is_rtk: the place is known to centimetres.
    stamp_s: of the shot, s since 1970. has_zone: the picture tells its offset from UTC; else it counts as
    UTC. serial: of the camera.
    camera: with its lens, as far as the picture tells it. is_calibrated: it tells more than a focal length.
    """

    stamp_s: float | None = None
    has_zone: bool = False
    latitude_deg: float | None = None
    longitude_deg: float | None = None
    height_m: float | None = None
    above_start_m: float | None = None
    yaw_deg: float | None = None
    pitch_deg: float | None = None
    roll_deg: float = 0.0
    is_rtk: bool = False
    exposure_s: float | None = None
    iso: float | None = None
    camera: SurveyCamera | None = None
    is_calibrated: bool = False
    serial: str = ""


def read_exif(path: Path) -> Exif:
    """Return what a picture tells of itself; raises PhotographError if it cannot be read."""
    try:
        with opened(path) as image:
            size, exif = image.size, image.getexif()
            block, gps = dict(exif.get_ifd(EXIF_BLOCK)), dict(exif.get_ifd(GPS_BLOCK))
        xmp = _xmp_of(path)
    except (OSError, ValueError, SyntaxError, EOFError, Image.DecompressionBombError) as error:
        raise PhotographError(f"{path}: cannot be read ({error}).") from None
    stamp_s, has_zone = _stamp_of(block)
    camera, is_calibrated = _camera_of(size, block, xmp)
    latitude, longitude = _degrees(gps, 1, 2, "S"), _degrees(gps, 3, 4, "W")
    if latitude is None or longitude is None:
        latitude = _number(xmp.get("GpsLatitude"))
        longitude = _number(xmp.get("GpsLongitude") or xmp.get("GpsLongtitude"))  # DJI's own spelling
    if latitude == 0.0 == longitude:
        latitude = longitude = None  # no fix
    height = _number(gps.get(6))
    if height is not None and gps.get(5) in BELOW:
        height = -height
    yaw = _number(xmp.get("GimbalYawDegree"))
    return Exif(
        stamp_s=stamp_s,
        has_zone=has_zone,
        latitude_deg=latitude,
        longitude_deg=longitude,
        height_m=_number(xmp.get("AbsoluteAltitude")) if height is None else height,
        above_start_m=_number(xmp.get("RelativeAltitude")),
        yaw_deg=yaw,
        pitch_deg=_number(xmp.get("GimbalPitchDegree")),
        roll_deg=_number(xmp.get("GimbalRollDegree")) or 0.0,
        is_rtk=xmp.get("RtkFlag", "").strip() == "50",  # fixed
        exposure_s=_positive(block.get(EXPOSURE_TIME)),
        iso=_positive(_first(block.get(ISO_SPEED))),
        camera=camera,
        is_calibrated=is_calibrated,
        serial=_text(block.get(BODY_SERIAL)),
    )


def _xmp_of(path: Path) -> dict[str, str]:
    """Return what the XMP tells, by name without prefix."""
    with path.open("rb") as stream:
        found = XMP.search(stream.read(HEAD_BYTES))
    if found is None:
        return {}
    text = found.group().decode("utf-8", "replace")
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


def _stamp_of(block: Mapping[int, Any]) -> tuple[float | None, bool]:
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
    digits = _text(block.get(SUBSECONDS))
    part_s = float(f"0.{digits}") if digits.isdigit() else 0.0
    return taken.replace(tzinfo=offset).astimezone(UTC).timestamp() + part_s, is_known


def _camera_of(
    size: tuple[int, int], block: Mapping[int, Any], xmp: Mapping[str, str]
) -> tuple[SurveyCamera | None, bool]:
    """Return the camera that a picture tells of, and whether it was calibrated."""
    stored = _stored_size(size, block)
    if stored is None:
        return None, False
    try:
        lens, is_calibrated = _lens_of(stored, block, xmp)
        if lens is not None and stored != size:
            lens = _reduced(lens, size[0] / stored[0])
        return (None if lens is None else camera_with(*size, lens)), is_calibrated
    except ParameterError:
        return None, False


def _stored_size(size: tuple[int, int], block: Mapping[int, Any]) -> tuple[int, int] | None:
    """Return the size, px, of the picture as the camera stored it; None: this one is cut out of it."""
    told = tuple(_positive(_first(block.get(each))) for each in (PIXELS_X, PIXELS_Y))
    if told[0] is None or told[1] is None:
        return size
    shares = size[0] / told[0], size[1] / told[1]
    if abs(shares[0] / shares[1] - 1.0) > ALIKE:
        return None
    return size if abs(shares[0] - 1.0) < ALIKE else (int(told[0]), int(told[1]))


def _lens_of(
    size: tuple[int, int], block: Mapping[int, Any], xmp: Mapping[str, str]
) -> tuple[Lens | None, bool]:
    """Return the lens of a picture as it was stored, and whether it was calibrated."""
    middle = 0.5 * (size[0] - 1), 0.5 * (size[1] - 1)
    lens = _dewarp_lens(xmp, middle)
    if lens is not None:
        return lens, True
    focal = _positive(xmp.get("CalibratedFocalLength"))
    x, y = (_positive(xmp.get(f"CalibratedOpticalCenter{axis}")) for axis in "XY")
    if focal is not None and x is not None and y is not None:
        return Lens((focal, focal), (x - 0.5, y - 0.5)), True
    focal = _focal_px(size, block)
    return (None if focal is None else Lens((focal, focal), middle)), False


def _reduced(lens: Lens, share: float) -> Lens:
    """Return the lens of a copy whose sides are a share of the picture's; both begin at the same corner."""
    (fx, fy), (cx, cy) = lens.focal_px, lens.centre_px
    centre = (cx + 0.5) * share - 0.5, (cy + 0.5) * share - 0.5
    return Lens((share * fx, share * fy), centre, lens.distortion)


def _dewarp_lens(xmp: Mapping[str, str], middle: tuple[float, float]) -> Lens | None:
    """Return the lens of DJI's DewarpData: date; fx, fy, cx and cy from the middle, k1, k2, p1, p2, k3."""
    numbers = [_number(each) for each in xmp.get("DewarpData", "").split(";")[-1].split(",")]
    values = [each for each in numbers if each is not None]
    if len(values) != 9 or len(numbers) != 9:
        return None
    fx, fy, cx, cy, *distortion = values
    is_dewarped = xmp.get("DewarpFlag", "0").strip() == "1"
    bent = (0.0,) * 8 if is_dewarped else (*distortion, 0.0, 0.0, 0.0)
    return Lens((fx, fy), (middle[0] + cx, middle[1] + cy), bent)


def _focal_px(size: tuple[int, int], block: Mapping[int, Any]) -> float | None:
    focal_mm, per_unit = _positive(block.get(FOCAL_LENGTH)), _positive(block.get(FOCAL_PLANE_X))
    unit_mm = UNITS_MM.get(_first(block.get(FOCAL_PLANE_UNIT)) or 2)
    if focal_mm and per_unit and unit_mm:
        return focal_mm * per_unit / unit_mm
    equivalent_mm = _positive(block.get(FOCAL_35MM))
    return equivalent_mm * math.hypot(*size) / DIAGONAL_35MM if equivalent_mm else None
