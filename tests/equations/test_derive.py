"""The worked solution, read from its LaTeX and computed, against forces from kinematics in the ground's axes."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest
from helpers.latex_reader import Names, Reader, equations
from helpers.oracles import ROBOTS, robot
from helpers.small_robots import random_tree

import robodyn
from robodyn.dynamics.recursions.newton_euler import along_joint, euler, newton_euler
from robodyn.equations.derive import derive
from robodyn.equations.letters import KINDS
from robodyn.errors import InputError, SceneError
from robodyn.report.document import Formula, text
from robodyn.report.equations.derive import derive_latex, derive_page, derive_sections
from robodyn.report.renderers.pages import html
from robodyn.robot.kinematics import acceleration_of_point, accelerations, motions, poses, velocities


@cache
def in_letters(name):
    return derive(robot(name), kinds=KINDS)


def turned(axis, angle):
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K


def tilde(a):
    return np.cross(np.eye(3), a)


def moved(model, q, qd, qdd, g):
    """Of each body: rotation, origin, w, v, wd, a of the origin, in the ground's axes; a includes -g."""
    out = [(np.eye(3), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), -g)]
    for i, body in enumerate(model.bodies[1:]):
        joint = body.joint
        R_j, o_j, w_j, v_j, wd_j, a_j = out[body.parent]
        slides = joint.kind == "prismatic"
        R = R_j @ joint.R @ (np.eye(3) if slides else turned(joint.axis, q[i]))
        e = R @ joint.axis
        d = R_j @ (joint.p + (joint.R @ joint.axis * q[i] if slides else 0.0))
        v = v_j + np.cross(w_j, d) + slides * e * qd[i]
        a = a_j + np.cross(wd_j, d) + np.cross(w_j, np.cross(w_j, d))
        if slides:
            a = a + 2.0 * np.cross(w_j, e * qd[i]) + e * qdd[i]
            out.append((R, o_j + d, w_j, v, wd_j, a))
        else:
            wd = wd_j + e * qdd[i] + np.cross(w_j, e * qd[i])
            out.append((R, o_j + d, w_j + e * qd[i], v, wd, a))
    return out


def wrenches(model, found):
    """Of each body: momenta P, H about the mass centre, m (a_c - g), rate of H, in the ground's axes; mass centre."""
    out = []
    for body, (R, o, w, v, wd, a) in zip(model.bodies, found, strict=True):
        r, I = R @ body.inertia.centre_of_mass, R @ body.inertia.about_centre @ R.T
        a_c = a + np.cross(wd, r) + np.cross(w, np.cross(w, r))
        P, H = body.inertia.m * (v + np.cross(w, r)), I @ w
        out.append((P, H, body.inertia.m * a_c, I @ wd + np.cross(w, H), o + r))
    return out


def distal(model, i):
    found = {i}
    for k in range(i + 1, len(model.bodies)):
        if model.bodies[k].parent in found:
            found.add(k)
    return sorted(found)


def generalized(model, found, each):
    tau = []
    for i, body in enumerate(model.bodies[1:], 1):
        e, o = found[i][0] @ body.joint.axis, found[i][1]
        F = sum(each[k][2] for k in distal(model, i))
        M = sum(np.cross(each[k][4] - o, each[k][2]) + each[k][3] for k in distal(model, i))
        tau.append(e @ (F if body.joint.kind == "prismatic" else M))
    return np.array(tau)


