"""The package as a whole: drawings, stubs, docstrings and the guide's examples."""

import ast
import importlib.metadata
import pickle
import re
import subprocess
import sys
import xml.etree.ElementTree
from pathlib import Path

import finray
import numpy as np
import pytest
from conftest import ROOT

STUBS = ast.parse((Path(finray.__file__).parent / "__init__.pyi").read_text())


def test_drawings_are_svg(paper, bent):
    for drawn in (paper, bent):
        root = xml.etree.ElementTree.fromstring(drawn._repr_svg_())
        assert root.tag == "{http://www.w3.org/2000/svg}svg" and len(root) > 10


def test_stubs_have_the_names_of_the_module():
    classes = {node.name: node for node in STUBS.body if isinstance(node, ast.ClassDef)}
    functions = {node.name: node for node in STUBS.body if isinstance(node, ast.FunctionDef)}
    assert {*classes, *functions, "__version__"} == set(finray.__all__)
    for name, node in classes.items():
        if issubclass(getattr(finray, name), Exception):
            continue
        stated = {member.name for member in node.body if isinstance(member, ast.FunctionDef)} - {"__new__"}
        own = {member for member in vars(getattr(finray, name)) if not member.startswith("__")}
        assert stated - {"__len__"} == own, name
        assert ("__len__" in stated) == hasattr(getattr(finray, name), "__len__"), name


def test_stubs_export_the_names_of_the_module():
    exported = [node.value for node in STUBS.body if isinstance(node, ast.Assign) and node.targets[0].id == "__all__"]
    assert [ast.literal_eval(names) for names in exported] == [finray.__all__]


def constructor(name):
    """The constructor of a class in the stubs."""
    node = next(node for node in STUBS.body if isinstance(node, ast.ClassDef) and node.name == name)
    return next(member for member in node.body if isinstance(member, ast.FunctionDef) and member.name == "__new__")


@pytest.mark.parametrize("name", ["Sensor", "StreamSensor", "Locator", "Observation"])
def test_classes_describe_the_arguments_of_their_constructors(name):
    arguments = constructor(name).args
    names = {argument.arg for argument in [*arguments.args[1:], *arguments.kwonlyargs]}
    stub = ast.get_docstring(next(node for node in STUBS.body if getattr(node, "name", "") == name))
    for text in (getattr(finray, name).__doc__, stub):
        described = text.partition("Args:\n")[2].splitlines()
        heads = [line.strip().partition(":")[0] for line in described if re.match(r" {4}\w.*?: ", line)]
        assert {part for head in heads for part in head.split(", ")} == names


@pytest.mark.parametrize("name", ["Scene", "Shape", "Forces", "Alternative", "Press"])
def test_classes_without_a_constructor_have_none_in_the_stubs(name):
    assert [ast.unparse(argument.annotation) for argument in constructor(name).args.args[1:]] == ["_NoValue"]
    with pytest.raises(TypeError, match="No constructor|cannot create"):
        getattr(finray, name)()


TYPED = """
import finray
import finray.live
import numpy as np

scene = finray.Scene.paper()
finray.Sensor(scene, np.array([40.0, 80.0]), contact=np.array([18, 19]))
finray.Sensor(scene, np.array(["40", "80"]), contact=np.int64(19))
finray.StreamSensor(scene, [np.float32(40), "80"], contact=(18, "19@normal"))
finray.solve(scene, [[80.0, 2.0, -20.0]])
finray.solve(scene, np.array([[80.0, 2.0, -20.0]]), load=[(19, 0.0, 1.0), (18, 0, 1, 2)])
finray.solve(scene, [np.array([80.0, 2.0, -20.0])])
seen = finray.Observation([19], [[0, 0]])
for line in finray.live.lines(finray.StreamSensor(scene, "80"), finray.live.camera(0, size_px=scene.camera_size_px)):
    print(line.upper())
for line in finray.live.lines(finray.StreamSensor(scene, "80"), [seen, (seen, 0.1, 0), "damaged"]):
    print(line.upper())
code: int = finray.live.main(["--help"])
"""

MISTYPED = """
import finray

finray.Scene()
finray.Scene("scene.toml")
finray.Forces()
finray.Sensor(finray.Scene.paper(), {40: 1})
finray.Sensor(finray.Scene.paper(), contact=[None])
finray.solve(finray.Scene.paper(), 80)
finray.solve(finray.Scene.paper(), [("80", 2, -20)])
"""


