"""Photographs as cameras store them: EXIF, and the XMP of DJI's UAVs."""

from fractions import Fraction

import numpy as np
from PIL import Image
from PIL.TiffImagePlugin import IFDRational

XMP = (
    '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">'
    '<rdf:Description xmlns:drone-dji="http://www.dji.com/drone-dji/1.0/" {attributes}>{elements}'
    "</rdf:Description></rdf:RDF></x:xmpmeta>"
)


def xmp(as_elements=False, **values):
    """DJI writes its values as attributes or, in some models, as elements."""
    attributes = " ".join(f'drone-dji:{k}="{v}"' for k, v in values.items())
    elements = "".join(f"<drone-dji:{k}>{v}</drone-dji:{k}>" for k, v in values.items())
    return XMP.format(
        attributes="" if as_elements else attributes, elements=elements if as_elements else ""
    ).encode()


def sexagesimal(degrees):
    whole = Fraction(abs(degrees)).limit_denominator(10**9)
    minutes = (whole - int(whole)) * 60
    return tuple(
        IFDRational(each.numerator, each.denominator)
        for each in (
            Fraction(int(whole)),
            Fraction(int(minutes)),
            ((minutes - int(minutes)) * 60).limit_denominator(10**6),
        )
    )


def store(path, *, size=(64, 48), gps=None, told=b"", block=(), colour=120):
    """Store a picture. gps: latitude, longitude in deg, height in m. block: values of EXIF's own part."""
    exif = Image.Exif()
    exif[0x0112] = 1
    if gps is not None:
        latitude, longitude, height_m = gps
        exif.get_ifd(0x8825).update(
            {
                1: "S" if latitude < 0 else "N", 2: sexagesimal(latitude),
                3: "W" if longitude < 0 else "E", 4: sexagesimal(longitude),
                5: b"\x01" if height_m < 0 else b"\x00", 6: IFDRational(round(abs(height_m) * 1000), 1000),
            }
        )  # fmt: skip
    exif.get_ifd(0x8769).update({0x829A: IFDRational(1, 500), 0x8827: 200, **dict(block)})
    more = {"xmp": told} if told else {}
    picture = Image.fromarray(np.full((size[1], size[0], 3), colour, np.uint8))
    picture.save(path, "JPEG", exif=exif, **more)
    return path