def named_values(model, g, letters, rng):
    """Every name of a solution in a random state, by Newton's and Euler's laws of all that a joint carries."""
    n = model.n
    q, qd, qdd = rng.uniform(-2.0, 2.0, (3, n))
    found, still = moved(model, q, qd, qdd, g), moved(model, q, qd, np.zeros(n), g)
    each, rest = wrenches(model, found), wrenches(model, still)
    names = Names({letter.name: letter.value for letter in letters})
    N = n
    Gamma, h, B = np.zeros((6 * N, 6 * N)), np.zeros((6 * N, n)), np.zeros((6 * N, 6 * N))
    z, b = np.zeros(6 * N), np.zeros(6 * N)
    names |= {"g_0": g, "w_0": np.zeros(3), "v_0": np.zeros(3), "wd_0": np.zeros(3), "a_0": np.zeros(3)}
    tau = generalized(model, found, each)
    for i, body in enumerate(model.bodies[1:], 1):
        (R, o, w, v, wd, a), (P, H, f, Hd, _) = found[i], each[i]
        R_j, o_j = found[body.parent][:2]
        own = distal(model, i)
        F = sum(each[k][2] for k in own)
        M = sum(np.cross(each[k][4] - o, each[k][2]) + each[k][3] for k in own)
        m, r, I = body.inertia.m, np.asarray(body.inertia.centre_of_mass), np.asarray(body.inertia.about_centre)
        a_c = f / m + g
        vectors = {"w": w, "v": v, "wd": wd, "a": a + g, "P": P, "H": H, "Pd": m * a_c, "Hd": Hd, "F": F, "M": M}
        names |= {f"{name}_{i}": R.T @ x for name, x in (vectors | {"g": g}).items()}
        names |= {f"v_c{i}": R.T @ P / m, f"a_c{i}": R.T @ a_c, f"m_{i}": m, f"r_{i}": r, f"I_{i}": I}
        names |= {f"R_{i}": R_j.T @ R, f"p_{i}": R_j.T @ (o - o_j), f"e_{i}": np.asarray(body.joint.axis, float)}
        names |= {f"q_{i}": q[i - 1], f"qd_{i}": qd[i - 1], f"qdd_{i}": qdd[i - 1], f"tau_{i}": tau[i - 1]}
        k, j = slice(6 * i - 6, 6 * i), slice(6 * body.parent - 6, 6 * body.parent)
        T = R.T @ R_j
        A = np.block([[T, np.zeros((3, 3))], [-T @ tilde(R_j.T @ (o - o_j)), T]])
        slides = body.joint.kind == "prismatic"
        h[k, i - 1] = [*np.zeros(3), *body.joint.axis] if slides else [*body.joint.axis, *np.zeros(3)]
        B[k, k] = np.block([[I - m * tilde(r) @ tilde(r), m * tilde(r)], [-m * tilde(r), m * np.eye(3)]])
        Vd, before = (np.array([*s[0].T @ s[4], *s[0].T @ s[5]]) for s in (still[i], still[body.parent]))
        z[k] = Vd - A @ before if body.parent else Vd
        if body.parent:
            Gamma[k, j] = names[f"A_{i}"] = A
        _, _, f0, Hd0, c0 = rest[i]
        b[k] = [*(R.T @ (np.cross(c0 - o, f0) + Hd0)), *(R.T @ f0)] - B[k, k] @ Vd
        names |= {f"h_{i}": h[k, i - 1], f"B_{i}": B[k, k], f"z_{i}": z[k], f"b_{i}": b[k]}
    Phi = np.linalg.inv(np.eye(6 * N) - Gamma)
    J = Phi @ h
    names |= {f"J_{i}": J[6 * i - 6 : 6 * i] for i in range(1, n + 1)}
    zero, none = np.zeros(n), np.zeros(3)
    weights = generalized(model, at := moved(model, q, zero, zero, g), wrenches(model, at))
    bias = generalized(model, still, rest) - weights
    unit = [generalized(model, at := moved(model, q, zero, e, none), wrenches(model, at)) for e in np.eye(n)]
    Vd = Phi @ (h @ qdd + z)
    names |= {"Gamma": Gamma, "Phi": Phi, "h": h, "B": B, "z": z, "b": b, "qd": qd, "qdd": qdd, "tau": tau}
    names |= {"V": J @ qd, "Vd": Vd, "W": B @ Vd + b, "M": np.array(unit).T, "G": weights, "C": bias}
    names |= {f"{name}_{i + 1}": x[i] for name, x in (("G", weights), ("C", bias)) for i in range(n)}
    names |= {f"M_{i + 1}{k + 1}": unit[k][i] for i in range(n) for k in range(n)}
    return names


