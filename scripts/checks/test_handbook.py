"""What the handbook is made of. Its build looks at links, menu, texts of pictures and sentences."""

from __future__ import annotations

import re
from fnmatch import fnmatch
from pathlib import Path

import pytest
from handbook import library
from handbook.__main__ import stage_all
from handbook.layout import with_captions, with_comments_above
from handbook.lists import spread
from handbook.pages import all_pages, pictures, with_links
from handbook.parameters import tables
from handbook.parameters.launches import set_by_launch_files
from handbook.parameters.meanings import Parameter, attributes, private_parameters
from handbook.staging import Stage

ROOT = Path(__file__).resolve().parents[2]
FOREIGN = {"use_sim_time"}


@pytest.fixture(scope="module")
def parameters():
    return tables.known_parameters()


def test_a_picture_without_a_text_is_found():
    text = '![](a.png) ![ ](b.png) ![`w`](c.png) `![](code.png)`\n<img src="d.png"> <img src="e.png" alt="w">'
    assert [file for words, file in pictures(text) if not words] == ["a.png", "b.png", "d.png"]
    assert ("`w`", "c.png") in pictures(text)


def test_a_parameter_without_a_sentence_is_named():
    (sentence,) = tables.faults({("cepa", "cepa"): {"r_lb": Parameter("r_lb", sentence=" ")}})
    assert "node cepa reads r_lb" in sentence


def test_what_a_node_asks_for_by_name_is_on_a_page(parameters):
    """Found by another way: every private name in a call of get_param is in the tables of its package."""
    for package in {package for package, _ in parameters} - {"master_thesis"}:
        (folder,) = (path.parent for path in ROOT.glob(f"src/**/{package}/setup.py"))
        known = {name for (owner, _), rows in parameters.items() if owner == package for name in rows}
        files = [
            *(folder / "nodes").glob("*"),
            *(folder / "ros").rglob("*.py"),
        ]
        text = "".join(path.read_text(encoding="utf-8") for path in files if path.is_file())
        asked = set(re.findall(r'\bget(?:_param)?\(\s*"~([\w/]+)"', text))
        assert {name for name in asked if not any(each.startswith(f"{name}/") for each in known)} <= known, (
            package
        )


def test_what_a_launch_file_sets_is_on_the_nodes_page(parameters):
    for node, names in set_by_launch_files().items():
        assert names.keys() - FOREIGN <= parameters.get(node, names).keys(), node


@pytest.mark.parametrize(
    ("node", "name", "expected"),
    [
        (("cepa", "cepa"), "r_lb", ("float", 0.5, 0.05, 5.0, "m")),  # .cfg
        (("exploration", "explore"), "reach", ("float", 10.0, 0.5, 200.0, "m")),  # dataclass, Attributes
        (("exploration", "explore"), "planner/margin", ("float", 0.2, 0.0, 5.0, "m")),  # in a namespace
        (
            ("gridslam", "slam_gridslam"),
            "closure_rest_s",
            ("float", 10.0, "above 0", None, "s"),
        ),  # text below the field
        (
            ("gridslam", "slam_gridslam"),
            "throttle_scans",
            ("int", 1, 1, None, ""),
        ),  # of a second class without a prefix
        (
            ("gridslam", "slam_octomap"),
            "sensor_model/hit",
            ("float", 0.7, "above 0.5", "below 1", ""),
        ),  # of a class in another one
        (("simulation_tools", "gazebo"), "lockstep_timeout", ("float", 1.0, None, None, "s")),  # launch file
    ],
)
def test_a_row_is_what_the_sources_say(parameters, node, name, expected):
    row = parameters[node][name]
    assert (row.kind, row.default, row.least, row.most, row.unit) == expected


@pytest.mark.parametrize(
    ("sentence", "expected"),
    [
        ("m: length of a leg.", "| m | Length of a leg. |"),
        ("Length of a leg, m.", "| m | Length of a leg, m. |"),
        ("x of the start in m: of its base.", "| m | x of the start in m: of its base. |"),
    ],
)
def test_a_unit_before_a_sentence_stands_in_its_column_only(sentence, expected):
    node = {"leg": Parameter("leg", "float", 2.0, sentence=sentence)}
    ((_, page),) = tables.pages({("package", "node"): node})
    assert expected in page


def test_one_text_may_tell_of_several_attributes():
    told = attributes(
        "Sizes.\n\nAttributes:\n    a, b: Of both,\n        m.\n    c: Third.\n\nRaises:\n    E: no.\n"
    )
    assert told == {"a": "Of both, m.", "b": "Of both, m.", "c": "Third."}


def test_a_nodes_docstring_tells_of_its_parameters():
    told = private_parameters(
        "A node.\n\nParameters (private):\n"
        "    frame (str, default map)\n    x, y (float, 0): of the\n        base.\n"
        "    plan (str): of ~inspect. late (bool, false): wait; so (int, 3): often.\n\nNo.\n"
    )
    of_base = "Of the base."
    assert told == {
        "frame": "",
        "x": of_base,
        "y": of_base,
        "plan": "Of ~inspect.",
        "late": "Wait",
        "so": "Often.",
    }


