"""Adds signatures to the functions of the extension module, and short messages for wrong arguments.

pybind11 describes a function by the first line of its docstring only. inspect.signature cannot read that line, and the
TypeError for a mistyped keyword lists every argument's C++ type and value.
"""

import ast
import functools
import inspect
import re

_KINDS = inspect.Parameter


def _default(node):
    return _KINDS.empty if node is None else ast.literal_eval(node)


def _annotation(node):
    if node is None:
        return _KINDS.empty
    return ast.unparse(node).replace("haarfield._haarfield.", "haarfield.")


def _signature(function):
    """Returns the signature in a pybind11 docstring; None if it has none, such as for an overloaded function."""
    lines = (function.__doc__ or "").splitlines()
    if not lines or " -> " not in lines[0] or lines[1:2] == ["Overloaded function."]:
        return None
    try:
        made = ast.parse(f"def {lines[0]}: ...").body[0]
        positional = made.args.posonlyargs + made.args.args
        defaults = [None] * (len(positional) - len(made.args.defaults)) + made.args.defaults
        parameters = [
            _KINDS(argument.arg, _KINDS.POSITIONAL_OR_KEYWORD, default=_default(default), annotation=_annotation(argument.annotation))
            for argument, default in zip(positional, defaults)
        ]
        if made.args.vararg:
            parameters.append(_KINDS(made.args.vararg.arg, _KINDS.VAR_POSITIONAL))
        for argument, default in zip(made.args.kwonlyargs, made.args.kw_defaults):
            parameters.append(
                _KINDS(argument.arg, _KINDS.KEYWORD_ONLY, default=_default(default), annotation=_annotation(argument.annotation))
            )
        if made.args.kwarg:
            parameters.append(_KINDS(made.args.kwarg.arg, _KINDS.VAR_KEYWORD))
        return inspect.Signature(parameters, return_annotation=_annotation(made.returns))
    except (SyntaxError, ValueError):
        return None


def _names_of(values):
    return ", ".join(type(value).__name__ for value in values)


def _with_signature(function, name):
    signature = _signature(function)
    if signature is None:
        return None
    is_method = next(iter(signature.parameters), None) == "self"

    @functools.wraps(function)
    def call(*arguments, **keywords):
        try:
            return function(*arguments, **keywords)
        except TypeError as error:
            if not re.search("incompatible (function|constructor) arguments", str(error)):
                raise
            try:
                signature.bind(*arguments, **keywords)
                given = _names_of(arguments[is_method:])
                given += ", " * bool(given and keywords) + ", ".join(
                    f"{key}: {type(value).__name__}" for key, value in keywords.items()
                )
                trouble = f"found ({given}); expected {signature}"
            except TypeError as mismatch:
                trouble = str(mismatch)
        raise TypeError(f"{name}: {trouble}")

    call.__signature__ = signature
    return call


def add_signatures(module):
    """Replaces the functions and methods in a module's namespace by ones with signatures."""
    for name, member in list(module.items()):
        if name.startswith("_"):
            continue
        if inspect.isclass(member) and not issubclass(member, Exception):
            for method, function in list(vars(member).items()):
                is_public = not method.startswith("_") or method == "__init__"
                if not is_public or isinstance(function, property):
                    continue
                made = _with_signature(function, f"{name}.{method}" if method != "__init__" else name)
                if made:
                    setattr(member, method, made)
        elif inspect.isbuiltin(member):
            made = _with_signature(member, name)
            if made:
                module[name] = made