def checked(latex, names, tolerance=1e-12):
    """Compute both sides of every equation but the general laws of body i; return how many there are."""
    count = 0
    for left, right in equations(latex):
        if re.search(r"_\{c?i\}", left):
            continue
        a, b = Reader(left, names).value(), Reader(right, names).value()
        if np.ndim(a) == 2 and np.ndim(b) == 1:
            b = b[:, None]
        if np.ndim(a) == 2 and np.ndim(b) == 0:
            b = b * np.eye(len(a))  # the grid of one body
        scale = max(1.0, float(np.abs(a).max()))
        np.testing.assert_allclose(a, b, rtol=0.0, atol=tolerance * scale, err_msg=f"{left} = {right}")
        count += 1
    return count


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("two_link_planar", ()),  # numbers have six digits
        ("two_link_planar", KINDS),
        ("scara", KINDS),
        pytest.param("scara", (), marks=pytest.mark.slow),
        pytest.param("cylindrical", KINDS, marks=pytest.mark.slow),
        pytest.param("puma", KINDS, marks=pytest.mark.slow),
    ],
)
def test_every_equation_holds_in_random_states(name, kinds):
    model = robot(name)
    found = in_letters(name) if kinds else derive(model)
    latex = derive_latex(found)
    rng = np.random.default_rng(7)
    for _ in range(3):
        names = named_values(model, np.array([0.0, 0.0, -9.81]), found.letters, rng)
        assert checked(latex, names, 1e-12 if kinds else 2e-4) > 40 * model.n
    assert latex.count("{") == latex.count("}")
    assert latex.count(r"\left(") == latex.count(r"\right)")
    assert latex.count(r"\begin{") == latex.count(r"\end{")


def test_lines_that_use_what_earlier_lines_define_hold_too(monkeypatch):
    monkeypatch.setattr("robodyn.equations.derive.LONGEST", 10)
    found = derive(robot("puma"), kinds=KINDS)
    assert not found.written_out
    names = named_values(robot("puma"), np.array([0.0, 0.0, -9.81]), found.letters, np.random.default_rng(2))
    assert checked(derive_latex(found), names) > 120


def of_every_body(model, q, qd, qdd, g):
    """Of each body, by letters: what kinematics.py and newton_euler.py find."""
    joints = motions(model, q, qd, qdd)
    inertias = [body.inertia for body in model.bodies]
    moving = zip(velocities(model.parents, joints), accelerations(model.parents, joints), strict=True)
    felt = newton_euler(model.parents, joints, inertias, g)
    turned = [pose.R for pose in poses(model.parents, joints)]
    out = []
    for body, joint, ((w, v), (wd, a)), (F, M), R in zip(model.bodies, joints, moving, felt, turned, strict=True):
        m, r, I = body.inertia.m, body.inertia.centre_of_mass, body.inertia.about_centre
        v_c, a_c = v + np.cross(w, r), acceleration_of_point(a, r, w, wd)
        one = {"w": w, "v": v, "wd": wd, "a": a, "v_c": v_c, "a_c": a_c, "F": F, "M": M, "g": R.T @ g}
        one |= {"m": m, "r": r, "I": I, "P": m * v_c, "H": I @ w, "Pd": m * a_c, "Hd": euler(I, w, wd)}
        one |= {"R": joint.R, "p": joint.p, "turns": body.joint.kind == "revolute"}
        if body.joint.kind in ("revolute", "prismatic"):
            one |= {"e": body.joint.axis, "qd": qd[body.joint.rate], "qdd": qdd[body.joint.rate]}
            one["tau"] = along_joint(body.joint, felt[len(out)])
        out.append({letter: np.asarray(x, dtype=float) for letter, x in one.items()})
    return out


def named(one, label):
    return {f"{letter}{label if letter.endswith('_c') else '_' + label}": x for letter, x in one.items()}


GENERAL = [sides for sides in equations(derive_latex(derive(robot("two_link_planar")))) if sides[0][-2:] == "i}"]


