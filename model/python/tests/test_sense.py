"""Forces from displacements."""

import finray
import numpy as np
import pytest
from conftest import SCENES, assert_same, refusal, run, table


@pytest.fixture(scope="module")
def displaced(bent, tmp_path_factory):
    """Displacements with noise, as a table and as an observation."""
    noise = np.random.default_rng(1).normal(0, 0.03, bent.displacements.shape)
    moved = bent.displacements + noise
    rows = [f"{node},{float(x)!r},{float(y)!r}" for node, (x, y) in zip(bent.nodes, moved)]
    path = tmp_path_factory.mktemp("sense") / "moved.csv"
    path.write_text("\n".join(["node,ux_mm,uy_mm", *rows, ""]))
    return path, finray.Observation(bent.nodes, moved)


def assert_same_forces(forces, out, said):
    printed = table(out)
    names = [str(name) if isinstance(name, str) else f"{name:.0f}" for name in printed["contact"]]
    assert forces.contacts == names
    for ours, column in [("s_mm", "s_mm"), ("angle_deg", "angle_deg"), ("force_n", "force_n"), ("sigma_n", "sigma_n")]:
        assert_same(getattr(forces, ours), printed[column])
    warnings = [line.partition(": ")[2] for line in said.splitlines() if line.startswith("warning: ")]
    assert forces.warnings == warnings
    assert_same(forces.interval_n[:, 0], printed["force_n"] - 1.96 * printed["sigma_n"])


@pytest.mark.parametrize(
    "ours, theirs",
    [
        ({"contact_at": "auto@-20"}, ["--contact-at", "auto@-20"]),
        ({"contact_at": "80@auto"}, ["--contact-at", "80@auto"]),
        ({"contact_at": ["60@-20", 90], "noise_mm": 0.3}, ["--contact-at", "60@-20", "90", "--noise-mm", 0.3]),
        ({"contact": 19, "noise_mm": 0.05}, ["--contact", "19", "--noise-mm", 0.05]),
        ({"contact": "18@-20", "mesh_nodes": 133}, ["--contact", "18@-20", "--mesh-nodes", 133]),
        ({"contact": "18@-20", "estimator": "least-squares"}, ["--contact", "18@-20", "--estimator", "least-squares"]),
        ({"contact": "18@-20", "estimator": "network"}, ["--contact", "18@-20", "--estimator", "network"]),
        (
            {"contact_at": "80+-1@-20+-2", "noise_mm": 0.05, "friction": 0.2},
            ["--contact-at", "80+-1@-20+-2", "--noise-mm", 0.05, "--friction", 0.2],
        ),
    ],
)
def test_forces_are_those_of_the_program(paper, displaced, ours, theirs):
    path, observation = displaced
    out, said, code = run("sense", SCENES / "paper.toml", "--displacements", path, *theirs)
    if code == 0:
        assert_same_forces(finray.Sensor(paper, **ours).sense(observation), out, said)
        return
    # If the program refuses the request, the Python module refuses it with the same message.
    with pytest.raises(finray.FinrayError) as error:
        finray.Sensor(paper, **ours).sense(observation)
    assert str(error.value) == said.partition("error: ")[2].strip()


@pytest.mark.parametrize(
    "ours, theirs",
    [
        ({"contact_at": "auto@object"}, ["--contact-at", "auto@object"]),
        ({"contact_at": "500@0"}, ["--contact-at", "500@0"]),
        ({"contact": 99}, ["--contact", "99"]),
        ({"contact_at": ["80+-1@0", "90"]}, ["--contact-at", "80+-1@0", "90"]),
        ({"contact_at": "80", "friction": 0.3}, ["--contact-at", "80", "--friction", 0.3]),
        ({}, []),
    ],
)
def test_wrong_contacts_have_the_messages_of_the_program(paper, displaced, ours, theirs):
    path, observation = displaced
    with pytest.raises(finray.FinrayError) as error:
        finray.Sensor(paper, **ours).sense(observation)
    assert str(error.value) == refusal("sense", SCENES / "paper.toml", "--displacements", path, *theirs)


