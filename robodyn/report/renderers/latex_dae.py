r"""The DAE form as LaTeX, in the letters of textbooks, to be put into a document that uses amsmath."""

from __future__ import annotations

from collections.abc import Sequence

from robodyn.equations.dae.connections import Connection
from robodyn.equations.dae.dae import Dae
from robodyn.report.dae_numbers import acting
from robodyn.report.renderers.latex_closed import escaped
from robodyn.support.wording import count

HEAD = r"""% Needs \usepackage{amsmath}.
"""
BODIES = r"""
Body $i$ has the mass $m_i$, the mass centre $c_i$ with the velocity $v_i = \dot{c}_i$, the angular velocity $\omega_i$
and the inertia matrix $I_i$ about $c_i$. Joint $i$ exerts the force $F_i$ and the moment $M_i$, drives included, on
body $i$, and the opposite on the body that carries it; $r_i$ leads to the joint from $c_i$, $s_i$ from the mass centre
of the body that carries $i$. Newton's and Euler's laws:
"""
GENERAL = r"""
with the joint's points $x_i = c_i + r_i$ and $y_i = c_p + s_i$ of body $i$ and of the body $p$ that carries it, and
unit vectors $a$ fixed in body $i$, $b$ and $n$ fixed in body $p$. Differentiated once and twice, with
$u = v_i + \omega_i \times r_i - v_p - \omega_p \times (x_i - c_p)$,
\begin{align*}
n \cdot u &= 0 \\
n \cdot \bigl(\dot{v}_i + \dot{\omega}_i \times r_i - \dot{v}_p - \dot{\omega}_p \times (x_i - c_p)\bigr)
  &= n \cdot \bigl(\omega_p \times (\omega_p \times (x_i - c_p)) + 2\,\omega_p \times u
     - \omega_i \times (\omega_i \times r_i)\bigr) \\
(a \times b) \cdot (\omega_i - \omega_p) &= 0 \\
(a \times b) \cdot (\dot{\omega}_i - \dot{\omega}_p)
  &= -\bigl((\omega_i \times a) \times b + a \times (\omega_p \times b)\bigr) \cdot (\omega_i - \omega_p)
\end{align*}
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
HELD = {
    "fixed": (r"x_{0} = y_{0}", r"a_k \cdot b_{{k+1}} = 0,\ k = 1, 2, 3"),
    "revolute": (r"x_{0} = y_{0}", r"a_{0} \cdot b_1 = a_{0} \cdot b_2 = 0"),
    "prismatic": (
        r"n_1 \cdot (x_{0} - y_{0}) = n_2 \cdot (x_{0} - y_{0}) = 0",
        r"a_k \cdot b_{{k+1}} = 0,\ k = 1, 2, 3",
    ),
    "point": (r"x_{0} = y_{0}", ""),
    "hinge": (r"x_{0} = y_{0}", r"a_{0} \cdot b_1 = a_{0} \cdot b_2 = 0"),
    "weld": (r"x_{0} = y_{0}", r"a_k \cdot b_{{k+1}} = 0,\ k = 1, 2, 3"),
    "directions": (r"n_k \cdot (x_{0} - y_{0}) = 0", ""),
    "mimic": (r"q_{0} - k\,q_j - q^0 = 0", ""),
}


def dae_latex(found: Dae) -> str:
    """Return Newton's and Euler's laws of every body, constraints of every joint, the system, and what is left."""
    system, counts = found.robot.system, found.counts
    x, y, z = found.robot.scene.gravity
    several = count(counts.bodies, "body", "bodies")
    title = (
        f"The equations of motion of {escaped(found.robot.model.name)}, {several}, in DAE form,\n"
        f"with gravity $g = ({x:g}, {y:g}, {z:g})$\\,m/s$^2$.\n"
    )
    held = [line for i, joint in enumerate(system.joints) if (line := _held(joint, str(i)))]
    held += [_held(mimic, str(mimic.body)) for mimic in system.mimics]
    held += [_held(loop, f"L{k}") for k, loop in enumerate(system.loops, 1)]
    constraints = f"Constraints:\n{_aligned(held)}{GENERAL}" if held else ""
    return (
        HEAD
        + title
        + BODIES
        + _aligned([_law(found, i) for i in range(counts.bodies)])
        + constraints
        + (SADDLE + _counted(found) + ELIMINATION if held else "")
        + (LOOPS if system.loops else "")
    )


def _law(found: Dae, i: int) -> str:
    forces, moments = [], []
    for sign, name, moment in acting(found, i):
        forces.append(f"{sign}F_{{{name}}}")
        arm = "s" if sign else "r"
        moments += [f"{sign}M_{{{name}}}"] * moment + [f"{sign}{arm}_{{{name}}} \\times F_{{{name}}}"]
    weight = [f"m_{{{i}}} g"] if found.robot.system.inertias[i].m and any(found.robot.scene.gravity) else []
    if any(body == i for body, _ in found.robot.terms.wrenches):
        forces.append(f"F^e_{{{i}}}")
        moments.append(f"M^e_{{{i}}}")
    spin = f"I_{{{i}}} \\dot{{\\omega}}_{{{i}}} + \\omega_{{{i}}} \\times I_{{{i}}} \\omega_{{{i}}}"
    return f"m_{{{i}}} \\dot{{v}}_{{{i}}} &= {_sum(weight + forces)} \\\\\n{spin} &= {_sum(moments)}"


def _sum(terms: Sequence[str]) -> str:
    """Return the sum, on a further line after every `MOST` terms."""
    lines = [" + ".join(terms[k : k + MOST]) for k in range(0, len(terms), MOST)]
    return " \\\\\n  &\\quad + ".join(lines).replace("+ -", "- ") or "0"


def _held(connection: Connection, name: str) -> str:
    if not connection.equations:
        return ""
    points, turns = (text.format(f"{{{name}}}") for text in HELD[connection.kind])
    title = f"\\text{{{escaped(connection.name)}, {connection.kind}}}"
    return f"& {title} && {points}" + (f" && {turns}" if turns else "")


def _aligned(lines: Sequence[str]) -> str:
    return "\\begin{align*}\n" + " \\\\\n".join(lines) + "\n\\end{align*}\n"


def _counted(found: Dae) -> str:
    counts = found.counts
    six = 6 * counts.bodies
    index = f"Its differentiation index is {counts.index[0]}.\n" if counts.index else ""
    redundant = f", {len(counts.redundant)} of them redundant," if counts.redundant else ""
    return (
        f"There are {six} positions, {six} velocities and {counts.reactions} reactions for {counts.unknowns} "
        f"equations;\nthe {counts.reactions} constraints{redundant} leave "
        f"${six} - {counts.rank} = {counts.freedom}$ degrees of freedom. {index}"
    )
