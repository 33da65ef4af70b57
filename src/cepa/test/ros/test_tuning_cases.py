"""Every parameter changes an answer: of the library here, of the running node in rostest_tuning.py."""

import numpy as np
import pytest
from tuning_cases import CASES, names


def test_every_parameter_has_its_case():
    assert sorted(case.name for case in CASES) == sorted(names())


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_every_parameter_changes_the_answer(case):
    change = np.subtract(case.answer(**{case.name: case.value}), case.answer())
    assert np.hypot(*change) > 0.01  # m/s
