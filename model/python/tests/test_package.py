"""The package as a whole: drawings, stubs, docstrings and the guide's examples."""

import ast
import re
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
