"""SDF files to `World` and `Model`: includes followed, numbers checked, before anything is built.

Supported: world, include, static and dynamic models (nested ones are flattened to ``outer::inner`` names),
actors, links, fixed and revolute joints, poses in other frames, inertia, shapes and meshes, lidars, IMUs,
cameras, barometers, plugins, the state of a saved world. The rest is named in one warning per file; what only
concerns drawing, sleeping, GUIs or Gazebo's own loop (``cast_shadows``, ``visualize``,
``allow_auto_disable``, ``<gui>``, ``<scene>``, ``<light>``, ``<physics>`` ...) has no meaning here and is
accepted.

A bad part of a world is left out, and the world's warnings say so. A model that is asked for by itself is
refused whole.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Sequence

from simulation_tools.geometry import ORIGIN, Vector3
from simulation_tools.sdf import uri
from simulation_tools.sdf.actors import read_actor
from simulation_tools.sdf.document import Document, Node
from simulation_tools.sdf.elements import Model, World
from simulation_tools.sdf.frames import WorldFrames
from simulation_tools.sdf.models import read_model
from simulation_tools.sdf.plugins import read_plugins
from simulation_tools.sdf.reading import Omissions, Reading, free_name, note_number
from simulation_tools.sdf.safe_xml import SdfError
from simulation_tools.sdf.shapes import read_colour
from simulation_tools.sdf.state import apply_state
from simulation_tools.sdf.urdf.reader import sdf_of

OLDEST, NEWEST = (1, 2), (1, 12)
"""Versions of SDF that are read. What a newer one has and 1.7 has not is named as not supported."""
GAZEBO_11 = (1, 7)
"""The newest version of SDF that Gazebo 11 reads."""
PHYSICS_NUMBERS = ("max_step_size", "real_time_factor", "real_time_update_rate", "max_contacts")
"""Of Gazebo's own loop: read, but without effect."""
SOLVERS = ("ode", "bullet", "simbody", "dart")
"""Settings of Gazebo's engines. PyBullet's are those of dynamic_reconfigure."""
CONFIGS = ("model.config", "manifest.xml")
"""Of a model's folder. Gazebo 11 still takes the old name."""
MAX_INCLUDE_DEPTH = 16
MAX_INCLUDED_FILES = 5000
"""The limit of a whole request. If each file includes ten others, every level has ten times as many files."""

PathLike = str | Path


def load_world(path: PathLike, model_path: Sequence[PathLike] | None = None, static: bool = False) -> World:
    """Read a world file. model_path: folders of models; None: those of ``GAZEBO_MODEL_PATH``.

    static: no model moves, whatever the file says. A model that cannot be used is left out, and the world's
    first warnings name it. Raises SdfError when there is no world: ``PATH:LINE: sentence``, or the sentence
    alone if there is no such file.
    """
    path = Path(path)
    if not path.is_file():
        raise SdfError(f"There is no world file {path}; give the path of an SDF world.")
    return _Reader(model_path, is_lenient=True).world(Document.from_file(path), static)


def load_model(path_or_uri: PathLike, model_path: Sequence[PathLike] | None = None) -> Model:
    """Read a model: ``model://name``, a folder with model.config, an SDF or URDF file. Raises SdfError."""
    reader = _Reader(model_path)
    location = str(path_or_uri)
    if "://" in location:
        try:
            path = uri.resolve(location, reader.model_path, None)
        except uri.UriError as error:
            raise SdfError(f"The model {location} cannot be loaded: {error}.") from None
    else:
        path = Path(location)
    if not path.exists():
        raise SdfError(f"There is no model {location}; give a name that GAZEBO_MODEL_PATH knows, or a path.")
    return _only_model(reader.file(path if path.is_file() else model_file(path)), str(path))


def parse_model(
    xml_text: str | bytes, source_name: str, model_path: Sequence[PathLike] | None = None
) -> Model:
    """Read a model from text, as ``/gazebo/spawn_sdf_model`` gets it. source_name: the path in errors.

    The text may also be URDF.
    """
    text = xml_text.encode() if isinstance(xml_text, str) else xml_text
    reader = _Reader(model_path)
    return _only_model(reader.models_of(Document(text, source_name, None)), source_name)


