"""Compares the type stubs with the module."""

import ast
import inspect
import re

import pytest
from conftest import SOURCE

import haarfield

STUBS = ast.parse((SOURCE / "tools/python/haarfield/__init__.pyi").read_text())


def functions_of(body):
    return {node.name: node for node in body if isinstance(node, ast.FunctionDef)}


def arguments_of(node):
    """Returns the names and defaults of arguments in a stub."""
    arguments = node.args.args + node.args.kwonlyargs
    defaults = [None] * (len(node.args.args) - len(node.args.defaults)) + node.args.defaults + node.args.kw_defaults
    return [
        (argument.arg, None if default is None else ast.literal_eval(default))
        for argument, default in zip(arguments, defaults)
    ]


def signature_of(function):
    """Returns the names and defaults in the first line of pybind11's docstring."""
    line = re.match(r"(?:\w+)\((.*)\) -> ", function.__doc__).group(1)
    names = re.findall(r"(?:^|, )\*{0,2}(\w+): [^=,]*?(?: = (.*?))?(?=, (?:\*, )?\*{0,2}\w+: |$)", line)
    return [(name, ast.literal_eval(default) if default else None) for name, default in names]


def test_everything_public_is_in_the_stubs_and_has_a_docstring():
    classes = {node.name: node for node in STUBS.body if isinstance(node, ast.ClassDef)}
    functions = functions_of(STUBS.body)
    public = {name for name in vars(haarfield) if not name.startswith("_")}
    assert public == set(classes) | set(functions)
    for name in public:
        made = getattr(haarfield, name)
        assert made.__doc__, name
        if not inspect.isclass(made) or issubclass(made, Exception):
            continue
        members = {member for member in vars(made) if not member.startswith("_")}
        inside = functions_of(classes[name].body)
        assert members == {member for member in inside if not member.startswith("_")}, name
        for member in members:
            assert getattr(made, member).__doc__, f"{name}.{member}"


def test_stubs_have_the_arguments_and_defaults_of_the_module():
    checked = 0
    for node in STUBS.body:
        inside = [(haarfield, node)] if isinstance(node, ast.FunctionDef) else []
        if isinstance(node, ast.ClassDef):
            inside = [(getattr(haarfield, node.name), part) for part in functions_of(node.body).values()]
        for owner, part in inside:
            is_property = any(getattr(mark, "id", "") == "property" for mark in part.decorator_list)
            is_overload = any(getattr(mark, "id", "") == "overload" for mark in part.decorator_list)
            if is_property or is_overload or part.name.startswith("__"):
                continue
            said = [pair for pair in signature_of(getattr(owner, part.name)) if pair[0] not in ("self", "args")]
            wanted = [pair for pair in arguments_of(part) if pair[0] != "self"]
            assert [name for name, _ in said] == [name for name, _ in wanted], part.name
            for (name, default), (_, in_stub) in zip(said, wanted):
                if isinstance(default, float):
                    assert abs(default - in_stub) < 1e-6, (part.name, name)
                elif not isinstance(default, str) or not default.startswith("<"):
                    assert default == in_stub, (part.name, name)
            checked += 1
    assert checked > 30


def test_functions_have_their_documented_signatures():
    signature = inspect.signature(haarfield.Scene.bake)
    assert next(iter(signature.parameters)) == "self"
    assert signature.parameters["refine"].kind == inspect.Parameter.KEYWORD_ONLY
    assert signature.parameters["occlusion"].default == "auto"
    assert str(inspect.signature(haarfield.use_threads)) == "(count: 'int') -> 'None'"
    assert "triangles" in inspect.signature(haarfield.Mesh).parameters


def test_messages_about_wrong_arguments_have_one_line(scene):
    for call, trouble in [
        (lambda: scene.bake(refin=0.1), "Scene.bake: got an unexpected keyword argument 'refin'"),
        (lambda: haarfield.use_threads(), "use_threads: missing a required argument: 'count'"),
        (lambda: haarfield.use_threads("two"), r"use_threads: found \(str\); expected \(count: 'int'\)"),
        (lambda: haarfield.Mesh(positions=[]), "Mesh: missing a required argument: 'triangles'"),
    ]:
        with pytest.raises(TypeError, match=trouble) as raised:
            call()
        assert "\n" not in str(raised.value)
