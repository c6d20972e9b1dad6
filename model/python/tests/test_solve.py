"""Shapes under loads."""

import finray
import numpy as np
import pytest
from conftest import SCENES, assert_same, done, refusal, table

KINEMATICS = ["linear", "corotational", "corotational-chord"]


def assert_same_shape(shape, text):
    printed = table(text)
    assert_same(shape.nodes, printed["node"])
    for axis, name in enumerate("xy"):
        assert_same(shape.positions[:, axis], printed[f"{name}_mm"])
        assert_same(shape.displacements[:, axis], printed[f"u{name}_mm"])
        if f"hinge_u{name}_mm" in printed:
            assert_same(shape.hinge_displacements[:, axis], printed[f"hinge_u{name}_mm"])
    assert_same(shape.rotations, printed["theta_rad"])


@pytest.mark.parametrize("kinematics", KINEMATICS)
def test_displacements_are_those_of_the_program(paper, kinematics):
    shape = finray.solve(paper, [(80, 0.5, -20), (100, 0.2, 0)], load=[(19, -0.1, -0.5)], kinematics=kinematics)
    loads = ["--load-at", "80:0.5,-20", "100:0.2,0", "--load", "19:-0.1,-0.5"]
    assert_same_shape(shape, done("solve", SCENES / "paper.toml", *loads, "--kinematics", kinematics)[0])


def test_displacements_on_a_finer_mesh_are_those_of_the_program():
    scene = finray.Scene.read(SCENES / "bracketed.toml")
    shape = finray.solve(scene, load=[(8, 0, -1, 5)], mesh_nodes=400)
    assert_same_shape(shape, done("solve", SCENES / "bracketed.toml", "--load", "8:0,-1,5", "--mesh-nodes", 400)[0])


def test_warnings_are_those_of_the_program(paper):
    shape = finray.solve(paper, [(80, 6, -20)])
    said = done("solve", SCENES / "paper.toml", "--load-at", "80:6,-20")[1]
    assert [f"warning: {warning}" for warning in shape.warnings] == said.splitlines()[:-1] != []


@pytest.mark.parametrize(
    "ours, theirs",
    [
        ({"load": [(99, 0, -1)]}, ["--load", "99:0,-1"]),
        ({"load_at": [(500, 1, 0)]}, ["--load-at", "500:1,0"]),
        ({"load_at": [(80, 1, 0)], "mesh_nodes": 3}, ["--load-at", "80:1,0", "--mesh-nodes", 3]),
        ({"load": [(19, -8, -20)]}, ["--load", "19:-8,-20"]),
    ],
)
def test_errors_have_the_messages_of_the_program(paper, ours, theirs):
    with pytest.raises(finray.FinrayError) as error:
        finray.solve(paper, **ours)
    assert str(error.value) == refusal("solve", SCENES / "paper.toml", *theirs).replace("--mesh-nodes", "mesh_nodes")


@pytest.mark.parametrize(
    "load_at",
    [
        [[80, 2, -20]],
        ([80.0, np.float32(2), np.int64(-20)],),
        np.array([[80.0, 2.0, -20.0]]),
        np.array([[80, 2, -20]]),
        [np.array([80.0, 2.0, -20.0])],
        iter([(80, 2, -20)]),
    ],
)
def test_loads_are_sequences_of_numbers(paper, bent, load_at):
    np.testing.assert_array_equal(finray.solve(paper, load_at).displacements, bent.displacements)


def test_loads_on_nodes_are_rows_of_an_array(paper):
    loads = np.array([[19, -0.1, -0.5, 2.0], [12, 0.1, 0.0, 0.0]])
    rows = finray.solve(paper, load=loads)
    tuples = finray.solve(paper, load=[(19, -0.1, -0.5, 2), (12, 0.1, 0)])
    np.testing.assert_array_equal(rows.displacements, tuples.displacements)


@pytest.mark.parametrize(
    "wrong, message",
    [
        ({}, "expected at least one load"),
        ({"load_at": [(80, 1)]}, r"load_at\[0\]: expected numbers \(s_mm, force_n, angle_deg\), found \(80, 1\)"),
        ({"load_at": (80, 2, -20)}, r"load_at\[0\]: expected numbers \(s_mm, force_n, angle_deg\), found 80"),
        ({"load_at": 80}, r"load_at: expected a list of numbers \(s_mm, force_n, angle_deg\), found 80"),
        ({"load_at": [(80, 1, 0), ("80", 1, 0)]}, r"load_at\[1\]: .* found \('80', 1, 0\)"),
        ({"load_at": [b"abc"]}, r"load_at\[0\]: .* found b'abc'"),
        ({"load_at": np.zeros((1, 4))}, r"load_at\[0\]: .* found float64 of shape \(4,\)"),
        ({"load_at": np.ma.array([[80.0, 1, 0]], mask=[[0, 1, 0]])}, r"load_at\[0\]: expected numbers"),
        ({"load": [("19", 0, 1)]}, r"load\[0\]: expected numbers \(node, fx_n, fy_n\) or .* found \('19', 0, 1\)"),
        ({"load": [(-1, 0, 1)]}, r"load\[0\]: expected numbers"),
        ({"load": [(1.5, 0, 1)]}, r"load\[0\]: expected numbers"),
        ({"load": [(True, 0, 1)]}, r"load\[0\]: expected numbers"),
        ({"load_at": [(80, float("nan"), 0)]}, "finite loads"),
        ({"load_at": [(float("nan"), 1, 0)]}, "is not on the front plate"),
        ({"load_at": [(80, 1, 0)], "kinematics": "cubic"}, "kinematics: unknown variant"),
    ],
)
def test_wrong_arguments_are_errors(paper, wrong, message):
    with pytest.raises(finray.FinrayError, match=message):
        finray.solve(paper, **wrong)


def test_a_scene_warns_of_unstated_side_faces(tmp_path):
    text = (SCENES.parent / "calculix" / "paper.toml").read_text()
    assert finray.Scene.parse(text).warnings == []
    path = tmp_path / "unstated.toml"
    path.write_text(text.replace('side_faces = "fixed"\n', ""))
    [warning] = finray.Scene.read(path).warnings
    said = done("solve", path, "--load-at", "80:0.5,-20")[1]
    assert f"warning: {path}: {warning}" in said.splitlines()
