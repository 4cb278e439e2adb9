"""*PARAMETER and *PARAMETER_EXPRESSION: names for numbers and texts, and a closed grammar of arithmetic.

Names do not distinguish capitals. Expressions are numbers, names, + - * / **, brackets, and the functions below, angles
in radians; everything else is refused. They are read through Python's syntax tree, and only its nodes listed here are
ever computed.
"""

from __future__ import annotations

import ast
import math
import operator
import re

from billow.base.errors import InputError
from billow.decks.block import Block

BAD_PARAMETER = InputError.declare(
    "E-DCK-003",
    "the parameter {name!r} cannot be used",
    where="{place}",
    cause="a misspelt name, one that is defined further below, or an expression beyond plain arithmetic",
    remedy="define it above with *PARAMETER, as a number, or by + - * / ** and functions such as sqrt",
)

LONGEST = 500
_OPERATORS = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv, ast.Pow: math.pow,
    ast.USub: operator.neg, ast.UAdd: operator.pos,
}  # fmt: skip
FUNCTIONS = {
    "abs": abs, "acos": math.acos, "asin": math.asin, "atan": math.atan, "atan2": math.atan2, "cos": math.cos,
    "cosh": math.cosh, "exp": math.exp, "int": math.trunc, "log": math.log, "log10": math.log10, "max": max,
    "min": min, "mod": math.fmod, "nint": round, "sin": math.sin, "sinh": math.sinh, "sqrt": math.sqrt,
    "tan": math.tan, "tanh": math.tanh,
}  # fmt: skip
_FORTRAN = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[eEdD]([+-]?\d+)|([+-]\d+))?")
_OLD_EXPONENT = re.compile(r"(?<=[\d.])[dD](?=[+-]?\d)")


def number(text: str) -> float:
    """Of a field, 0 if it is blank; Fortran's exponents `1.5D+3` and `1.234-5` too. ValueError if it is no finite
    number."""
    text = text.strip(" \t\r\n\v\f")
    if not text:
        return 0.0
    found = _FORTRAN.fullmatch(text)
    if found is None:
        raise ValueError(f"{text[:40]!r} is no number")
    value = float(f"{found[1]}e{found[2] or found[3] or 0}")
    if not math.isfinite(value):
        raise ValueError(f"{text[:40]!r} is too large")
    return value


class Parameters:
    """Values by name, in lower case."""

    def __init__(self):
        self.values: dict[str, float | int | str] = {}

    def take(self, block: Block) -> None:
        """The definitions of a *PARAMETER block. Raises InputError E-DCK-003."""
        if "EXPRESSION" in block.name:
            for place, kind, name, text in _expressions(block):
                self.define(kind, name, text if kind == "C" else self.evaluated(text, name, place), place)
            return
        width = 20 if block.form == "long" else 10
        for line, text in _lines(block):
            cells = text.split(",") if "," in text else [text[k : k + width] for k in range(0, len(text), width)]
            for name, value in zip(cells[::2], cells[1::2], strict=False):
                if name.strip():
                    kind, name = name.strip()[0].upper(), name.strip()[1:].strip()
                    self.define(kind, name, value.strip(), f"{block.file}:{line}")

    def filled(self, text: str, place: str) -> str:
        """A field with `&name` or `-&name` replaced by what it stands for. Raises InputError E-DCK-003."""
        negative, name = text.startswith("-"), text.lstrip("-&").strip().lower()
        if name not in self.values:
            raise BAD_PARAMETER(name=name, place=place, why="it has no value here")
        value = self.values[name]
        if isinstance(value, str):
            return value
        return repr(-value if negative else value)

    def evaluated(self, text: str, name: str, place: str) -> float:
        """The value of an expression. Raises InputError E-DCK-003."""
        try:
            if len(text) > LONGEST:
                raise ValueError(f"its expression is longer than {LONGEST} characters")
            tree = ast.parse(_OLD_EXPONENT.sub("e", text.replace("&", "").strip()), mode="eval")
            value = float(self._value(tree.body))
            if not math.isfinite(value):
                raise ValueError("its value is not finite")
            return value
        except SyntaxError:
            why = f"{text[:60]!r} is no arithmetic"
        except (ArithmeticError, RecursionError, MemoryError, TypeError):
            why = f"{text[:60]!r} has no value"
        except ValueError as error:
            why = str(error)
        raise BAD_PARAMETER(name=name, place=place, why=why)

    def _value(self, node: ast.AST) -> float:
        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
                return float(value)
            case ast.Name(id=name) if isinstance(self.values.get(name.lower()), int | float):
                return float(self.values[name.lower()])
            case ast.Name(id=name):
                raise ValueError(f"it uses {name[:40]!r}, which has no value here")
            case ast.BinOp(op=op) if type(op) in _OPERATORS:
                return _OPERATORS[type(op)](self._value(node.left), self._value(node.right))
            case ast.UnaryOp(op=op) if type(op) in _OPERATORS:
                return _OPERATORS[type(op)](self._value(node.operand))
            case ast.Call(func=ast.Name(id=name), keywords=[]) if name.lower() in FUNCTIONS:
                return FUNCTIONS[name.lower()](*map(self._value, node.args))
        raise ValueError(f"{ast.unparse(node)[:60]!r} is beyond arithmetic")

    def define(self, kind: str, name: str, value: float | str, place: str) -> None:
        """A value by name; kind: R, I or C. Raises InputError E-DCK-003."""
        if kind not in ("R", "I", "C") or not re.fullmatch(r"\w{1,20}", name, re.ASCII):
            raise BAD_PARAMETER(name=f"{kind}{name}"[:40], place=place, why="it begins with none of R, I and C")
        try:
            value = number(value) if isinstance(value, str) and kind != "C" else value
        except ValueError as error:
            raise BAD_PARAMETER(name=name, place=place, why=error) from None
        self.values[name.lower()] = int(value) if kind == "I" else value


def _lines(block: Block):
    return ((line, text.decode("latin-1").rstrip()) for line, text in block.lines() if text.strip())


def _expressions(block: Block):
    """Place, kind, name and text of each definition; a line that begins with blanks goes on with the one before."""
    found: list[list[str]] = []
    for line, text in _lines(block):
        head, tail = text.split(",", 1) if "," in text[:11] else (text[:10], text[10:])
        if not head.strip() and found:
            found[-1][3] += tail
        elif head.strip():
            found.append([f"{block.file}:{line}", head.strip()[0].upper(), head.strip()[1:].strip(), tail])
    return found
