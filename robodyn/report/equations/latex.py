r"""The closed form and the DAE form as LaTeX, to be put into a document that uses amsmath."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from robodyn.equations.closed import Closed
from robodyn.equations.composite import Composite
from robodyn.equations.dae.dae import Dae
from robodyn.equations.forms import module
from robodyn.report.equations.dae import laws
from robodyn.report.equations.equations import checked
from robodyn.report.inertia import ORDER
from robodyn.report.renderers.letters import Latex, latex_of
from robodyn.report.table import printable
from robodyn.support.wording import count

WIDTH = 120
"""Characters of LaTeX after which a sum goes on in the next line."""
ESCAPES = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    **{character: "\\" + character for character in "&%$#_{}"},
}


def closed_latex(closed: Closed) -> str:
    r"""Return a sentence on coordinates, letters and notation, then constants, M, gravity, Coriolis and all else in
    `align*`."""
    joints = [(q, qd) for q, qd in zip(closed.q, closed.qd, strict=True) if q is not None]
    symbol, numbered = module().Symbol, dict[Any, Any]()
    for k, (q, qd) in enumerate(() if all(re.fullmatch(r"q_\d+", str(q)) for q, _ in joints) else joints, 1):
        numbered |= {q: symbol(f"q_{k}", real=True), qd: symbol(f"qd_{k}", real=True)}
    x, y, z = closed.gravity
    lines = {latex_of(name): whole for name, whole in closed.constants.items()}
    for (name, i, j), entry in closed.entries.items():
        index = f"{i + 1}" if j < 0 else f"{i + 1}{',' * (len(closed.rates) > 9)}{j + 1}"
        lines[_part(name, index)] = entry
    bias = " + ".join(_part(effect, "") for effect in closed.bias)
    coordinates = []
    for name, kind, q, qd in zip(closed.rates, closed.kinds, closed.q, closed.qd, strict=True):
        unit = {"floating": "in the axes of the base", "prismatic": "m"}.get(kind, "rad")
        shown = (qd if q is None else q).xreplace(numbered)
        coordinates.append(f"${latex_of(shown)}$ ({escaped(name)}, {unit})")
    symbols = [
        f"\n${Latex().symbol(letter.name)} = {Latex().number(letter.value)}$ ({escaped(letter.meaning)}),"
        for letter in closed.symbols
    ]
    return (
        f"% {' '.join(checked(closed).split())}\n"
        "% Needs \\usepackage{amsmath}.\n"
        f"The equations of motion of {escaped(closed.robot)} are\n"
        f"\\[ M(q)\\,\\ddot{{q}}{' + ' * bool(bias)}{bias} = \\tau \\]\n"
        f"with the coordinates {', '.join(coordinates)},{''.join(symbols)}\n"
        f"gravity $({x:g}, {y:g}, {z:g})$\\,m/s$^2$, SI units, coefficients to\n"
        f"{Latex.digits} digits, $c_{{i}} = \\cos q_{{i}}$, $s_{{i}} = \\sin q_{{i}}$, "
        "$c_{ij} = \\cos(q_{i} + q_{j})$, $s_{ij} = \\sin(q_{i} + q_{j})$\n"
        "and so on, $M_{ij} = M_{ji}$, and\n"
        + _aligned_lines([f"{name} &= {_broken(entry.xreplace(numbered))}" for name, entry in lines.items()])
    )


def composite_latex(found: Composite) -> str:
    """Return mass, mass centre, inertia matrix and momenta of bodies in letters, and shares of the matrix: equations
    for amsmath, one a line."""
    whole, axes = found.whole, "xyz"

    def entries(name: str, values: Any) -> list[str]:
        places = ORDER if values.ndim == 2 else tuple((k,) for k in range(3))
        return [f"{name}_{{{''.join(axes[k] for k in at)}}} &= {latex_of(values[at])}" for at in places]

    lines = [f"m &= {latex_of(whole.m)}", *entries("c", whole.c), *entries("I", whole.inertia)]
    if found.momentum:
        lines += [*entries("P", whole.P), *entries("L", whole.L)]
    for body in found.bodies:
        mark = rf"\text{{{escaped(body.name)}}}"
        lines += entries(rf"(R I_c R^T)^{{{mark}}}", body.turned)
        lines += entries(rf"m(|d|^2 1 - d d^T)^{{{mark}}}", body.moved)
    return "\\begin{align*}\n" + " \\\\\n".join(lines) + "\n\\end{align*}\n"


def _part(effect: str, index: str) -> str:
    known = {"M": ("M", "(q)"), "gravity": ("G", "(q)"), "coriolis": ("V", r"(q, \dot{q})")}
    letter, arguments = known.get(effect, (rf"\tau^{{\text{{{effect}}}}}", ""))
    return letter + (f"_{{{index}}}" if index else arguments)


def _broken(expression: Any) -> str:
    """Return an expression, a long sum on several lines."""
    lines = [""]
    for term in Latex().terms(expression):
        if len(lines[-1]) > WIDTH:
            lines.append("")
        lines[-1] += " " * bool(lines[-1]) + term
    return " \\\\\n    &\\quad ".join(lines)


def escaped(text: str) -> str:
    """Return the text as LaTeX prints it."""
    return "".join(ESCAPES.get(character, character) for character in printable(text))


BODIES = r"""
Body $i$ has the mass $m_i$, the mass centre $c_i$ with the velocity $v_i = \dot{c}_i$, the angular velocity $\omega_i$
and the inertia matrix $I_i$ about $c_i$. Joint $i$ exerts the force $F_i$ and the moment $M_i$, drives included, on
body $i$, and the opposite on the body that carries it; $r_i$ leads to the joint from $c_i$, $s_i$ from the mass centre
of the body that carries $i$. Newton's and Euler's laws:
"""
GENERAL = r"""
with the joint's points $x_i = c_i + r_i$ and $y_i = c_p + s_i$ of body $i$ and of the body $p$ that carries it, and
unit vectors $a$ fixed in body $i$, $b$ and $n$ fixed in body $p$.
"""
SADDLE = r"""All equations together are the differential-algebraic system
\[ M\,\dot{v} = f + G^T \lambda, \qquad g(x) = 0, \]
and with the constraints differentiated twice, $G v = 0$ and $G \dot{v} = \gamma$, a linear system for accelerations and
reactions,
\[ \begin{pmatrix} M & G^T \\ G & 0 \end{pmatrix} \begin{pmatrix} \dot{v} \\ -\lambda \end{pmatrix}
   = \begin{pmatrix} f \\ \gamma \end{pmatrix}. \]
