"""Whoever asks another program or node, waits for a limited time only: it may hang, and a UAV flies on."""

import ast
import re
from functools import cache

import pytest
from locked_calls import dotted
from python_sources import sources

WAITING = re.compile(r"wait|ServiceProxy|subprocess\.|communicate|urlopen")


@cache
def trees():
    """Return the files in which something may wait and which run on a robot; helpers of tests do not."""
    texts = {path: path.read_text(encoding="utf-8") for path in sources() if path.name != "testing.py"}
    return [(path, ast.parse(text)) for path, text in texts.items() if WAITING.search(text)]


WAITS = {"wait_for_service": 1, "wait_for_message": 2, "wait_for_result": 0, "wait_for_server": 0}
"""By the last name of a call: the number of arguments before its time limit, if it is a method."""
UNLIMITED = {
    "machine_code.py": "the present algorithm steers while the next one is compiled",
}


def limits(call, before):
    """Whether a call has a time limit, after so many arguments."""
    named = {keyword.arg for keyword in call.keywords}
    return len(call.args) > before or bool(named & {"timeout", "timeout_s"})


def fault_of(call):
    """Return what is wrong with a call; empty: nothing."""
    name = dotted(call.func)
    last = name.rpartition(".")[2]
    if name.endswith("rospy.ServiceProxy") or name == "ServiceProxy":
        return "node_tools.services.ServiceCall has a time limit, rospy.ServiceProxy has none"
    if last in WAITS:
        is_function = name in {f"rospy.{last}", last}
        before = WAITS[last] if is_function else 0
        return "" if limits(call, before) else "it waits without a time limit"
    if name in {"subprocess.run", "subprocess.call", "subprocess.check_call", "subprocess.check_output"}:
        return "" if limits(call, 99) else "the program may hang"
    if last in {"communicate", "urlopen"}:
        return "" if limits(call, 1) else "it waits without a time limit"
    return ""


def test_every_question_has_a_time_limit():
    faults = [
        f"{path}:{node.lineno}: {fault}"
        for path, tree in trees()
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and (fault := fault_of(node)) and path.name not in UNLIMITED
    ]
    assert faults == []


def test_a_process_is_awaited_for_ever_only_when_it_is_told_to_end():
    faults = [
        f"{path}:{function.lineno}: {function.name}"
        for path, tree in trees()
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef) and path.name not in UNLIMITED
        if any(waits_for_process(call) for call in ast.walk(function))
        if not any(word in ast.unparse(function) for word in (".kill()", "SIGKILL", ".terminate()"))
    ]
    assert faults == []


def waits_for_process(call):
    """Whether something in a file waits for the end of a process for ever."""
    kinds = ("process", "child", "launch", "server", "probe", "running")
    return (
        isinstance(call, ast.Call)
        and dotted(call.func).endswith(tuple(f"{kind}.wait" for kind in kinds))
        and not limits(call, 0)
    )


@pytest.mark.parametrize(
    ("line", "is_right"),
    [
        ("rospy.ServiceProxy('x', X)", False),
        ("ServiceCall('x', X)", True),
        ("rospy.wait_for_service('x')", False),
        ("rospy.wait_for_service('x', 3.0)", True),
        ("self._call.wait_for_service()", False),
        ("self._call.wait_for_service(3.0)", True),
        ("subprocess.run(['x'])", False),
        ("subprocess.run(['x'], timeout=3.0)", True),
        ("client.wait_for_result()", False),
    ],
)
def test_the_reading_of_sources_sees_what_has_no_limit(line, is_right):
    assert (fault_of(ast.parse(line).body[0].value) == "") == is_right