def model_file(folder: Path) -> Path:
    """Return the SDF file that a model folder's model.config names, the newest one that Gazebo 11 reads.

    Only if there is none, it is the newest one.
    """
    config = next((found for name in CONFIGS if (found := folder / name).is_file()), None)
    if config is None:
        raise SdfError(f"The folder {folder} is not a model: it holds no model.config.")
    document = Document.from_file(config)
    named = document.root("model").children("sdf")
    versions = [(_version(node.attribute("version", "1.6")), node) for node in named]
    candidates = [found for found in versions if OLDEST <= found[0] <= NEWEST]
    if not candidates:
        raise SdfError(f"{config}:1: The file names no SDF of version {_text(OLDEST)} to {_text(NEWEST)}.")
    _, newest = max(candidates, key=lambda candidate: (candidate[0] <= GAZEBO_11, candidate[0]))
    path = folder / newest.text
    if not path.is_file():
        raise newest.error(f'The file "{newest.text}" does not exist')
    return path


def _only_model(models: list[Model], source: str) -> Model:
    if len(models) != 1:
        raise SdfError(f"{source}:1: The file must hold exactly one <model>, not {len(models)}.")
    return models[0]


class _Reader:
    """Follows the files of one request. `trail` detects an include that leads back to itself."""

    def __init__(self, model_path: Sequence[PathLike] | None, is_lenient: bool = False) -> None:
        if model_path is None:
            self.model_path: Sequence[Path] = uri.model_path_from_environment()
        else:
            self.model_path = tuple(Path(folder) for folder in model_path)
        self.omissions = Omissions(is_lenient)
        self._reading = Reading(self.model_path, self._include, self.omissions)
        self.trail: list[Path] = []
        self.files_read = 0

    def world(self, document: Document, static: bool) -> World:
        root = _root(document)
        if root.children_unmarked("model") and not root.children_unmarked("world"):
            raise root.error("The file holds a <model>, but no <world>. Include it in a world file")
        node = root.required("world")
        node.accept("gui", "scene")
        self._lights(node)
        no_number: tuple[float, ...] = ()
        for physics in node.children("physics"):
            physics.accept(*SOLVERS)
            for number in physics.children(*PHYSICS_NUMBERS):
                self.omissions.read(number, lambda each: each.numbers(1), no_number)
        models = _with_unequal_names(node, self._models_in(node, static))
        states = node.children("state")
        models = apply_state(
            states[0] if states else None, models, lambda n: self._models_in(n, static), self.omissions
        )
        wind, gravity = node.child("wind"), self._gravity_node(node)
        world = World(
            name=node.attribute("name", "default"),
            models=tuple(replace(model, warnings=()) for model in models),
            gravity_m_s2=self._vector(gravity, "gravity", (0.0, 0.0, -9.8)),
            wind_m_s=ORIGIN if wind is None else self._vector(wind, "linear_velocity", ORIGIN),
            plugins=read_plugins(node, self.omissions),
            source=document.name,
        )
        included = [warning for model in models for warning in model.warnings]
        said = [*self.omissions.sentences, *document.unsupported(), *included]
        return replace(world, warnings=_without_repeats(said))

    def _vector(self, node: Node, name: str, default: Vector3) -> Vector3:
        """Return a vector of a world. A bad one is left out, and the default counts."""
        try:
            return node.vector(name, default)
        except SdfError as error:
            self.omissions.leave_out(node.children(name)[0], error)
            return default

    @staticmethod
    def _gravity_node(node: Node) -> Node:
        """Return the element that holds ``<gravity>``. Until SDF 1.5 this is ``<physics>``."""
        if node.document.version > (1, 5) or node.children_unmarked("gravity"):
            return node
        return next((each for each in node.children("physics") if each.children_unmarked("gravity")), node)

    def _models_in(self, node: Node, static: bool) -> list[Model]:
        """Read every model, actor and ``<include>`` of a world; leave out those that cannot be used."""
        found: list[tuple[Node, Model]] = []
        for child in node.children("model", "actor", "include"):
            try:
                if child.tag == "include":
                    model = self._include(child, static)
                elif child.tag == "actor":
                    model = read_actor(child, self._reading)
                else:
                    model = read_model(child, self._reading, static)
            except SdfError as error:
                self.omissions.leave_out(child, error)
                continue
            found += [] if model is None else [(child, model)]
        named = self.omissions.unique(node.children("frame")).values()
        usable = [frame for frame in named if self.omissions.read(frame, _has_pose, False)]
        frames = WorldFrames(found, usable)
        placed: list[Model] = []
        for child, model in found:
            try:
                placed.append(frames.placed(model, child))
            except SdfError as error:
                self.omissions.leave_out(child, error)
        return placed

    def file(self, path: Path, static: bool = False, placement_frame: str | None = None) -> list[Model]:
        """Read a file of models; a file of lights holds none.

        static: they are, whatever the file says. placement_frame: see `read_model`.
        """
        real = path.resolve()
        if real in self.trail or len(self.trail) >= MAX_INCLUDE_DEPTH:
            raise SdfError(f"{path}:1: The model includes itself, directly or through another one.")
        self.files_read += 1
        if self.files_read > MAX_INCLUDED_FILES:
            raise SdfError(
                f"{path}:1: More than {MAX_INCLUDED_FILES} files are included in all; "
                "put several models into one file."
            )
        self.trail.append(real)
        try:
            return self.models_of(Document.from_file(path), static, placement_frame)
        finally:
            self.trail.pop()

    def models_of(
        self, document: Document, static: bool = False, placement_frame: str | None = None
    ) -> list[Model]:
        """Read every model of a document. The first model gets the document's warning."""
        root = _root(document)
        lights = self._lights(root)
        found = []
        for child in root.children("model"):
            model = read_model(child, self._reading, static, placement_frame)
            found.append(WorldFrames((), ()).placed(model, child))
        found += [read_actor(child, self._reading) for child in root.children("actor")]
        if not (found or lights):
            raise root.error("The file holds no <model>, <actor> or <light>")
        warnings = document.unsupported()
        if warnings and found:
            found[0] = replace(found[0], warnings=_without_repeats([*warnings, *found[0].warnings]))
        return found

    def _lights(self, node: Node) -> list[Node]:
        """Return the lights of a world or a file. They light nothing here. One that is bad is left out."""
        node.accept("light")
        lights = node.children("light")
        for light in lights:
            self.omissions.read(light, _read_light, None)
        return lights

    def _include(self, node: Node, static: bool) -> Model | None:
        """Follow an ``<include>`` and apply what it overrides; None for a light."""
        location = node.required("uri")
        if node.attribute("merge", "") in ("true", "1"):
            node.note("The merge of an <include> is not supported: the model keeps its name before its parts")
        given = node.children("pose")
        frame_node = node.child("placement_frame") if given else None
        placement_frame = ("" if frame_node is None else frame_node.text) if given else None
        name = node.child("name")
        overrides_static = bool(node.children_unmarked("static"))
        static = node.flag("static", False) or static
        try:
            path = uri.resolve(location.text, self.model_path, node.document.folder)
        except uri.UriError as error:
            raise location.error(f"The include cannot be followed: {error}") from None
        try:
            found = self.file(path if path.is_file() else model_file(path), static, placement_frame)
        except SdfError as error:
            raise SdfError(f"{error} (Included by {node.document.name}:{node.line}.)") from None
        if len(found) > 1:
            raise location.error(f'"{location.text}" must hold exactly one model or light, not {len(found)}')
        if not found:
            return None
        model = found[0]
        if given:
            pose, frame = node.pose()
            model = replace(model, pose=pose @ model.pose, relative_to="" if frame == "world" else frame)
        if name is not None:
            model = replace(model, name=name.text)
        if overrides_static:
            model = replace(model, static=static)
        return model


