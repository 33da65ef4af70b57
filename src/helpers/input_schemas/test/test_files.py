"""A file is read whole, without what is wrong in it, or refused in a sentence with file, line and key."""

from dataclasses import dataclass, field

import pytest

from input_schemas import InputError, MaybeInfinite, leaving_out, read_file, read_made, structured


class ThingError(Exception):
    """Of a package."""


@dataclass(frozen=True)
class Place:
    x: float
    y: float = 0.0

    def __post_init__(self) -> None:
        if self.y < 0.0:
            raise ThingError("y is below 0.")


@dataclass(frozen=True)
class Thing:
    name: str
    from_: int = 1
    height: MaybeInfinite = field(default=MaybeInfinite(1.0))
    places: tuple[Place, ...] = ()


def read(path, **how):
    return read_file(path, "The thing", Thing, ThingError, **how)


@pytest.mark.table("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.table("end", ["\n", "\r\n"])
def test_whatever_editor_has_written_it(tmp_path, encoding, end):
    text = f"# Prüfung{end}name: Süd{end}from: 2{end}height: .inf{end}places: [{{x: 1}}]{end}"
    (tmp_path / "a.yaml").write_bytes(text.encode(encoding))
    assert read(tmp_path / "a.yaml") == Thing("Süd", 2, MaybeInfinite(float("inf")), (Place(1.0),))


@pytest.mark.table(
    ("content", "said"),
    [
        (b"a: 1\nb: [\n", r"line 3, column 1 is not YAML \(.+\)"),
        (b"name: a\n\tfrom: 2\n", r"line 2, column 1 is not YAML \(a tab .+; use spaces\)"),
        (b"name: a\nplaces:\n-\tx: 1\n \ty: 2\n", r"line 3, column 2 is not YAML \(a tab .+; use spaces\)"),
        (b"\0\1", "it is not YAML"),
        (b"[" * 100_000, ".+ is not YAML.*"),
        (b"1" * 5000, "it is not YAML"),
        (None, "No such file or directory"),
    ],
)
def test_a_file_that_is_none_is_refused(tmp_path, content, said):
    if content is not None:
        (tmp_path / "a.yaml").write_bytes(content)
    with pytest.raises(ThingError, match=rf"^The thing \S+a\.yaml cannot be read: {said}\.$"):
        read(tmp_path / "a.yaml")


def test_a_fault_is_told_with_its_line(tmp_path):
    path = tmp_path / "a.yaml"
    for text, said in (
        ("name: a\nplaces:\n- {x: 1}\n- {x: b}\n", r"line 4: x in entry 2 of places is 'b'; it must be a"),
        ("name: a\nplaces: [{x: 1e3}]\n", r"line 2: x .+ is '1e3'; it must be a finite .+ Write 1000\.0,"),
        ("name: a\nplaces:\n- {x: 1}\n- {x: 1, y: -1}\n", r"line 4: entry 2 of places: y is below 0\."),
        ("name: a\nplaces:\n- x: 1\n  xx: 1\n", r"line 4: entry 1 of places has the key 'xx'"),
        ("# a\nform: 2\nname: a\n", r"line 2: The top level .+ did you mean 'from'\?$"),
        ("from: 2\n", r"line 1: The top level lacks the key 'name'\.$"),
    ):
        path.write_text(text)
        with pytest.raises(ThingError, match=rf"^\S+a\.yaml, {said}"):
            read(path)


def test_what_a_newer_program_adds_is_ignored_where_programs_write(tmp_path):
    (tmp_path / "a.json").write_text('{"name": "a", "more": 1, "from": null}')
    assert read(tmp_path / "a.json", other_keys=True) == Thing("a")


def test_what_a_package_refuses_names_the_file(tmp_path):
    def refuse(content):
        raise ThingError(f"x is {content!r}; it must be more.")

    (tmp_path / "a.yaml").write_text("3")
    with pytest.raises(ThingError, match=r"a\.yaml: x is 3; it must be more\.$"):
        read_made(tmp_path / "a.yaml", "The thing", refuse, ThingError)


def test_only_what_is_wrong_is_left_out():
    """Entries 2 and 3 cannot be without x; the others lose what need not be there."""
    places = [{"x": 1.0}, {"y": 1.0}, {"x": "b", "y": 3.0}, {"x": 4.0, "y": "c"}, 5]
    held, faults = leaving_out({"name": "a", "from": 1.5, "places": places}, Thing)
    assert held == Thing("a", places=(Place(1.0), Place(4.0)))
    told = sorted(each.what for each in faults)
    assert [each.split(" is ")[0] for each in told if " is " in each] == [
        "entry 5 of places", "from", "x in entry 3 of places", "y in entry 4 of places",
    ]  # fmt: skip
    assert "entry 2 of places lacks the key 'x'." in told
    with pytest.raises(InputError, match="lacks the key 'name'"):
        leaving_out({"from": 1}, Thing)


def test_a_message_is_checked_as_a_file():
    with pytest.raises(ThingError, match=r"^x is nan; it must be a finite number\.$"):
        structured({"x": float("nan")}, Place, ThingError)
