"""Given pictures of mottled and of even brown things, the network of cells learns which are rust."""

import numpy as np
import pytest
from PIL import Image

from benchmarks.findings_rows.learn_cells import main
from inspection.findings.picture.rust_cells import FEATURES, Weights


@pytest.fixture
def pictures(tmp_path):
    rng, rows = np.random.default_rng(2), ["name,rust"]
    for k in range(8):
        mottled = np.exp(rng.normal(0.0, 0.3 if k < 4 else 0.01, (96, 96, 1)))
        brown = np.clip(np.array((140, 75, 40)) * mottled, 0, 255)
        place = np.s_[:48] if k % 2 else np.s_[:, 48:]  # no two are alike
        brown[place] = 130
        Image.fromarray(brown.astype(np.uint8)).save(tmp_path / f"{k}.png")
        rows.append(f"{k}.png,{'yes' if k < 4 else 'no'}")
    (tmp_path / "answers.csv").write_text("\n".join(rows))
    return tmp_path


def test_the_command_learns_tells_and_writes(pictures, capsys):
    out = pictures / "rust_cells.npz"
    main(["--photographs", str(pictures), "--truth", str(pictures / "answers.csv"), "--out", str(out)])
    said = capsys.readouterr().out
    assert "first half, learnt: found 2 of 2 with rust, false 0 of 2" in said
    assert "second half: found 2 of 2 with rust, false 0 of 2" in said
    with np.load(out) as stored:
        weights = Weights(**stored)
    assert weights.probabilities(np.zeros((3, FEATURES))).shape == (3,)


def test_each_folder_needs_its_table(pictures, capsys):
    with pytest.raises(SystemExit):
        main(["--photographs", str(pictures), str(pictures), "--truth", str(pictures / "answers.csv")])
    assert "give a FILE for each FOLDER" in capsys.readouterr().err