def _read_light(light: Node) -> None:
    for name in ("name", "type"):
        light.attribute(name)
    light.pose()
    light.vector("direction", ORIGIN)
    for colour in light.children("diffuse", "specular"):
        read_colour(colour)


def _has_pose(frame: Node) -> bool:
    frame.pose()
    return True


def _root(document: Document) -> Node:
    document.convert("robot", sdf_of)
    root = document.root("sdf", "gazebo")  # the root's name before SDF 1.3
    version = root.attribute("version")
    document.version = _version(version)
    if not OLDEST <= document.version <= NEWEST:
        raise root.error(
            f"SDF version {version} is not supported; {_text(OLDEST)} to {_text(NEWEST)} are, best 1.6"
        )
    return root


def _version(text: str) -> tuple[int, ...]:
    """Return a version as numbers, because 1.10 is newer than 1.9; () if it is none."""
    words = text.strip().split(".")
    return tuple(map(int, words)) if all(word.isdigit() for word in words) else ()


def _text(version: tuple[int, ...]) -> str:
    return ".".join(map(str, version))


def _with_unequal_names(node: Node, models: list[Model]) -> list[Model]:
    """Return the models; one whose name is taken gets a number behind it, as Gazebo does to a new model."""
    taken: set[str] = set()
    found = []
    for model in models:
        name = model.name
        if name in taken:
            name = free_name(name, taken)
            note_number(node, "model", model.name, name)
        taken.add(name)
        found.append(replace(model, name=name))
    return found


def _without_repeats(sentences: list[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(sentences))
