"""The .cfg files say of each live parameter what its dataclass says."""

from __future__ import annotations

import live_parameters
from handbook.parameters.meanings import Parameter

FILES = live_parameters.config_files()


def test_the_files_of_the_tools_are_written_from_dataclasses():
    names = {"Cepa", "LidarMedianFilter", "MavrosPublisher", "PathPlanner", "Physics", "PositionController"}
    assert names | {"YawRegulator"} <= {path.stem for path in FILES}
    added = {name for path in FILES for _, name, *_ in live_parameters.ADD.findall(path.read_text("utf-8"))}
    assert live_parameters.NAMES.keys() <= added


def test_sentence_default_and_limits_come_from_the_dataclass_and_the_group_stays():
    text = 'gen = 1\ngroup.add("gain", double_t, 0, "Old \\"text\\".", 1.0, 0.0, 5.0)\n'
    gain = Parameter("gain", "float", 1.5, 0.5, 4.0, 'A "gain", 1/s.')
    assert live_parameters.written(text, {"gain": gain}) == (
        'gen = 1\ngroup.add("gain", double_t, 0, "A \\"gain\\", 1/s.", 1.5, 0.5, 4.0)\n'
    )


def test_a_file_has_limits_also_where_a_parameter_has_none_of_its_own():
    text = 'a.add("gain", double_t, 0, "", 1.0, 0.0, 5.0)\na.add("is_on", bool_t, 0, "", False)\n'
    text += 'a.add("parts", str_t, 0, "", "1.0")\n'
    gain = Parameter("gain", "float", 1.5, "above 0", None, "A gain.", live=(0.01, 4.0))
    rest = {
        "is_on": Parameter("is_on", "bool", True, sentence="Yes or no."),
        "parts": Parameter("parts", "tuple", (0.5, 0.25), sentence="Two."),
    }
    assert live_parameters.written(text, {"gain": gain, **rest}).splitlines() == [
        'a.add("gain", double_t, 0, "A gain.", 1.5, 0.01, 4.0)',
        'a.add("is_on", bool_t, 0, "Yes or no.", True)',
        'a.add("parts", str_t, 0, "Two.", "0.5 0.25")',
    ]
