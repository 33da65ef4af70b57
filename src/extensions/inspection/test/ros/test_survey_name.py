"""What makes a goal another survey than the one before."""

import pytest

pytestmark = pytest.mark.ros

files = pytest.importorskip("inspection_ros.files", reason="needs ROS")

from inspection.msg import SurveyGoal  # noqa: E402


@pytest.fixture
def named(tmp_path):
    """The name of a goal whose plan and mesh hold these words, after a change of the goal."""

    def name(plan="a plan", mesh="a mesh", **changes):
        (tmp_path / "plan.yaml").write_text(plan)
        (tmp_path / "room.stl").write_text(mesh)
        goal = SurveyGoal(plan=str(tmp_path / "plan.yaml"), folder=str(tmp_path / "photographs"))
        for key, value in changes.items():
            setattr(goal, key, value)
        return files.name_of(goal, str(tmp_path / "room.stl"))

    return name


def test_the_same_goal_is_the_same_survey_whatever_its_time(named):
    assert named() == named() == named(time_max=30.0)


@pytest.mark.parametrize(
    "changed",
    [
        {"plan": "an edited plan"},
        {"mesh": "another mesh"},
        {"folder": "elsewhere"},
        {"photographs": 3},
        {"second_look": True},
        {"supplement": True},
    ],
)
def test_what_is_asked_and_what_the_files_hold_makes_another_survey(named, changed):
    assert named() != named(**changed)
