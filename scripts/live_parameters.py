#!/usr/bin/env python3
"""Write the .cfg files: sentence, default and limits of each live parameter are those of a dataclass.

usage: live_parameters.py

A .cfg file names the dataclass in its docstring: "... are those of NAME." Groups and order are its own, and
so are the lines of what the dataclass has not.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

from handbook.parameters.meanings import Parameter, of_class
from handbook.parameters.sources import Module, Sources

ROOT = Path(__file__).resolve().parents[1]
NAMED = re.compile(r"are those of (\w+)")
ADD = re.compile(r'^(\w+)\.add\("(\w+)", (\w+), 0, "(?:[^"\\]|\\.)*", ([^"]*|".*")\)$', re.M)
NAMES = {
    "use_pos_setpoint": "use_position_setpoint",
    "hover_height": "hover_height_m",
    "command_timeout": "command_timeout_s",
    "sor_pgs_iters": "iterations",
    "sor_pgs_rms_error_tol": "residual_m_s",
    "contact_surface_layer": "surface_layer_m",
}
"""Fields by their names in the .cfg files, where these are not the same: Gazebo's, and the thesis's."""


def written(text: str, parameters: dict[str, Parameter]) -> str:
    """Return the text of a .cfg file with what the parameters of its dataclass say."""

    def line(found: re.Match[str]) -> str:
        group, name, kind, numbers = found.groups()
        each = parameters.get(NAMES.get(name, name))
        if each is None:
            return found[0]
        values = [each.default, *(each.live or (each.least, each.most))]
        if isinstance(each.default, bool):
            numbers = repr(each.default)
        elif isinstance(each.default, tuple):
            numbers = f'"{" ".join(map(repr, each.default))}"'
        elif all(isinstance(value, (int, float)) for value in values):
            numbers = ", ".join(map(repr, values))
        sentence = json.dumps(each.sentence, ensure_ascii=False)
        return f'{group}.add("{name}", {kind}, 0, {sentence}, {numbers})'

    return ADD.sub(line, text)


def config_files(root: Path = ROOT) -> dict[Path, dict[str, Parameter]]:
    """Return the .cfg files whose dataclass has limits in its fields, each with its parameters."""
    sources, found = Sources(root), {}
    for path in sorted(root.glob("src/**/cfg/*.cfg")):
        named = NAMED.search(path.read_text(encoding="utf-8"))
        for home in (path.parents[1] / "src").rglob("*.py") if named else ():
            text = home.read_text(encoding="utf-8")
            if f"\nclass {named[1]}:" in text and "limited(" in text:
                module = Module(home, sources)
                found[path] = {each.name: each for each in of_class(module, module.classes[named[1]])}
    return found


def main() -> None:
    """Write all of them."""
    for path, parameters in config_files().items():
        path.write_text(written(path.read_text(encoding="utf-8"), parameters), encoding="utf-8")
        print(f"written: {path.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
