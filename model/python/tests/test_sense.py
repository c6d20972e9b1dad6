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
    assert_same(forces.interval_n, np.column_stack([printed["low_n"], printed["high_n"]]))


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
    message = refusal("sense", SCENES / "paper.toml", "--displacements", path, *theirs)
    assert str(error.value) == message.replace("--friction", "friction")


@pytest.mark.parametrize("contact_at", [[40, "80"], ("40", 80.0), np.array([40, 80]), np.array(["40", "80"]), [np.float32(40), np.int64(80)]])
def test_contacts_are_numbers_or_texts(paper, displaced, contact_at):
    expected = finray.Sensor(paper, ["40", "80"]).sense(displaced[1])
    np.testing.assert_array_equal(finray.Sensor(paper, contact_at).sense(displaced[1]).force_n, expected.force_n)


def test_forces_have_the_order_of_the_contacts(paper, displaced):
    forces = finray.Sensor(paper, [90, 40], contact=[20, "18@-20"]).sense(displaced[1])
    assert forces.contacts == ["at", "at", "20", "18"]
    assert forces.s_mm[:2].tolist() == [90, 40]


@pytest.mark.parametrize(
    "wrong, found",
    [
        (b"80", r": .* found b'80'"),
        (bytearray(b"80"), r": .* found bytearray\(b'80'\)"),
        (True, ": .* found True"),
        (np.bool_(True), ": .* found .*True.*"),
        ({80}, r": expected a number, a text or a sequence of them, found \{80\}"),
        ({80: 1}, r": .* found \{80: 1\}"),
        (80 + 1j, r": .* found \(80\+1j\)"),
        ([None], r"\[0\]: expected a number or a text, found None"),
        (["80", False], r"\[1\]: .* found False"),
        ([["80"]], r"\[0\]: .* found \['80'\]"),
        (np.array([[40, 80]]), r"\[0\]: .* found int64 of shape \(2,\)"),
        (np.ma.array([40.0, 80.0], mask=[0, 1]), r"\[1\]: .* found .*"),
    ],
)
@pytest.mark.parametrize("name", ["contact_at", "contact"])
@pytest.mark.parametrize("sensor", [finray.Sensor, finray.StreamSensor])
def test_other_contacts_are_errors_of_one_line(paper, sensor, name, wrong, found):
    with pytest.raises(finray.FinrayError, match=f"^{name}{found}$") as error:
        sensor(paper, **{name: wrong})
    assert "\n" not in str(error.value)


def test_a_wrong_mesh_is_an_error_with_the_name_of_the_argument(paper, displaced):
    with pytest.raises(finray.FinrayError, match="^mesh_nodes: ") as error:
        finray.Sensor(paper, 80, mesh_nodes=3).sense(displaced[1])
    theirs = refusal("sense", SCENES / "paper.toml", "--displacements", displaced[0], "--contact-at", 80, "--mesh-nodes", 3)
    assert str(error.value) == theirs.replace("--mesh-nodes", "mesh_nodes")


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
CYCLE: list = []
CYCLE.append(CYCLE)