"""
ELIMINATION = r"""With $v = J(q)\,\dot{q}$, hence $G J = 0$, the reactions go and the ODE form is left:
\begin{align*}
J^T M J\,\ddot{q} + J^T M \dot{J}\,\dot{q} &= J^T f + \underbrace{J^T G^T}_{0} \lambda \\
M(q)\,\ddot{q} + b(q, \dot{q}) &= \tau, \qquad M(q) = J^T M J,
  \quad \tau - b(q, \dot{q}) = J^T (f - M \dot{J}\,\dot{q})
\end{align*}
"""
LOOPS = r"""Loops keep their reactions, $M(q)\,\ddot{q} + b = \tau + (G_l J)^T \lambda_l$ with
$G_l J\,\ddot{q} = \gamma_l - G_l \dot{J}\,\dot{q}$.
"""
MOST = 8
"""Terms of a line."""
_TOGETHER = r"x_{0} = y_{0}"
_TURNED, _AXIS = r"a_k \cdot b_{{k+1}} = 0,\ k = 1, 2, 3", r"a_{0} \cdot b_1 = a_{0} \cdot b_2 = 0"
HELD = {
    **dict.fromkeys(("fixed", "weld"), (_TOGETHER, _TURNED)),
    **dict.fromkeys(("revolute", "hinge"), (_TOGETHER, _AXIS)),
    "prismatic": (r"n_1 \cdot (x_{0} - y_{0}) = n_2 \cdot (x_{0} - y_{0}) = 0", _TURNED),
    "point": (_TOGETHER, ""),
    "directions": (r"n_k \cdot (x_{0} - y_{0}) = 0", ""),
    "mimic": (r"q_{0} - k\,q_j - q^0 = 0", ""),
}


def dae_latex(found: Dae) -> str:
    """Return Newton's and Euler's laws of every body, constraints of every joint, the system, and what is left."""
    system, counts = found.system, found.counts
    x, y, z = system.scene.gravity
    several = count(counts.bodies, "body", "bodies")
    title = (
        "% Needs \\usepackage{amsmath}.\n"
        f"The equations of motion of {escaped(system.model.name)}, {several}, in DAE form,\n"
        f"with gravity $g = ({x:g}, {y:g}, {z:g})$\\,m/s$^2$.\n"
    )
    numbered = [(str(i), joint) for i, joint in enumerate(system.joints) if joint.equations]
    numbered += [(str(mimic.body), mimic) for mimic in system.mimics]
    numbered += [(f"L{k}", loop) for k, loop in enumerate(system.loops, 1)]
    lines, held = [], []
    for i in range(counts.bodies):
        newton, euler = (_symbols(law) for law in laws(found, i))
        spin = f"I_{{{i}}} \\dot{{\\omega}}_{{{i}}} + \\omega_{{{i}}} \\times I_{{{i}}} \\omega_{{{i}}}"
        lines.append(f"m_{{{i}}} \\dot{{v}}_{{{i}}} &= {newton} \\\\\n{spin} &= {euler}")
    for name, connection in numbered:
        points, turns = (text.format(f"{{{name}}}") for text in HELD[connection.kind])
        line = f"& \\text{{{escaped(connection.name)}, {connection.kind}}} && {points}"
        held.append(f"{line} && {turns}" if turns else line)
    parts = [title, BODIES, _aligned_lines(lines)]
    if held:
        six = 6 * counts.bodies
        index = f"Its differentiation index is {counts.index[0]}.\n" if counts.index else ""
        redundant = f", {len(counts.redundant)} of them redundant," if counts.redundant else ""
        counted = (
            f"There are {six} positions, {six} velocities and {counts.reactions} reactions for {counts.unknowns} "
            f"equations;\nthe {counts.reactions} constraints{redundant} leave "
            f"${six} - {counts.rank} = {counts.freedom}$ degrees of freedom. {index}"
        )
        parts += [f"Constraints:\n{_aligned_lines(held)}{GENERAL}", SADDLE, counted, ELIMINATION]
    return "".join(parts) + (LOOPS if system.loops else "")


def _symbols(law: str) -> str:
    """Return a sum of `laws` in LaTeX's symbols, a long one on several lines."""
    terms = re.split(r" (?=[+-] )", re.sub(r"([mFMrs])([LE]?\d+)", r"\1_{\2}", law).replace(" x ", r" \times "))
    return " \\\\\n  &\\quad ".join(" ".join(terms[k : k + MOST]) for k in range(0, len(terms), MOST))


def _aligned_lines(lines: Sequence[str]) -> str:
    return "\\begin{align*}\n" + " \\\\\n".join(lines) + "\n\\end{align*}\n"
