"""Simulated presses."""

import finray
import pytest
from conftest import SCENES, assert_same, done, refusal, table
from test_solve import assert_same_shape

COLUMNS = ["step", "travel_mm", "s_mm", "angle_deg", "force_n", "friction_n", "sensed_n", "sigma_n", "read_s_mm", "read_angle_deg"]


@pytest.mark.parametrize(
    "scene, ours, theirs",
    [
        ("disc", {"fineness": 2, "noise_mm": 0.05}, ["--fineness", 2, "--noise-mm", 0.05]),
        ("friction", {"fineness": 1, "seed": 7}, ["--fineness", 1, "--seed", 7]),
        ("fork", {"fineness": 1}, ["--fineness", 1]),
    ],
)
def test_a_press_is_the_program_s(scene, ours, theirs, tmp_path):
    path = SCENES / "contact" / f"{scene}.toml"
    press = finray.press(finray.Scene.read(path), **ours)
    out, said = done("press", path, *theirs, "--shape", tmp_path / "shape.csv")
    printed = table(out)
    assert press.contact == [name if isinstance(name, str) else str(int(name)) for name in printed["contact"]]
    for name in COLUMNS:
        assert_same(getattr(press, name), printed[name])
    assert_same_shape(press.shape, (tmp_path / "shape.csv").read_text())
    assert press.warnings == [line.partition(": ")[2] for line in said.splitlines()[:-1]] and press.stopped is None


def test_the_shape_of_a_press_has_the_warnings_of_its_last_step():
    press = finray.press(finray.Scene.read(SCENES / "contact" / "disc.toml"), fineness=2)
    last = f"step {press.step[-1]}: "
    assert press.shape.warnings == [warning[len(last) :] for warning in press.warnings if warning.startswith(last)] != []


def test_errors_have_the_messages_of_the_program():
    path = SCENES / "paper.toml"
    with pytest.raises(finray.FinrayError) as error:
        finray.press(finray.Scene.read(path))
    assert str(error.value) == refusal("press", path)
    text = (SCENES / "contact" / "fork.toml").read_text()
    with pytest.raises(finray.FinrayError, match="fork.csv: cannot be read"):
        finray.press(finray.Scene.parse(text))


@pytest.mark.parametrize("wrong", [{"fineness": 0}, {"fineness": 101}, {"noise_mm": -1}])
def test_wrong_options_are_errors(wrong):
    with pytest.raises(finray.FinrayError, match=f"{next(iter(wrong))}: expected"):
        finray.press(finray.Scene.read(SCENES / "contact" / "disc.toml"), **wrong)
