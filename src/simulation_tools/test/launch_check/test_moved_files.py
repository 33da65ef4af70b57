"""A launch file that moved leaves one behind that only includes it. The check looks at the included one."""

from __future__ import annotations

import pytest

from simulation_tools.launch_check.launch_files import followed

LEADS = '<launch deprecated="moved"><include file="$(find new)/there.launch" pass_all_args="true"/></launch>'


@pytest.mark.table(
    ("text", "leads"),
    [
        (LEADS, True),
        (LEADS.replace("true", "false"), False),
        (LEADS.replace("find new", "find absent"), False),
        (LEADS.replace("there.launch", "absent.launch"), False),
        (LEADS.replace("/></launch>", '><arg name="a" value="1"/></include></launch>'), False),
        (LEADS.replace("<include", '<arg name="a" default="1"/><include'), False),
        ("<launch/>", False),
    ],
)
def test_a_file_that_only_includes_another_stands_for_it(tmp_path, text, leads):
    there, here = tmp_path / "there.launch", tmp_path / "here.launch"
    there.write_text('<launch><arg name="a"/></launch>')
    here.write_text(text)
    assert followed(here, lambda package: {"new": str(tmp_path)}[package]) == (there if leads else here)