def test_forces_that_are_not_identifiable_are_refused_as_by_the_program(paper, bent, tmp_path):
    path = tmp_path / "one.csv"
    x, y = bent.displacements[18].tolist()
    path.write_text(f"node,ux_mm,uy_mm\n19,{x!r},{y!r}\n")
    contacts = ["50@auto", "90@auto"]
    with pytest.raises(finray.Refused) as error:
        finray.Sensor(paper, contacts, noise_mm=0.05).sense(finray.Observation([19], bent.displacements[18:19]))
    command = ["sense", SCENES / "paper.toml", "--displacements", path, "--noise-mm", 0.05, "--contact-at", *contacts]
    assert str(error.value) == refusal(*command)


@pytest.mark.parametrize(
    "wrong, message",
    [
        ({"contact_at": "80@-400"}, "contact_at: expected an angle from -360 to 360 degrees, found -400"),
        ({"contact_at": "eighty"}, 'contact_at: expected a finite number, found "eighty"'),
        ({"contact": 19.5}, "contact: expected the number of a node"),
        ({"contact_at": 80, "noise_mm": -1}, "noise_mm: expected zero or more, found -1"),
        ({"contact_at": 80, "noise_mm": float("nan")}, "noise_mm: expected a finite number"),
        ({"contact_at": 80, "estimator": "exact"}, "estimator: expected one of"),
        ({"contact_at": 80, "network": "none"}, "network: expected only with the estimator"),
        ({"contact_at": 80, "network": "none", "estimator": "network"}, "none: cannot be read"),
    ],
)
def test_wrong_options_are_errors(paper, wrong, message):
    with pytest.raises(finray.FinrayError, match=message):
        finray.Sensor(paper, **wrong)


U = [[0.1, -0.2], [0.2, -0.3]]


@pytest.mark.parametrize(
    "wrong, message",
    [
        (([19, 18], [0.1, 0.2]), r"displacements: expected numbers of shape \(2, 2\), found"),
        (([19, 18], np.zeros((3, 2))), r"expected numbers of shape \(2, 2\), found float64 of shape \[3, 2\]"),
        (([19, 18], [["a", "b"], ["c", "d"]]), "displacements: expected numbers"),
        ((np.array([1.5, 2.5]), U), "nodes: expected the numbers of nodes"),
        (([-1, 2], U), "nodes: expected the numbers of nodes"),
        ((19, U), "nodes: expected the numbers of nodes"),
        (([19, 18],), "expected displacements or positions"),
        (([19, 18], U, [0.1, 0.1, 0.1]), "sigma_mm: expected one number or numbers"),
    ],
)
def test_wrong_arrays_are_errors(wrong, message):
    arguments, sigma = wrong[:2], wrong[2] if len(wrong) > 2 else None
    with pytest.raises(finray.FinrayError, match=message):
        finray.Observation(*arguments, sigma_mm=sigma)


@pytest.mark.parametrize(
    "observation, message",
    [
        (finray.Observation([19, 99], U), "node 99 does not exist: the finger has nodes 1 to 25"),
        (finray.Observation([19, 0], U), "node 0 does not exist"),
        (finray.Observation([19, 19], U), "node 19 is listed twice"),
        (finray.Observation([19, 18], [[0.1, float("nan")], U[1]]), "expected finite displacements"),
        (finray.Observation([19, 18], U, sigma_mm=0), "expected a length in mm above zero, found 0"),
        (finray.Observation([], np.zeros((0, 2))), "."),
    ],
)
def test_observations_of_another_finger_are_errors(paper, observation, message):
    with pytest.raises(finray.FinrayError, match=message):
        finray.Sensor(paper, 80, noise_mm=0.05).sense(observation)