@pytest.mark.parametrize("seed", range(6))
def test_general_laws_and_their_terms_are_the_recursions_of_the_dynamics(seed):
    model = random_tree(seed, n=5, moving_base=seed % 2 == 1, kinds=("revolute", "prismatic"))
    rng, g = np.random.default_rng(seed), np.array([1.0, -2.0, -9.0])
    q, qd, qdd = rng.uniform(-2.0, 2.0, model.nq), *rng.uniform(-2.0, 2.0, (2, model.n))
    found = of_every_body(model, q, qd, qdd, g)
    sizes = {letter: max(np.abs(one[letter]).max() for one in found[1:]) for letter in found[-1]}
    none = {letter: 0.0 * x for letter, x in named(found[-1], "k").items()}
    count = 0
    for i, own in enumerate(found[1:], 1):
        carried = [named(found[k], "k") for k in range(len(found)) if model.parents[k] == i] or [none]
        for left, right in GENERAL:
            letter = re.sub(r"_\{(c?)i\}", lambda index: "_c" * bool(index[1]), left)
            letter = re.sub(r"\\dot\{(\\?\w+)\}", r"\1d", letter).replace(r"\omega", "w").lstrip("\\")
            along = letter not in ("w", "wd", "v", "a") or own["turns"] == (letter[0] == "w")
            if letter == "tau" and ("M" in right) != own["turns"]:
                continue
            names = Names(named(found[model.parents[i]], "j") | named(own, "i") | {"carried": carried})
            names |= {"qd_i": own["qd"] * along, "qdd_i": own["qdd"] * along}
            off = np.abs(Reader(right, names).value() - own[letter]).max()
            assert off <= 1e-13 * sizes[letter], f"{left} = {right} of body {i}"
            count += 1
    assert count == 16 * 5
    if not model.floating:
        steps = derive(model, robodyn.Scene(gravity=tuple(g)), at=q, qd=qd, qdd=qdd).steps
        values = {x.left: x.total for step in (*steps[1:4], *steps[7:9]) for part in step.parts for x in part.equations}
        for i, own in enumerate(found[1:], 1):
            for letter in ("w", "v", "v_c", "wd", "a", "a_c", "P", "H", "Pd", "Hd", "F", "M", "tau"):
                value = np.array(values[f"{letter}{'' if letter[-2:] == '_c' else '_'}{i}"], dtype=float)
                assert np.abs(value - own[letter]).max() <= 1e-13 * sizes[letter]


def test_the_checker_sees_what_is_wrong():
    model = robot("two_link_planar")
    found = in_letters("two_link_planar")
    names = named_values(model, np.array([0.0, 0.0, -9.81]), found.letters, np.random.default_rng(1))
    latex = derive_latex(found)
    for right, wrong in (("l_{1} s_{2}", "l_{1} c_{2}"), (r"\times", "+"), ("- F_{2x} c_{2}", "+ F_{2x} c_{2}")):
        assert right in latex
        with pytest.raises((AssertionError, ValueError)):
            checked(latex.replace(right, wrong), names)


@pytest.mark.parametrize(("name", "n"), [("two_link_planar", 2), ("scara", 3), ("cylindrical", 4)])
def test_unknowns_are_counted_as_the_chapter_does(name, n):
    steps = derive(robot(name)).steps
    *bodies, together = steps[4].counts[1:]
    assert [row[1:3] for row in bodies] == [("1", "5")] * n
    assert together[1:3] == (str(n), str(5 * n))
    assert steps[6].counts[-1] == ("together", str(6 * n), f"{5 * n} reactions, {n} along joints")
    laws = [equation for part in steps[5].parts for equation in part.equations]
    assert [equation.number for equation in laws] == list(range(1, 6 * n, 3))
    unknown = {str(x) for equation in laws for x in np.ravel(equation.total) for x in x.free_symbols}
    assert len({x for x in unknown if x.startswith(("F_", "M_", "tau_"))}) == 6 * n


