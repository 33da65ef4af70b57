"""A YAML file is read whole, or refused in one sentence that names the file and the line."""

import pytest

from flight_basics.errors import MissionError, ParameterError
from flight_basics.yaml_file import read_yaml


def read(path, parse=dict):
    return read_yaml(path, "The thing", parse, MissionError)


def test_the_content_goes_to_the_parser(tmp_path):
    (tmp_path / "a.yaml").write_text("a: 1.5\nb: [x, 2]\n")
    assert read(tmp_path / "a.yaml") == {"a": 1.5, "b": ["x", 2]}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_whatever_editor_has_written_it(tmp_path, encoding, end):
    (tmp_path / "a.yaml").write_bytes(f"# Prüfung{end}name: Süd{end}b: 2{end}".encode(encoding))
    assert read(tmp_path / "a.yaml") == {"name": "Süd", "b": 2}


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"a: 1\nb: [\n", r"The thing \S+a\.yaml is not YAML, line 3\."),
        (b"\0\1", r"The thing \S+a\.yaml is not YAML\."),
        (b"[" * 100_000, r"The thing \S+a\.yaml is not YAML(, line \d+)?\."),
        (b"1" * 5000, r"The thing \S+a\.yaml is not YAML\."),
        (None, r"The thing \S+a\.yaml cannot be read: No such file or directory\."),
    ],
    ids=["open list", "no text", "depth", "digits", "none"],
)
def test_a_file_that_is_none_is_refused(tmp_path, content, said):
    if content is not None:
        (tmp_path / "a.yaml").write_bytes(content)
    with pytest.raises(MissionError, match=f"^{said}$"):
        read(tmp_path / "a.yaml")


def test_what_the_parser_refuses_names_the_file(tmp_path):
    def refuse(content):
        raise ParameterError(f"x is {content!r}; it must be more.")

    (tmp_path / "a.yaml").write_text("3")
    with pytest.raises(MissionError, match=r"a\.yaml: x is 3; it must be more\.$"):
        read(tmp_path / "a.yaml", refuse)
