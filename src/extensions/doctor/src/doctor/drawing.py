"""Pictures of a running graph as source for graphviz's `dot`: its nodes and topics, and its TF tree.

Both are drawn from observations (`snapshot`), so they show the real system.
"""

from __future__ import annotations

import html
import re
from collections import defaultdict
from dataclasses import dataclass
from typing import Iterable, Mapping, Sequence

from doctor.expectations import CHAIN, QUIET_TOPICS
from doctor.snapshot import Graph, Node, Recording, Topic, Transform

COLOURS = {
    "simulation_tools": "#cfe3f5",
    "inspection_tools": "#d9efd3",
    "exploration": "#d3e9e6",
    "inspection": "#f2d9df",
    "cepa": "#fde0c5",
    "gridslam": "#e6d9f2",
    "flights": "#f5f0c4",
    "master_thesis": "#f5f0c4",
}
"""Fill of a package's nodes. The colours also differ in lightness, for prints in grey."""

OTHERS_COLOUR = "#eeeeee"
INK, MUTED, FAINT = "#222222", "#777777", "#aaaaaa"
MANY_EARS = 7
"""A node with this many subscriptions would fill the picture with arrows."""
LINE_LENGTH = 14
HIDDEN_TOPICS = ("/clock", "/tf", "/tf_static")
"""Topics of all nodes. The TF tree has its own picture."""

MAIN_LINE = {link.topic for link in CHAIN} | {link.source for link in CHAIN} | {"/mavros/setpoint_raw/local"}
_FONT = 'fontname="Helvetica" fontsize=11'
_HEAD = f"""  bgcolor="white" {_FONT} fontcolor="{INK}" pad=0.2
  node [{_FONT} color="{INK}" fontcolor="{INK}" penwidth=1]
  edge [{_FONT} fontsize=9 color="{INK}" fontcolor="{INK}" arrowsize=0.6]
"""


@dataclass(frozen=True)
class Wire:
    """A link between a node and something else, such as a flight controller; label: its name."""

    node: str
    far_end: str
    label: str


def node_graph(graph: Graph, wires: Sequence[Wire] = (), observers: Iterable[str] = ()) -> str:
    """Return the graph of nodes (ellipses) and topics (boxes) from left to right, as dot source.

    It leaves out topics without a subscriber, `QUIET_TOPICS`, `HIDDEN_TOPICS`, and `observers`: nodes that
    only watch, such as a recorder. A node with `MANY_EARS` subscriptions has them as text below its name.
    Nodes of one package that exchange messages share a frame.
    """
    hidden = set(observers)
    topics = [_without(topic, hidden) for topic in graph.recording.topics.values()]
    heard = defaultdict(list)
    for topic in topics:
        for name in topic.subscribers if _is_shown(topic) else ():
            heard[name].append(topic.name)
    witnesses = {name: names for name, names in heard.items() if len(names) >= MANY_EARS}
    topics = [topic for topic in (_without(topic, set(witnesses)) for topic in topics) if _is_shown(topic)]
    talking = {name for topic in topics for name in (*topic.publishers, *topic.subscribers)}
    nodes = [node for node in graph.nodes if node.name in talking | set(witnesses)]
    lines = ["digraph nodes {", _HEAD, "  rankdir=LR nodesep=0.13 ranksep=0.22 newrank=true"]
    grouped = set()
    for number, group in enumerate(_groups(nodes, topics)):
        inside = _topics_within(group, topics)
        grouped |= {topic.name for topic in inside}
        lines += _cluster(number, group, inside, witnesses)
    lines += [_topic_box(topic) for topic in topics if topic.name not in grouped]
    lines += [line for topic in topics for line in _arrows(topic)]
    lines += [line for wire in wires if wire.node in talking for line in _wire(wire)]
    return "\n".join([*lines, "}", ""])


def _without(topic: Topic, listeners: set[str]) -> Topic:
    """Return a topic without some of its subscribers."""
    subscribers = tuple(name for name in topic.subscribers if name not in listeners)
    return Topic(topic.name, topic.type, topic.publishers, subscribers)


def _is_shown(topic: Topic) -> bool:
    hidden = topic.name in HIDDEN_TOPICS or QUIET_TOPICS.match(topic.name)
    return bool(topic.publishers and topic.subscribers and not hidden)


def _groups(nodes: Sequence[Node], topics: Sequence[Topic]) -> list[list[Node]]:
    """Return the nodes in groups of one package that share private topics."""
    package_of = {node.name: node.package for node in nodes}
    group_of = {node.name: {node.name} for node in nodes}
    for topic in topics:
        linked = {*topic.publishers, *topic.subscribers}
        packages = {package_of.get(name, "") for name in linked}
        if len(packages) == 1 and packages != {""}:
            joined = set().union(*(group_of[name] for name in linked))
            group_of.update(dict.fromkeys(joined, joined))
    groups = {frozenset(group) for group in group_of.values()}
    by_name = {node.name: node for node in nodes}
    return [[by_name[name] for name in sorted(group)] for group in sorted(groups, key=sorted)]


