"""Given cells of two kinds, a network learns them; the page's learnt detector runs as it is written."""

import io
import re
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from flight_basics.errors import SurveyError
from inspection.findings.picture.learnt import FEATURES, Network, features_of

PAGE = Path(__file__).resolve().parents[2] / "doc/findings.md"
BROWN = Network(
    np.zeros(FEATURES), np.ones(FEATURES), np.eye(FEATURES + 1, 1) * 0.1, np.array([400.0, -20.0]), 0.5, 4
)
"""Its neuron sees the share of red alone, and its sum is 0 where that is 0.5."""


def spotted():
    """A grey picture with a square that is brown, of 64 px."""
    picture = np.full((200, 300, 3), 120, np.uint8)
    picture[80:144, 120:184] = (140, 70, 30)
    return picture


def test_probabilities_are_those_by_hand():
    cell = np.zeros((1, FEATURES))
    assert BROWN.probabilities(cell)[0] == pytest.approx(1.0 / (1.0 + np.exp(20.0)))
    cell[0, 0] = 0.5
    assert BROWN.probabilities(cell)[0] == pytest.approx(
        1.0 / (1.0 + np.exp(20.0 - 400.0 * np.tanh(0.05))), rel=1e-6
    )


def test_features_tell_shares_of_light():
    features, times = features_of(np.full((80, 80, 3), 255, np.uint8))
    assert (times, features.shape) == (1, (10, 10, FEATURES))
    np.testing.assert_allclose(features[..., :2], 1.0 / 3.01, rtol=1e-4)


def test_a_brown_square_is_one_mark():
    (mark,) = BROWN.marks(spotted(), "rust")
    assert (mark.kind, mark.size_px) == ("rust", 64 * 64)
    np.testing.assert_allclose(mark.pixels.mean(axis=0), (151.5, 111.5))
    assert BROWN.marks(np.full((200, 300, 3), 120, np.uint8), "rust") == []
    assert BROWN.marks(np.zeros((5, 5, 3), np.uint8), "rust") == []  # no cell fits


def test_weights_are_stored_and_others_refused(tmp_path):
    BROWN.save(tmp_path / "a.npz")
    assert len(Network.load(tmp_path / "a.npz").marks(spotted(), "rust")) == 1
    (tmp_path / "b.npz").write_bytes(b"no weights")
    with pytest.raises(SurveyError, match="Train it again"):
        Network.load(tmp_path / "b.npz")


def test_the_page_s_node_answers_a_photograph(tmp_path, monkeypatch):
    messages = pytest.importorskip("inspection.msg")
    BROWN.save(tmp_path / "rust.npz")
    sent, heard = [], {}
    rospy = SimpleNamespace(
        init_node=lambda name: None,
        get_param={"~weights": str(tmp_path / "rust.npz")}.__getitem__,
        Publisher=lambda topic, kind, **_: SimpleNamespace(publish=sent.append),
        Subscriber=lambda topic, kind, callback, **_: heard.update({topic: callback}),
        spin=lambda: None,
    )
    __import__("inspection_ros.photograph_messages")  # with the true rospy
    monkeypatch.setitem(sys.modules, "rospy", rospy)
    text = PAGE.read_text(encoding="utf-8").split("### One that has learnt")[1]
    exec(re.search(r"```python\n(.*?)```", text, re.S)[1], {})
    photograph = messages.Photograph(file="a.jpg")
    stream = io.BytesIO()
    Image.fromarray(spotted()).save(stream, "JPEG", quality=95)
    photograph.image.data = stream.getvalue()
    photograph.camera.height, photograph.camera.width = 200, 300
    heard["photographs"](photograph)
    (answer,) = sent
    assert (answer.file, [each.kind for each in answer.candidates]) == ("a.jpg", ["rust"])