@pytest.mark.parametrize(
    "wrong, message",
    [
        (([19, 18], [0.1, 0.2]), r"displacements: expected numbers of shape \(2, 2\), found float64 of shape \(2,\)$"),
        (([19, 18], np.zeros((3, 2))), r"expected numbers of shape \(2, 2\), found float64 of shape \(3, 2\)$"),
        (([19, 18], [[0.1, 0.2], [0.3]]), r"expected numbers of shape \(2, 2\), found (\[\[0.1, 0.2\], \[0.3\]\]|object of shape \(2,\))$"),
        (([19, 18], [["a", "b"], ["c", "d"]]), "displacements: expected numbers"),
        (([19, 18], [["0.1", "0.2"], ["0.3", "0.4"]]), "displacements: expected numbers"),
        (([19, 18], np.zeros((2, 2), "datetime64[s]")), r"displacements: .* found datetime64\[s\] of shape \(2, 2\)$"),
        (([19, 18], np.zeros((2, 2), complex)), "displacements: expected numbers"),
        (([19, 18], np.zeros((2, 2), bool)), "displacements: expected numbers"),
        (([19, 18], CYCLE), r"displacements: expected numbers"),
        (([19, 18], {1, 2}), r"displacements: .* found \{1, 2\}$"),
        ((np.array([1.5, 2.5]), U), "nodes: expected the numbers of nodes"),
        (([-1, 2], U), r"nodes\[0\]: expected the number of a node, found -1$"),
        (([2, 2**63], U), "nodes"),
        ((np.array([2, 2**63], np.uint64), U), r"nodes\[1\]: expected the number of a node, found 9223372036854775808$"),
        (([2**64, 2], U), "nodes: expected the numbers of nodes"),
        (([True, False], U), "nodes: expected the numbers of nodes"),
        ((b"ab", U), "nodes: expected the numbers of nodes"),
        ((19, U), "nodes: expected the numbers of nodes, .* found 19$"),
        (([[19, 18]], U), r"nodes: expected the numbers of nodes, .* found int64 of shape \(1, 2\)$"),
        (([19, 18],), "expected displacements or positions"),
        (([19, 18], U, [0.1, 0.1, 0.1]), r"sigma_mm: expected one number or numbers of shape \(2,\), found float64 of shape \(3,\)$"),
        (([19, 18], U, "0.1"), "sigma_mm: expected one number"),
        (([19, 18], U, 0), "sigma_mm: expected a length in mm above zero, found 0$"),
        (([19, 18], U, [0.1, -1]), r"sigma_mm\[1\]: expected a length in mm above zero, found -1$"),
        (([19, 18], U, float("nan")), "sigma_mm: expected a length in mm above zero, found NaN$"),
        ((np.ma.array([19, 18], mask=[0, 1]), U), "^nodes: the array is masked: leave out hidden markers$"),
        (([19, 18], np.ma.array(U, mask=[[0, 0], [1, 1]])), "^displacements: the array is masked: leave out hidden markers$"),
        (([19, 18], [*np.ma.array(U, mask=[[0, 0], [1, 1]])]), "^displacements: the array is masked"),
        (([19, 18], U, np.ma.array([0.1, 0.1], mask=[0, 1])), "^sigma_mm: the array is masked"),
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
        (finray.Observation([], np.zeros((0, 2))), "."),
        (finray.Observation([], []), "."),
    ],
)
def test_observations_of_another_finger_are_errors(paper, observation, message):
    with pytest.raises(finray.FinrayError, match=message):
        finray.Sensor(paper, 80, noise_mm=0.05).sense(observation)


@pytest.mark.parametrize("nodes", [[19, 18], (19, 18), np.array([19, 18], np.uint64), np.array([19, 18], np.int8), [2**63 - 1, 0], []])
def test_nodes_are_those_that_were_given(nodes):
    for displacements in (np.zeros((len(nodes), 2)), np.zeros((len(nodes), 2), np.float32), [[0, 0]] * len(nodes)):
        seen = finray.Observation(nodes, displacements, sigma_mm=[0.1] * len(nodes))
        assert seen.nodes.tolist() == list(nodes) and seen.nodes.dtype == np.int64
        assert seen.displacements.shape == (len(nodes), 2) and len(seen) == len(seen.sigma_mm) == len(nodes)


def test_masked_arrays_without_masked_entries_are_arrays():
    seen = finray.Observation([19, 18], np.ma.array(U, mask=False), positions=np.asfortranarray(U))
    np.testing.assert_array_equal(seen.displacements, U)
    np.testing.assert_array_equal(seen.positions, U)


def test_alternatives_are_those_of_the_program(paper, displaced):
    path, observation = displaced
    out, _, _ = run("sense", SCENES / "paper.toml", "--displacements", path, "--contact-at", "auto@-20", "--alternatives")
    printed = table(out)
    [answer] = finray.Sensor(paper, "auto@-20").alternatives(observation)
    low_n, high_n = answer.interval_n
    ours = [answer.contact + 1, answer.s_mm, answer.angle_deg, answer.force_n, low_n, high_n, *answer.s_interval_mm]
    names = ["contact", "s_mm", "angle_deg", "force_n", "low_n", "high_n", "s_low_mm", "s_high_mm"]
    for value, name in zip(ours, names):
        assert_same(np.array([value]), printed[name])