def _topics_within(group: Sequence[Node], topics: Sequence[Topic]) -> list[Topic]:
    """Return the topics that only nodes of a group publish and subscribe to."""
    names = {node.name for node in group}
    return [topic for topic in topics if names >= {*topic.publishers, *topic.subscribers}]


def _cluster(
    number: int, group: Sequence[Node], inside: Sequence[Topic], witnesses: Mapping[str, Sequence[str]]
) -> list[str]:
    label = _quoted(group[0].package or "others")
    return [
        f"  subgraph cluster_{number} {{",
        f"    label={label} labeljust=l style=rounded margin=7",
        f'    color="{FAINT}" fontcolor="{MUTED}" fontsize=10',
        *(f"  {_ellipse(node, witnesses.get(node.name, ()))}" for node in group),
        *(f"  {_topic_box(topic)}" for topic in inside),
        "  }",
    ]


def _ellipse(node: Node, hears: Sequence[str]) -> str:
    fill = COLOURS.get(node.package, OTHERS_COLOUR)
    name = _escaped(_folded(node.name.lstrip("/"), "_"))
    if not hears:
        return f'  {_quoted(node.name)} [label="{name}" style=filled fillcolor="{fill}" margin="0.04,0.02"]'
    words = "".join(f'<br align="left"/>{html.escape(topic)}' for topic in sorted(hears))
    small = f'<font point-size="8" color="{MUTED}">subscribes to{words}<br align="left"/></font>'
    shape = f'shape=box style="filled,rounded" fillcolor="{fill}"'
    return f"  {_quoted(node.name)} [label=<{html.escape(node.name.lstrip('/'))}<br/>{small}> {shape}]"


def _topic_box(topic: Topic) -> str:
    label = _escaped(_folded(topic.name, "/"))
    look = f'shape=box fontsize=9 height=0.2 width=0.3 margin="0.05,0.02" color="{FAINT}"'
    return f'  {_box_name(topic)} [label="{label}" {look}]'


def _arrows(topic: Topic) -> list[str]:
    """Return the arrows to and from a topic. The main line is thick and straight."""
    box, main = _box_name(topic), topic.name in MAIN_LINE
    style = "[weight=50 penwidth=2]" if main else f'[color="{MUTED}"]'
    arrows = [f"  {_quoted(name)} -> {box} {style}" for name in sorted(topic.publishers)]
    return arrows + [f"  {box} -> {_quoted(name)} {style}" for name in sorted(topic.subscribers)]


def _box_name(topic: Topic) -> str:
    return _quoted(f"topic {topic.name}")


def _wire(wire: Wire) -> list[str]:
    style = "style=dashed dir=both weight=50 penwidth=2"
    return [
        f'  {_quoted(wire.far_end)} [label="{_escaped(wire.label)}" shape=box style=dashed]',
        f"  {_quoted(wire.node)} -> {_quoted(wire.far_end)} [{style}]",
    ]


def tf_tree(recording: Recording) -> str:
    """Return the TF tree as dot source: below each frame its publisher and rate; static ones are dashed."""
    edges = defaultdict(list)
    for edge in recording.transforms:
        edges[edge.parent, edge.child].append(edge)
    frames = sorted({frame for pair in edges for frame in pair})
    lines = ["digraph tf {", _HEAD, "  rankdir=LR nodesep=0.1 ranksep=0.35"]
    lines.append('  node [shape=box style=rounded margin="0.1,0.03" height=0.3]')
    for frame in frames:
        told = [
            _of_edge(edge) for (_, child), same in sorted(edges.items()) if child == frame for edge in same
        ]
        lines.append(f"  {_quoted(frame)} [label=<{_frame_label(frame, told)}>]")
    for (parent, child), same in sorted(edges.items()):
        style = "dashed" if all(edge.static for edge in same) else "solid penwidth=2"
        lines.append(f"  {_quoted(parent)} -> {_quoted(child)} [style={style}]")
    return "\n".join([*lines, "}", ""])


def _frame_label(frame: str, told: Sequence[str]) -> str:
    lines = "".join(f"<br/>{html.escape(line)}" for line in told)
    return html.escape(frame) + (f'<font point-size="8" color="{MUTED}">{lines}</font>' if told else "")


def _of_edge(edge: Transform) -> str:
    """Return the publisher of an edge, and its mean rate by its stamps."""
    stamps_s = sorted(set(edge.stamps_s))
    if edge.static:
        how_often = "static"
    elif len(stamps_s) < 2:
        how_often = "once"
    else:
        how_often = f"{(len(stamps_s) - 1) / (stamps_s[-1] - stamps_s[0]):.0f} Hz"
    return f"{edge.publisher.lstrip('/')}, {how_often}"


def _folded(name: str, separator: str) -> str:
    """Return a name in lines of about `LINE_LENGTH` letters, broken before its separators."""
    lines = [""]
    for part in re.findall(rf"{separator}?[^{separator}]+", name):
        if lines[-1] and len(lines[-1] + part) > LINE_LENGTH:
            lines.append("")
        lines[-1] += part
    return "\n".join(lines)


def _escaped(text: str) -> str:
    return text.replace("\\", r"\\").replace('"', r"\"").replace("\n", r"\n")


def _quoted(text: str) -> str:
    return f'"{_escaped(text)}"'
