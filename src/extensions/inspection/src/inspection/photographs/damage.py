"""What is told of a file that no picture can be read of, by what it holds and not by its name."""

from __future__ import annotations

from pathlib import Path

from PIL import Image

HEAD_BYTES = 64
AT_KIND, KINDS = (
    4,
    {b"ftyphei": "HEIC", b"ftyphev": "HEIC", b"ftypmif": "HEIC", b"ftypmsf": "HEIC", b"ftypavi": "AVIF"},
)
"""Where phones write the kind of a picture, and the kinds by what stands there."""
TEXTS = {
    b"version https://git-lfs": "it is a pointer of Git LFS, and no picture. Run git lfs pull.",
    b"<!doctype": "it is a web page, and no picture. Download the picture itself.",
    b"<html": "it is a web page, and no picture. Download the picture itself.",
}
TIFF = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")


def damage_of(path: Path, error: Exception) -> str:
    """Return a sentence on a file that Pillow could not read. error: what it has raised."""
    if path.is_dir():
        return f"{path}: it is a folder, and no picture. Give the folder itself, or rename it."
    if not path.exists():
        return f"{path}: there is no such file."
    if isinstance(error, PermissionError):
        return f"{path}: the file must not be read. Change its permissions."
    if not path.stat().st_size:
        return f"{path}: the file is empty. Shoot it again."
    if isinstance(error, Image.DecompressionBombError):
        most = 2e-6 * (Image.MAX_IMAGE_PIXELS or 0)
        return f"{path}: it has more than {most:.0f} megapixels. Cut it into parts."
    return f"{path}: {_content_in_words(path, error)}"


def _content_in_words(path: Path, error: Exception) -> str:
    with path.open("rb") as stream:
        head = stream.read(HEAD_BYTES)
    for start, sentence in TEXTS.items():
        if head.lstrip(b"\xef\xbb\xbf \r\n\t").lower().startswith(start):
            return sentence
    for start, kind in KINDS.items():
        if head[AT_KIND:].startswith(start):
            return (
                f"its content is {kind}, which is not read here, whatever its name says. Export it as JPEG."
            )
    if head.startswith(TIFF) and isinstance(error, Image.UnidentifiedImageError):
        return "it is a TIFF of a kind that is not read here, such as of 16 bits. Export it as JPEG."
    return f"the picture is cut or damaged ({error}). Shoot it again."
