"""Every bad file gives one sentence that starts with PATH:LINE, and says what is wrong there."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.sdf import parser
from simulation_tools.sdf.parser import SdfError, load_model, load_world, parse_model

HEAD = '<sdf version="1.6">\n<model name="m">\n'
TAIL = "\n</model>\n</sdf>"
LIDAR = (
    '<link name="a">\n<sensor name="s" type="ray">\n<ray><scan><horizontal><samples>{samples}</samples>'
    "<min_angle>{low}</min_angle><max_angle>{high}</max_angle></horizontal></scan>"
    "<range><min>{near}</min><max>{far}</max></range></ray></sensor></link>"
)


def lidar(samples="3", low="-1", high="1", near=".1", far="5"):
    return LIDAR.format(samples=samples, low=low, high=high, near=near, far=far)


def inertial(body):
    return f'<link name="a">\n<inertial>{body}</inertial></link>'


def collision(geometry):
    return f'<link name="a"><collision name="c">\n<geometry>{geometry}</geometry></collision></link>'


def joint(kind="fixed", parent="a", child="b", more=""):
    return (
        '<link name="a"/><link name="b"/>\n'
        f'<joint name="j" type="{kind}"><parent>{parent}</parent><child>{child}</child>{more}</joint>'
    )


@pytest.mark.table(
    ("body", "line", "saying"),
    [
        (inertial("<mass>-1</mass>"), 4, "<mass> must be positive, not -1"),
        (inertial("<mass>0</mass>"), 4, "<mass> must be positive"),
        (
            inertial("<inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz><ixy>2</ixy></inertia>"),
            4,
            "positive definite",
        ),
        ('<link name="a">\n<pose>0 0 nan 0 0 0</pose></link>', 4, "6 finite numbers"),
        ('<link name="a">\n<pose>0 0 0</pose></link>', 4, "6 finite numbers"),
        ('<link name="a">\n<pose>0 1e35 0 0 0 0</pose></link>', 4, "numbers up to 1e"),
        ('<link name="a">\n<pose>0 0 1e999 0 0 0</pose></link>', 4, "6 finite numbers"),
        ('<link name="a">\n<pose frame="nowhere">0 0 0 0 0 0</pose></link>', 3, 'no frame "nowhere"'),
        (collision("<sphere><radius>0</radius></sphere>"), 4, "<radius> must be positive"),
        (collision("<box><size>1 -1 1</size></box>"), 4, "positive numbers only"),
        (collision("<box><size>1 1 1e30</size></box>"), 4, "up to 1e"),
        (collision("<cylinder><radius>1e7</radius><length>1</length></cylinder>"), 4, "at most 1e"),
        (collision(""), 4, "needs exactly one of <box>"),
        (collision("<mesh><uri>model://none/x.stl</uri></mesh>"), 4, 'no model "none"'),
        (collision("<mesh><uri>http://x.org/x.stl</uri></mesh>"), 4, "unknown scheme"),
        (collision("<mesh><uri>x.stl</uri></mesh>"), 4, "no folder to start from"),
        (lidar(samples="1000000000"), 5, "from 1 to 100000"),
        (lidar(samples="2.5"), 5, "a whole number"),
        (lidar(near="6"), 5, "must be smaller than the greatest"),
        (lidar(low="2"), 5, "must be smaller than <max_angle>"),
        (lidar(low="-4", high="4"), 5, "more than a circle"),
        (lidar(far="inf"), 5, "a finite number"),
        ('<link name="a"/>\n<link name="a"/>', 4, 'A second <link> is called "a"'),
        ('<link name=""/>', 3, 'no attribute "name"'),
        ("<link/>", 3, 'no attribute "name"'),
        ('<link name="a  b"/>', 3, "cannot be the name"),
        ('<link name="world"/>', 3, "cannot be the name"),
        ("<static>true</static>", 2, "has no <link>"),
        ('<link name="a"/><static>maybe</static>', 3, "true or false"),
        (joint(kind="glued"), 4, 'no joints of type "glued"'),
        (joint(parent="c"), 4, 'names the link "c", which does not exist'),
        (joint(parent="b"), 4, "joins the link"),
        (joint(kind="revolute", more="<axis><xyz>0 0 0</xyz></axis>"), 4, "zero vector"),
        (
            joint() + '\n<joint name="k" type="fixed"><parent>b</parent><child>a</child></joint>',
            5,
            "closes a ring",
        ),
        (
            joint() + '\n<joint name="k" type="fixed"><parent>a</parent><child>b</child></joint>',
            5,
            "already joined",
        ),
    ],
)
def test_a_bad_model_is_refused_with_place_and_reason(body, line, saying):
    with pytest.raises(SdfError) as caught:
        parse_model(HEAD + body + TAIL, "some.sdf", [])
    message = str(caught.value)
    assert message.startswith(f"some.sdf:{line}: ")
    assert saying in message
    assert message.endswith(".")
    assert "\n" not in message


@pytest.mark.table(
    ("text", "line", "saying"),
    [
        ("", 1, "not well-formed XML"),
        ("<sdf version='1.6'>\n<model name='m'>\n<link>\n</model>", 4, "not well-formed XML"),
        ("<urdf/>", 1, "must start with <sdf>"),
        ("<sdf><model name='m'/></sdf>", 1, 'no attribute "version"'),
        ("<sdf version='2.0'><model name='m'/></sdf>", 1, "version 2.0 is not supported"),
        ("<sdf version='1.6'></sdf>", 1, "no <model>, <actor> or <light>"),
        ("<sdf version='1.6'><light name='l' type='point'/></sdf>", 1, "exactly one <model>, not 0"),
    ],
)
def test_a_file_that_holds_no_model_is_refused(text, line, saying):
    with pytest.raises(SdfError, match=re.escape(saying)) as caught:
        parse_model(text, "some.sdf", [])
    assert str(caught.value).startswith(f"some.sdf:{line}: ")


@pytest.mark.table(
    ("inside", "saying"),
    [
        ("<light name='l'/>", '<light> has no attribute "type"'),
        ("<light type='point'/>", '<light> has no attribute "name"'),
        ("<light name='l' type='spot'><pose>0 0 up</pose></light>", "<pose> must hold 6 finite numbers"),
        ("<light name='l' type='spot'><direction>down</direction></light>", "<direction> must hold 3"),
        ("<light name='l' type='point'><diffuse>red</diffuse></light>", "<diffuse> must hold 3"),
        ("<physics type='ode'><max_step_size>small</max_step_size></physics>", "must hold a finite number"),
    ],
)
def test_what_has_no_effect_in_a_world_is_left_out_by_name_if_it_is_malformed(tmp_path, inside, saying):
    world = tmp_path / "a.world"
    world.write_text(f"<sdf version='1.6'><world name='w'>\n{inside}</world></sdf>")
    (said,) = load_world(world, []).warnings
    assert f" is left out: {world}:2: " in said
    assert saying in said


BOMB = """<?xml version="1.0"?>
<!DOCTYPE lolz [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>
<sdf version="1.6"><model name="&b;"><link name="a"/></model></sdf>"""


@pytest.mark.table("encoding", ["utf-8", "utf-16"])
def test_entity_bombs_are_refused_in_any_encoding(encoding):
    text = BOMB.replace('version="1.0"', f'version="1.0" encoding="{encoding}"').encode(encoding)
    with pytest.raises(SdfError, match="document type"):
        parse_model(text, "bomb.sdf", [])


def test_an_external_entity_does_not_read_files(tmp_path):
    secret = tmp_path / "secret"
    secret.write_text("the secret")
    text = f'<!DOCTYPE x [<!ENTITY s SYSTEM "file://{secret}">]><sdf version="1.6"><model name="&s;"/></sdf>'
    with pytest.raises(SdfError) as caught:
        parse_model(text, "x.sdf", [])
    assert "the secret" not in str(caught.value)


def test_a_deep_tree_ends_in_an_error_not_in_a_crash():
    deep = "<model name='m'>" * 5000 + "</model>" * 5000
    with pytest.raises(SdfError, match="not well-formed"):
        parse_model(f"<sdf version='1.6'>{deep}</sdf>", "deep.sdf", [])


def test_a_huge_text_is_refused():
    with pytest.raises(SdfError, match="larger than 16 MB"):
        parse_model("<sdf>" + " " * (17 * 2**20) + "</sdf>", "huge.sdf", [])


@pytest.mark.table(
    ("load", "saying"),
    [
        (
            lambda folder: load_world(folder / "none.world", []),
            "^There is no world file .*/none[.]world; give",
        ),
        (lambda folder: load_model("model://none", [folder]), '^The model model://none .* no model "none"'),
        (lambda folder: load_model(folder / "none", []), "^There is no model .*/none; give"),
        (lambda folder: load_model(folder, []), "^The folder .* holds no model[.]config"),
    ],
)
def test_what_is_missing_is_said(tmp_path, load, saying):
    """No line is named of a file that does not exist."""
    with pytest.raises(SdfError, match=saying) as caught:
        load(tmp_path)
    assert ":1:" not in str(caught.value)


def test_a_file_that_cannot_be_read_is_said(tmp_path):
    # Reading a process's own memory from address zero fails for every user, root included.
    (tmp_path / "model.config").write_text('<model><sdf version="1.6">model.sdf</sdf></model>')
    (tmp_path / "model.sdf").symlink_to("/proc/self/mem")
    with pytest.raises(SdfError, match="cannot be read"):
        load_model(tmp_path, [])


def test_an_include_names_both_files(tmp_path):
    home = tmp_path / "bad"
    home.mkdir()
    (home / "model.config").write_text('<model><sdf version="1.6">model.sdf</sdf></model>')
    (home / "model.sdf").write_text(HEAD + inertial("<mass>-1</mass>") + TAIL)
    outer = tmp_path / "outer.sdf"
    outer.write_text(
        '<sdf version="1.6"><model name="o">\n<include><uri>model://bad</uri></include></model></sdf>'
    )
    with pytest.raises(SdfError) as caught:
        load_model(outer, [tmp_path])
    assert str(caught.value).startswith(f"{home / 'model.sdf'}:4: <mass> must be positive")
    assert f"Included by {outer}:2" in str(caught.value)


def test_a_model_that_includes_itself_is_refused(tmp_path):
    home = tmp_path / "snake"
    home.mkdir()
    (home / "model.config").write_text('<model><sdf version="1.6">model.sdf</sdf></model>')
    (home / "model.sdf").write_text(
        HEAD + '<link name="a"/><include><uri>model://snake</uri></include>' + TAIL
    )
    with pytest.raises(SdfError, match="includes itself"):
        load_model("model://snake", [tmp_path])


def test_files_that_include_more_and_more_files_are_refused(tmp_path, monkeypatch):
    """Ten includes in each of four files, one within the other: 11,111 files are to be read."""
    monkeypatch.setattr(parser, "MAX_INCLUDED_FILES", 500)
    for depth in range(5):
        home = tmp_path / f"m{depth}"
        home.mkdir()
        (home / "model.config").write_text('<model><sdf version="1.6">model.sdf</sdf></model>')
        include = f"<include><uri>model://m{depth + 1}</uri><name>n%d</name></include>"
        inner = "".join(include % number for number in range(10)) if depth < 4 else ""
        (home / "model.sdf").write_text(HEAD + '<link name="a"/>' + inner + TAIL)
    with pytest.raises(SdfError, match="More than 500 files are included"):
        load_model("model://m0", [tmp_path])


@given(st.data())
def test_whatever_is_broken_in_a_file_the_answer_is_a_model_or_one_sentence(data):
    # Given a good file, of which one piece is replaced by something else
    good = (
        HEAD + joint("revolute", more="<axis><xyz>0 0 1</xyz></axis>") + lidar().replace('"a"', '"c"') + TAIL
    )
    start = data.draw(st.integers(0, len(good)))
    end = data.draw(st.integers(start, min(len(good), start + 30)))
    piece = data.draw(
        st.one_of(st.text(max_size=12), st.sampled_from(["<", "nan", "-1", "</link>", "&a;", "1e400"]))
    )
    broken = good[:start] + piece + good[end:]
    # When it is read, then it is a model, or nothing but a sentence comes out of it
    said = None
    try:
        parse_model(broken, "x.sdf", [])
    except SdfError as error:
        said = str(error)
    assert said is None or re.fullmatch(r"x\.sdf:\d+: .*\.", said, re.DOTALL)
