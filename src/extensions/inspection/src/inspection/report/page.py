"""The page: one HTML file that needs no other, apart from the originals of the photographs."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from flight_basics.errors import ReportError
from inspection.files.whole import write_whole

HERE = Path(__file__).resolve().parent
THREE = Path("/usr/share/javascript/three")
"""Where Debian's libjs-three is. The page works without it, with still pictures in place of the 3D view."""
LIBRARY = ("three.min.js", "examples/js/controls/OrbitControls.js")


def libraries() -> list[str]:
    """Return the texts of three.js and its orbit controls; none if they are not installed."""
    try:
        return [(THREE / name).read_text(encoding="utf-8") for name in LIBRARY]
    except OSError:
        return []


def render(content: dict[str, Any], view: dict[str, Any]) -> str:
    """Return the page's HTML. content: what `page.html` names. view: of `view_data`."""
    scripts = [*libraries(), (HERE / "viewer.js").read_text(encoding="utf-8")]
    return filled(
        "page.html",
        **content,
        view_json=json.dumps(view, separators=(",", ":")).replace("<", "\\u003c"),
        scripts=[text.replace("</script", "<\\/script") for text in scripts],
    )


def filled(template: str, **content: Any) -> str:
    """Return the HTML of a template in this folder. content: what it names, besides the style."""
    environment = Environment(
        loader=FileSystemLoader(str(HERE)), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    environment.filters["number"] = _number
    environment.filters["percent"] = _percent
    css = (HERE / "page.css").read_text(encoding="utf-8")
    return environment.get_template(template).render(**content, css=css)


def write_page(path: Path, text: str) -> None:
    """Write the page, whole or not at all.

    Raises:
        ReportError: it cannot be written.
    """
    try:
        write_whole({path: text.encode()})
    except OSError as error:
        raise ReportError(f"{path} cannot be written: {error.strerror}.") from None


def _number(value: float | None, digits: int) -> str:
    if value is None or not math.isfinite(value):
        return ""
    return f"{value:,.{digits}f}".replace("-", "\N{MINUS SIGN}")


def _percent(value: float | None, digits: int) -> str:
    return "" if value is None or not math.isfinite(value) else f"{100 * value:.{digits}f} %"
