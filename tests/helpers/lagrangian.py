"""Equations of motion by Lagrange's equations (those of Kirchhoff and Boltzmann for a base that moves), from a URDF
whose numbers are replaced by letters here: homogeneous matrices and energies, none of the product's recursions."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import sympy

AXES = "xyz"
PLACES = [(a, b) for a in range(3) for b in range(a, 3)]


def numbers(element, name, count):
    return [float(x) for x in element.get(name).split()] if element is not None and element.get(name) else [0.0] * count


def symbols(names):
    return [sympy.Symbol(name, real=True) for name in names]


def letters_of(stem, values, alone=False):
    """A vector in letters: none for a zero; one number needs no axis, if `alone`; minus before a negative length."""
    some = [k for k in range(3) if values[k]]
    names = [stem if alone and len(some) == 1 else stem + axis for axis in AXES]
    lengths = stem.startswith("l")
    return sympy.Matrix(
        [
            sympy.Symbol(names[k], real=True) * (-1 if lengths and values[k] < 0 else 1) if k in some else 0
            for k in range(3)
        ]
    )


def inertia_of(i, values):
    """Entries that are equal on the diagonal share a letter, as those off it do not."""
    given = dict(zip(PLACES, values, strict=True))
    I = sympy.zeros(3)
    for (a, b), value in given.items():
        first = next(c for c in range(3) if given[c, c] == value) if a == b else None
        name = f"I_{i}{AXES[first] * 2}" if a == b else f"I_{i}{AXES[a]}{AXES[b]}"
        I[a, b] = I[b, a] = sympy.Symbol(name, real=True) if value else 0
    return I


def skew(v):
    return sympy.Matrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def turn(axis, angle):
    """Rodrigues' formula."""
    K = skew(axis)
    return sympy.eye(3) + sympy.sin(angle) * K + (1 - sympy.cos(angle)) * K * K


class Lagrangian:
    """M, gravity and coriolis (lists of SymPy expressions) of a robot whose links are bodies with axes along its own,
    those that carry nothing and weigh nothing left out; `alike` are letters that stand for others, as for twins."""

    def __init__(self, path, moving=False, alike=None, gravity=True):
        root = ET.parse(path).getroot()
        joints = [joint for joint in root.findall("joint") if joint.get("type") != "fixed"]
        names = [root.find("link").get("name"), *(joint.find("child").get("link") for joint in joints)]
        inertials = {link.get("name"): link.find("inertial") for link in root.findall("link")}
        n = len(joints)
        q, qd = symbols(f"q_{i}" for i in range(1, n + 1)), symbols(f"qd_{i}" for i in range(1, n + 1))
        w, v = sympy.Matrix(symbols(f"w_{a}" for a in AXES)), sympy.Matrix(symbols(f"v_{a}" for a in AXES))
        w, v = (w, v) if moving else (sympy.zeros(3, 1), sympy.zeros(3, 1))
        u = [*w, *v, *qd] if moving else qd
        g = (
            sympy.Matrix(symbols(f"g_{a}" for a in AXES))
            if moving
            else sympy.Matrix([0, 0, -sympy.Symbol("g", real=True)])
        )
        frames = {names[0]: (sympy.eye(3), sympy.zeros(3, 1))}
        T, power = 0, 0
        for i, name in enumerate(names):
            if i:
                joint = joints[i - 1]
                parent = joint.find("parent").get("link")
                R, p = frames[parent]
                axis = sympy.Matrix([sympy.nsimplify(x) for x in numbers(joint.find("axis"), "xyz", 3)])
                offset = numbers(joint.find("origin"), "xyz", 3)
                j = names.index(parent)
                p = p + R * (
                    letters_of(f"l_{j}", offset, True)
                    if j or moving
                    else sympy.Matrix([sympy.nsimplify(x) for x in offset])
                )
                slides = joint.get("type") == "prismatic"
                frames[name] = (R, p + R * axis * q[i - 1]) if slides else (R * turn(axis, q[i - 1]), p)
            inertial = inertials[name]
            if inertial is None or (i == 0 and not moving):
                continue
            m = sympy.Symbol(f"m_{i}", real=True)
            R, p = frames[name]
            c = p + R * letters_of(f"c_{i}", numbers(inertial.find("origin"), "xyz", 3))
            entries = [float(inertial.find("inertia").get(f"i{AXES[a]}{AXES[b]}")) for a, b in PLACES]
            I = R * inertia_of(i, entries) * R.T
            relative = sum((R.diff(x) * R.T * xd for x, xd in zip(q, qd, strict=True)), sympy.zeros(3))
            omega = w + sympy.Matrix([relative[2, 1], relative[0, 2], relative[1, 0]])
            speed = v + w.cross(c) + sum((c.diff(x) * xd for x, xd in zip(q, qd, strict=True)), sympy.zeros(3, 1))
            T += m * speed.dot(speed) / 2 + (omega.T * I * omega)[0] / 2
            power += m * g.dot(speed)
        same = {
            sympy.Symbol(a, real=True): (sympy.Symbol(b.strip("-"), real=True) * (-1 if "-" in b else 1))
            for a, b in (alike or {}).items()
        }
        T, power = T.subs(same), power.subs(same) if gravity else sympy.Integer(0)
        P = [T.diff(x) for x in u]
        self.M = [[momentum.diff(x) for x in u] for momentum in P]
        self.gravity = [-sympy.diff(power, x) for x in u]
        rate = [sum((momentum.diff(x) * xd for x, xd in zip(q, qd, strict=True)), sympy.Integer(0)) for momentum in P]
        first = 0
        if moving:  # a = vd + w x v is zero
            first, turned = 6, -w.cross(v)
            rate = [x + sum(self.M[k][3 + a] * turned[a] for a in range(3)) for k, x in enumerate(rate)]
            P_w, P_v = sympy.Matrix(P[:3]), sympy.Matrix(P[3:6])
            rate[:3] = sympy.Matrix(rate[:3]) + w.cross(P_w) + v.cross(P_v)
            rate[3:6] = sympy.Matrix(rate[3:6]) + w.cross(P_v)
        for k, x in enumerate(q):
            rate[first + k] -= T.diff(x)
        self.coriolis = rate

    @property
    def entries(self):
        n = len(self.M)
        found = {("M", i, j): self.M[i][j] for i in range(n) for j in range(i, n)}
        for name in ("gravity", "coriolis"):
            found |= {(name, i, -1): x for i, x in enumerate(getattr(self, name))}
        return found


def operations(expressions):
    """Operations of expressions, of each distinct sine or cosine once."""
    waves = set().union(*(x.atoms(sympy.sin, sympy.cos) for x in expressions))
    plain = {wave: sympy.Dummy() for wave in waves}
    return sum(sympy.count_ops(x.xreplace(plain)) for x in expressions) + sum(map(sympy.count_ops, waves))
