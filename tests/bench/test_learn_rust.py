"""Given pictures of two kinds, the worked example of a learnt detector learns to tell them."""

import numpy as np
from PIL import Image

from benchmarks.findings_rows.learn import main, trained
from inspection.findings.picture.learnt import FEATURES, Network


def test_cells_that_a_line_divides_are_learnt():
    rng = np.random.default_rng(1)
    features = rng.normal(size=(400, FEATURES))
    answers = features[:, 0] > 2.0 * features[:, 3]
    network = trained(features[:300], answers[:300], rng)
    assert np.mean((network.probabilities(features[300:]) > 0.5) == answers[300:]) > 0.9


def test_the_command_writes_a_detector(tmp_path, capsys):
    rng, rows = np.random.default_rng(2), ["name,rust"]
    for k in range(8):
        picture = rng.normal(120.0, 10.0, (96, 96, 3))
        if k < 4:
            y, x = 46 * (k // 2), 46 * (k % 2)
            picture[y : y + 50, x : x + 50] = np.array((140, 70, 30)) + rng.normal(0.0, 15.0, (50, 50, 1))
        Image.fromarray(np.clip(picture, 0, 255).astype(np.uint8)).save(tmp_path / f"{k}.png")
        rows.append(f"{k}.png,{'yes' if k < 4 else 'no'}")
    (tmp_path / "answers.csv").write_text("\n".join(rows))
    out = tmp_path / "rust.npz"
    main(["--photographs", str(tmp_path), "--truth", str(tmp_path / "answers.csv"), "--out", str(out)])
    said = capsys.readouterr().out
    assert "first half, learnt: found 2 of 2 with rust, false 0 of 2" in said
    assert "second half: found 2 of 2 with rust" in said
    assert Network.load(out).hidden.shape == (FEATURES + 1, 16)
