r"""Equations in LaTeX read and computed: a small parser that knows nothing of what wrote them.

Values are floats, vectors (3,), (6,) and matrices. A name is its letter with its index, accents as letters behind it:
`\dot{\omega}_{1}` is wd_1, `\ddot{q}_{2}` qdd_2. `c_{12}` is cos(q_1 + q_2), a name that ends in x, y or z a component.
"""

from __future__ import annotations

import re

import numpy as np

TOKEN = re.compile(r"\\begin\{pmatrix\}|\\end\{pmatrix\}|\\text\{[^}]*\}|\\[A-Za-z]+|\\\\|\d+\.?\d*|\S")
GREEK = {r"\omega": "w", r"\tau": "tau", r"\Gamma": "Gamma", r"\Phi": "Phi"}


def equations(latex):
    """Yield (left, right) of every equation in align* of a text; a row without a left side goes on with the last."""
    for found in re.findall(r"\\begin\{align\*\}\n(.*?)\n\\end\{align\*\}", latex, re.DOTALL):
        left = None
        body = re.sub(r" \\quad \\text\{.*?\}", "", re.sub(r" \\\\\n&\\quad ", " ", found))
        for row in body.split(" \\\\\n"):
            sides = [side.strip() for side in re.split(r" &?= ", re.sub(r"^& \\quad ", "", row))]
            if not row.startswith("&") and sides[0]:
                left = sides[0]
            pairs = [(sides[0] or left, right) for right in sides[1:]]
            assert pairs, row
            yield from pairs


class Names(dict):
    """Values by name; cosines, sines and components come of others."""

    def __missing__(self, name):
        head, _, index = name.partition("_")
        if head in ("c", "s") and index.isdigit():
            angle = sum(self[f"q_{k}"] for k in index)
            return np.cos(angle) if head == "c" else np.sin(angle)
        if name[-1] in "xyz" and name[:-1] in self:
            return self[name[:-1]]["xyz".index(name[-1])]
        raise KeyError(name)


class Dual(np.ndarray):
    """A vector that is transposed."""


class Reader:
    def __init__(self, latex, names):
        self.tokens, self.names, self.k = TOKEN.findall(latex), names, 0

    def value(self):
        found = self.sum()
        assert self.k == len(self.tokens), self.tokens[self.k :]
        return found

    def peek(self):
        return self.tokens[self.k] if self.k < len(self.tokens) else ""

    def take(self, expected=None):
        token = self.peek()
        assert token
        assert expected in (None, token), token
        self.k += 1
        return token

    def sum(self):
        found = None
        while self.peek() in ("+", "-") or found is None:
            sign = -1.0 if self.peek() == "-" else 1.0
            if self.peek() in ("+", "-"):
                self.take()
            one = sign * self.crossed()
            found = one if found is None else self.added(found, one)
        return found

    @staticmethod
    def added(a, b):
        if np.ndim(a) == 2 and np.ndim(b) == 0:
            return a + b * np.eye(len(a))
        if np.ndim(b) == 2 and np.ndim(a) == 0:
            return a * np.eye(len(b)) + b
        assert np.shape(a) == np.shape(b)
        return a + b

    def crossed(self):
        found = self.product()
        while self.peek() == r"\times":
            self.take()
            found = np.cross(found, self.product())
        return found

    def product(self):
        found = None
        while self.peek() not in ("", "+", "-", ")", "]", "}", "&", r"\\", r"\end{pmatrix}", r"\right", r"\times"):
            if self.peek() == r"\cdot":
                self.take()
            one = self.factor()
            if found is None:
                found = one
            elif isinstance(found, Dual) or (np.ndim(found) == 2 and np.ndim(one)):
                found = np.asarray(found) @ one
            else:
                assert not (np.ndim(found) and np.ndim(one))
                found = found * one
        assert found is not None
        return found

    def group(self):
        """The text of an index or power."""
        if self.peek() != "{":
            return self.take()
        self.take("{")
        text = ""
        while self.peek() != "}":
            text += self.take()
        self.take("}")
        return text

    def factor(self):
        token = self.take()
        if token == r"\left":
            self.take("(")
            found = self.sum()
            self.take(r"\right")
            self.take(")")
        elif token == "(":
            found = self.sum()
            self.take(")")
        elif token == "[":
            x, y, z = self.sum()
            self.take("]")
            found = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        elif token == r"\frac":
            found = self.braced()
            found = found / self.braced()
        elif token == r"\begin{pmatrix}":
            found = self.matrix()
        elif token == r"\sum":
            self.take("_")
            self.group()
            return self.summed()
        elif token in (r"\cos", r"\sin"):
            found = getattr(np, token[1:])(self.factor())
        elif token[0].isdigit():
            found = float(token)
        else:
            dots = {r"\dot": "d", r"\ddot": "dd"}.get(token, "")
            if dots:
                self.take("{")
                token = self.take()
                self.take("}")
            name = GREEK.get(token, token) + dots
            if self.peek() == "_":
                self.take()
                name += f"_{self.group()}"
            found = self.names[name]
            return self.raised(found)
        if self.peek() == "_":
            self.take()
            index = self.group()
            found = found["xyz".index(index)] if index in "xyz" else found[int(index) - 1]
        return self.raised(found)

    def summed(self):
        """The sum of what follows over the names of each that is carried, where at least one is."""
        names, start, found = self.names, self.k, 0.0
        for one in names["carried"]:
            self.k, self.names = start, Names(names | one)
            found = found + self.product()
        self.names = names
        return found

    def braced(self):
        self.take("{")
        found = self.sum()
        self.take("}")
        return found

    def raised(self, found):
        if self.peek() != "^":
            return found
        self.take()
        power = self.group()
        if power == "T":
            return found.T if np.ndim(found) == 2 else found.view(Dual)
        return np.linalg.inv(found) if power == "-1" and np.ndim(found) == 2 else found ** int(power)

    def matrix(self):
        rows = [[]]
        while True:
            rows[-1].append(self.sum())
            token = self.take()
            if token == r"\end{pmatrix}":
                break
            if token == r"\\":
                rows.append([])
            else:
                assert token == "&"
        size = max((len(x) for row in rows for x in row if np.ndim(x) == 2), default=0)
        if size:
            return np.block([[x if np.ndim(x) else x * np.eye(size) for x in row] for row in rows])
        found = np.array(rows)
        return found[:, 0] if found.shape[1] == 1 else found
