"""Writes the type stubs of the package from its module: make_stubs.py > python/inhabit/__init__.pyi.

python/tests/stubs_test.py compares what is in the tree with what this makes.
"""

import inspect
import re

import inhabit
from inhabit import _core

HEAD = '''# Made by python/tools/make_stubs.py from the module.
import os
import pathlib
from typing import Any, Callable, Dict, Iterator, List, Optional, Protocol, Sequence, Tuple, Union

import numpy

class SupportsDLPack(Protocol):
    def __dlpack__(self) -> Any: ...
    def __dlpack_device__(self) -> Any: ...

Array = Union[numpy.ndarray, SupportsDLPack, Sequence[Any], float]
PathLike = Union[str, "os.PathLike[str]"]
__version__: str
'''


def parts(text):
    """The arguments of a signature, at commas outside of brackets and quotes."""
    depth, quoted, out = 0, False, [""]
    for c in text:
        quoted ^= c == "'"
        if not quoted:
            depth += (c in "([{<") - (c in ")]}>")
            if c == "," and depth == 0:
                out.append("")
                continue
        out[-1] += c
    return [part.strip() for part in out if part.strip()]


def type_of(text, given):
    text = text.replace("inhabit._core.", "").replace("inhabit.", "")
    text = re.sub(r"List\[(\w+)\[\d+\]\]", r"List[\1]", text)
    text = re.sub(r"numpy\.ndarray(\[\w+\])?", "Array" if given else "numpy.ndarray", text)
    text = text.replace("os.PathLike", "PathLike" if given else "pathlib.Path")
    text = re.sub(r"\b(object|handle)\b", "Any", text)
    text = re.sub(r"\b(dict|function)\b", lambda m: {"dict": "Dict[str, Any]", "function": "Callable[..., Any]"}[m[0]], text)
    return text.replace("List[", "Sequence[") if given else text


def result_of(result, text):
    """A result's type, where the text beside it says more than the signature: None now and then, a class of Python's."""
    if result == "numpy.ndarray" and re.search(r"\bor\s+None\b|\bNone\s+(where|unless)\b", text):
        return "Optional[numpy.ndarray]"
    made = re.search(r"\bReturns\s+the\s+([A-Z]\w+)(,\s+or\s+None\b|\s+\(None\b)?", text)
    if made and re.match(r"(Any$|Tuple\[Any,)", result):
        return result.replace("Any", f"Optional[{made[1]}]" if made[2] else made[1], 1)
    return result


def signature(doc):
    """'(a: int = 1) -> str' of a docstring's first line, as stubs have it."""
    line, _, text = doc.strip().partition("\n")
    arguments, result = line[line.index("(") :].rsplit(" -> ", 1)
    out = []
    for part in parts(arguments.strip()[1:-1]):
        name, colon, rest = part.partition(":")
        if not colon or name.startswith("*"):
            out.append({"*args": "*things: Any", "**kwargs": "**options: Any"}.get(name.strip(), part))
        elif name == "self":
            out.append("self")
        else:
            kind, _, default = rest.strip().partition(" = ")
            kind = type_of(kind, True)
            if default == "None" and not kind.startswith(("Optional", "Any")):  # a pointer
                kind = f"Optional[{kind}]"
            out.append(f"{name}: {kind}" + (" = ..." if default else ""))
    return ", ".join(out), result_of(type_of(result, False), text)


def is_property(member):
    return isinstance(member, property)


def class_stub(kind):
    lines = []
    for name, member in sorted(vars(kind).items()):
        if name.startswith("_") and name not in ("__init__", "__len__", "__getitem__", "__enter__", "__exit__", "_repr_html_"):
            continue
        if is_property(member):
            result = result_of(signature(member.fget.__doc__)[1], member.__doc__)
            lines += ["    @property", f"    def {name}(self) -> {result}: ..."]
            if member.fset is not None:
                given = signature(member.fset.__doc__)[0].split(": ")[-1]
                lines += [f"    @{name}.setter", f"    def {name}(self, value: {given}) -> None: ..."]
        elif callable(member):
            if name == "__init__" and "(self: " not in (member.__doc__ or ""):
                continue
            arguments, result = signature(member.__doc__)
            arguments = re.sub(r"\barg0\b", "key", arguments)
            lines.append(f"    def {name}({arguments if arguments.startswith('self') else 'self'}) -> {result}: ...")
    return [f"class {kind.__name__}:"] + (lines or ["    ..."])


def stubs():
    lines = [HEAD]
    for name in inhabit.__all__:
        member = getattr(_core, name)
        if inspect.isclass(member) and issubclass(member, Exception):
            lines.append(f"class {name}({member.__bases__[0].__name__}): ...")
        elif inspect.isclass(member):
            lines += class_stub(member)
        else:
            arguments, result = signature(member.__doc__)
            lines.append(f"def {name}({arguments}) -> {result}: ...")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(stubs(), end="")
