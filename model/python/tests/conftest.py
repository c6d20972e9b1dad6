"""Shared by the tests: the program `finray`, whose output is the reference, and the scenes."""

import csv
import os
import subprocess
from pathlib import Path

import finray
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]
SCENES = ROOT / "fixtures" / "scenes"
# The program `finray`, built from the same version of the code as the Python module.
PROGRAM = os.environ.get("FINRAY", str(ROOT / "target" / "release" / "finray"))


def run(*arguments):
    """Output, messages and exit code of the program."""
    words = [PROGRAM, *map(str, arguments)]
    answer = subprocess.run(words, capture_output=True, text=True, cwd=ROOT, check=False)
    return answer.stdout, answer.stderr, answer.returncode


def done(*arguments):
    """Output and messages of a command that succeeds."""
    out, said, code = run(*arguments)
    assert code == 0, said
    return out, said


def refusal(*arguments):
    """Message of a command that fails."""
    _, said, code = run(*arguments)
    assert code in (1, 2), said
    return said.partition("error: ")[2].strip()


def table(text):
    """Columns of a CSV table: numbers if every cell is a number or empty (NaN), otherwise texts."""
    head, *rows = csv.reader(text.splitlines())
    columns = {}
    for name, cells in zip(head, zip(*rows)):
        try:
            columns[name] = np.array([float(cell) if cell else np.nan for cell in cells])
        except ValueError:
            columns[name] = list(cells)
    return columns


def assert_same(ours, printed):
    """Same numbers to the last bit; the program prints the shortest digits that give the number back."""
    ours = np.asarray(ours, dtype=float)
    assert ours.shape == printed.shape and len(ours) > 0
    np.testing.assert_array_equal(ours, printed)


@pytest.fixture(scope="session")
def images(tmp_path_factory):
    """Two images of the finger of `camera.toml`: unloaded, and under 2 N at 80 mm."""
    folder = tmp_path_factory.mktemp("images")
    free, pressed = folder / "free.png", folder / "pressed.png"
    done("render", SCENES / "camera.toml", "--grey-noise", 2, "--out", free)
    done("render", SCENES / "camera.toml", "--load-at", "80:2,-20", "--grey-noise", 2, "--out", pressed)
    return free, pressed


@pytest.fixture(scope="session")
def paper():
    return finray.Scene.paper()


@pytest.fixture(scope="session")
def camera():
    return finray.Scene.read(SCENES / "camera.toml")


@pytest.fixture(scope="session")
def bent(paper):
    """The paper's finger under 2 N."""
    return finray.solve(paper, [(80, 2, -20)])