def test_it_agrees_exactly_in_formulas_and_the_solution_is_the_dynamics():
    for name in ("scara", "two_link_spatial"):
        *_, ode, order = in_letters(name).steps
        assert "every difference vanishes" in ode.parts[-1].words
        assert order.parts[-1].words.count("every difference vanishes") == 2
    model = robot("puma560")
    q, qd, qdd = np.random.default_rng(3).uniform(-2.0, 2.0, (3, 6))
    steps = derive(model, at=q, qd=qd, qdd=qdd).steps
    tau = np.array([float(equation.total) for equation in steps[8].parts[0].equations])
    expected = robodyn.inverse_dynamics(model, q, qd, qdd)
    assert np.abs(tau - expected).max() <= 1e-13 * np.abs(expected).max()
    assert "differ by less than 1e-12" in steps[9].parts[-1].words


def test_a_base_that_moves():
    model = robot("satellite", moving_base=True)
    steps = derive(model, kinds=KINDS).steps
    assert steps[4].counts[1][1:3] == ("6", "0")
    assert steps[6].counts[1][2].startswith("wd_x, wd_y, wd_z, a_x, a_y, a_z, F_1x")
    assert steps[6].counts[-1] == ("together", "18", "10 reactions, 2 along joints, 6 accelerations of the base")
    assert "every difference vanishes" in steps[-1].parts[-1].words
    numbers = derive(model, at=[0.3, -0.2], qd=[1.0, 0.5], qdd=[0.2, 0.1]).steps
    base = {x.left: np.array(x.total, dtype=float) for x in numbers[7].parts[-1].equations}
    assert max(np.abs(base["F_0"]).max(), np.abs(base["M_0"]).max()) < 1e-9


def test_friction_and_couplings_are_terms_of_the_drives():
    found = derive(robot("gripper"), robodyn.load_scene(ROBOTS / "gripper.toml"), kinds=KINDS)
    assert r"\text{(viscous friction)}" in derive_latex(found)
    *_, ode, order = found.steps
    assert any("follow others" in line for line in found.steps[6].words)
    assert ode.laws == ["M qdd + G + C + D + K + S = tau"]
    assert order.laws[-2:] == ["tau - D - K - N - S = h^T Phi^T W", "M - M_N = h^T Phi^T B Phi h"]
    assert [step.parts[-1].words.count("every difference vanishes") for step in (ode, order)] == [1, 2]


def test_long_lines_go_on_below():
    found = derive(robot("rigid_body", moving_base=True), kinds=KINDS)
    lines = text(derive_sections(found)).splitlines()
    assert not any("\\n" in line for line in lines)
    assert max(len(line) for line in lines if " = " in line and "[ " not in line) <= 120


def test_what_is_no_part_of_it_is_refused():
    with pytest.raises(InputError, match="12 joints are too many for formulas"):
        derive(robot("quadruped"))
    model = robot("four_bar")
    scene = robodyn.load_scene(ROBOTS / "four_bar_lift.toml")
    with pytest.raises(SceneError, match="--form dae"):
        derive(model, scene)


TREES = sorted(path.stem for path in ROBOTS.glob("*.urdf") if path.stem != "composite")


@pytest.mark.parametrize(
    "name",
    [name if name in ("pendulum", "rigid_body") else pytest.param(name, marks=pytest.mark.slow) for name in TREES],
)
def test_every_robot_in_numbers_in_every_form(name):
    found = derive(robot(name), at=())
    words = text(derive_sections(found))
    assert words.count("Step ") >= 11
    assert "nan" not in words
    assert derive_latex(found).count("{") == derive_latex(found).count("}")
    page = html(derive_page(found))
    assert page.count("<math ") == sum(isinstance(block, Formula) for block in derive_page(found).blocks)
    assert "\\" not in "".join(re.findall(r"<math .*?</math>", page))


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in TREES if robot(name).n <= 6])
def test_every_small_robot_in_letters(name):
    found = derive(robot(name), kinds=KINDS)
    words = found.steps[-1].parts[-1].words
    assert words.count("vanishes") + words.count("less than 1e-12") == 2
    assert text(derive_sections(found))