@pytest.mark.parametrize(
    ("typed", "page"),
    [
        ("tune parameter", "doc/using.md"),
        ("replace gmapping", "doc/coming_from.md"),
        ("own lidar", "src/extensions/flights/doc/tutorial.md"),
        ("own tank", "src/extensions/flights/doc/own_tank.md"),
        ("real PX4", "src/simulation_tools/doc/px4_sitl.md"),
        ("keys of result", "src/extensions/flights/doc/reference.md"),
        ("UAV stop", "*/doctor.md"),
        ("UAV crash", "*/doctor.md"),
        ("why UAV stopped", "*/doctor.md"),
        ("UAV does not move", "*/doctor.md"),
        ("two machines", "*/campaigns.md"),
        ("kind of finding", "CONTRIBUTING.md"),
        ("add lidar", "CONTRIBUTING.md"),
    ],
)
def test_what_a_student_types_stands_in_a_heading(typed, page):
    """The search counts a word of a heading a thousand times. The last word may be a beginning."""
    *words, begun = typed.lower().split()
    (text,) = (
        (ROOT / each).read_text(encoding="utf-8") for each in all_pages() if fnmatch(each.as_posix(), page)
    )
    headings = [re.findall(r"\w+", line.lower()) for line in re.findall(r"(?m)^#+ (.*)", text)]
    assert any(set(words) <= {*each} and any(word.startswith(begun) for word in each) for each in headings)


def test_the_search_shows_parameters_before_names_of_the_code(parameters):
    """Names of the code are headings there, which the search counts a thousand times."""
    boosts = [
        float(re.search(r"(?m)^  boost: (.*)", text).group(1))
        for text in (library.FOUND_LATER, *(text for _, text in tables.pages(parameters)))
    ]
    assert boosts[0] * 1000 <= 1 < min(boosts[1:])


def test_the_search_shows_tutorials_and_how_tos_before_parameters(tmp_path, parameters):
    """A word of a heading counts the same on each page; what a page is for must decide."""
    stage = stage_all(tmp_path, is_quick=True)
    boosts = {
        page: float(found[1]) if (found := re.search(r"(?m)\A---\nsearch:\n  boost: (.*)", text)) else 1.0
        for page in all_pages()
        for text in [(stage.folder / page).read_text(encoding="utf-8")]
    }
    greatest = max(float(re.search(r"(?m)^  boost: (.*)", text)[1]) for _, text in tables.pages(parameters))
    for name in ("tutorial", "own_tank", "launch_files", "doctor"):
        (boost,) = (boost for page, boost in boosts.items() if page.stem == name)
        assert boost > greatest, name
    assert boosts[Path("src/cepa/doc/reference.md")] == 1.0


@pytest.mark.parametrize(
    ("page", "spread_page"),
    [
        ("Text:\n- a\n  goes on\n- b\n", "Text:\n\n- a\n    goes on\n- b\n"),
        ("1. a\n   - b\n\n   text of a\n", "1. a\n    - b\n\n    text of a\n"),
        ("Text\n| a |\n|---|\n", "Text\n\n| a |\n|---|\n"),
        ("```\n- code\n  - code\n```\n", "```\n- code\n  - code\n```\n"),
        ("    code\n\n- a\n", "    code\n\n- a\n"),
    ],
)
def test_lists_and_tables_are_spread(page, spread_page):
    assert spread(page) == spread_page


def test_links_are_changed_and_code_stays():
    text = "[a](b.py#x) [web](https://c.org/d) `[e](f)` [g](#h)\n```\n[i](j)\n```\n"
    assert with_links(text, lambda path: path + ".md") == text.replace("b.py", "b.py.md")


def test_what_a_page_refers_to_is_shown(tmp_path):
    (tmp_path / "doc").mkdir()
    (tmp_path / "doc/page.md").write_text("[code](../tool.py) [folder](../doc) [page](page.md)\n")
    (tmp_path / "tool.py").write_text('"""A tool."""\n')
    stage = Stage(tmp_path / "site", tmp_path)
    stage.take(Path("doc/page.md"))
    assert (
        stage.folder / "doc/page.md"
    ).read_text() == "[code](../tool.py.md) [folder](files.md) [page](page.md)\n"
    assert '"""A tool."""' in (stage.folder / "tool.py.md").read_text()
    assert "`page.md`" in (stage.folder / "doc/files.md").read_text()


def test_a_picture_shows_its_words_and_opens_when_it_is_clicked():
    text = "![Two words](a/b.png)\n\nin a line ![c](c.png)\n```\n![code](d.png)\n```\n"
    assert with_captions(text) == (
        "[![Two words](a/b.png)](a/b.png)\n\nTwo words\n{: .caption }\n\n"
        "\nin a line ![c](c.png)\n```\n![code](d.png)\n```\n"
    )


def test_a_comment_that_does_not_fit_beside_its_command_stands_above_it():
    long = "roslaunch package file.launch " + "x" * 50
    text = (
        f"```sh\n{long}   # what it does\nls -l   # too\nls '#'\na \\\n  b   # of a and b\n```\n"
        "```sh\nls   # short\n```\n```yaml\n"
    )
    yaml_line = "key: 1   # " + "y" * 100 + "\n```\n"
    assert with_comments_above(text + yaml_line) == (
        f"```sh\n# what it does\n{long}\n# too\nls -l\nls '#'\na \\\n  b   # of a and b\n```\n"
        "```sh\nls   # short\n```\n```yaml\n" + yaml_line
    )