def test_programs_are_typed(tmp_path):
    """mypy accepts a program that uses the package, reports each line of a program with wrong types, and compares the stubs with the module."""
    pytest.importorskip("mypy")
    (tmp_path / "typed.py").write_text(TYPED)
    (tmp_path / "mistyped.py").write_text(MISTYPED)

    def checked(*words):
        answer = subprocess.run([sys.executable, "-m", *words], cwd=tmp_path, capture_output=True, text=True, check=False)
        return answer.returncode, answer.stdout + answer.stderr

    for accepted in (["typed.py"], ["-p", "finray"]):
        code, said = checked("mypy", "--strict", *accepted)
        assert code == 0, said
    code, said = checked("mypy", "--strict", "mistyped.py")
    lines = {int(line) for line in re.findall(r"mistyped.py:(\d+): error", said)}
    assert lines == set(range(4, len(MISTYPED.splitlines()) + 1)), said
    code, said = checked("mypy.stubtest", "finray", "--ignore-missing-stub")
    assert code == 0, said


def test_the_licences_are_installed():
    names = {Path(str(path)).name: path for path in importlib.metadata.files("finray")}
    for licence in ("LICENSE-APACHE", "LICENSE-MIT"):
        assert names[licence].read_text() == (ROOT / licence).read_text()


def test_stubs_have_the_parameters_of_the_module():
    def parameters(text):
        return [part.split("=")[0].strip() for part in text.strip("()").split(",") if part.strip() not in ("", "$self")]

    def stated(node):
        own = [argument.arg for argument in node.args.args if argument.arg not in ("self", "cls")]
        return own + (["*"] if node.args.kwonlyargs else []) + [argument.arg for argument in node.args.kwonlyargs]

    compared = 0
    for node in STUBS.body:
        if isinstance(node, ast.FunctionDef):
            assert parameters(getattr(finray, node.name).__text_signature__) == stated(node)
            compared += 1
        for member in getattr(node, "body", []) if isinstance(node, ast.ClassDef) else []:
            if not isinstance(member, ast.FunctionDef) or member.decorator_list or member.name.startswith("_") and member.name != "__new__":
                continue
            owner = getattr(finray, node.name)
            if member.name == "__new__" and ast.unparse(member.args).endswith("_NoValue"):
                continue
            text = owner.__text_signature__ if member.name == "__new__" else getattr(owner, member.name).__text_signature__
            # In Python 3.9, a class that is built for the stable ABI has no text signature.
            if member.name != "__new__" or sys.version_info >= (3, 10):
                assert parameters(text) == stated(member), (node.name, member.name)
                compared += 1
    assert compared >= (11 if sys.version_info >= (3, 10) else 7)


def test_everything_has_a_docstring():
    for name in finray.__all__:
        value = getattr(finray, name)
        if isinstance(value, type) and not issubclass(value, Exception):
            members = [member for key, member in vars(value).items() if not key.startswith("_")]
            assert all(member.__doc__ for member in members), name
        assert value.__doc__, name


def test_key_nodes_are_an_array(paper):
    assert paper.key_nodes.shape == (25, 2) and paper.key_nodes.dtype == np.float64
    assert paper.marked_nodes.dtype == np.int64 and 0 < paper.front_length_mm < 1000
    assert "paper" in repr(paper)


def test_a_scene_states_the_size_of_its_camera(paper, camera):
    assert (paper.camera_size_px, camera.camera_size_px) == (None, (1600, 1400))


def test_a_scene_is_read_from_standard_input(paper):
    program = "import finray; print(finray.Scene.read('-').name)"
    text = (ROOT / "fixtures" / "scenes" / "paper.toml").read_text()
    answer = subprocess.run([sys.executable, "-c", program], input=text, capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == paper.name


def test_objects_cannot_be_pickled(paper):
    with pytest.raises(TypeError, match="pickle"):
        pickle.dumps(paper)


def test_values_are_not_shared_with_their_owner(bent):
    bent.displacements[:] = 0
    assert np.abs(bent.displacements).max() > 10


def blocks(path):
    return re.findall(r"\n```python\n(.*?)\n```", path.read_text(), re.DOTALL)


@pytest.mark.parametrize("page", ["verify/guide/python.md", "model/python/README.md"])
def test_examples_run(page, monkeypatch, capsys):
    """Lines of an example that are comments `# text` after `print` state the output; `...` stands for further digits."""
    monkeypatch.chdir(ROOT)
    examples = blocks(ROOT / page)
    assert examples
    names = {}
    for example in examples:
        exec(compile(example, page, "exec"), names)
        printed = capsys.readouterr().out.splitlines()
        stated = [line.partition("  # ")[2] for line in example.splitlines() if line.startswith("print(")]
        assert len(printed) == len(stated), (example, printed)
        for said, found in zip(stated, printed):
            pattern = ".*".join(re.escape(part) for part in said.split("..."))
            assert re.fullmatch(pattern, found), (said, found)
