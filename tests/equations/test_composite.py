"""Bodies as one, in letters and numbers: against SymPy by hand, closed forms, Pinocchio, momenta of the robot."""

from __future__ import annotations

import json

import numpy as np
import pytest
from helpers.command_line import run
from helpers.oracles import ROBOTS
from helpers.peers import pin

import robodyn
from robodyn.equations.composite import in_letters, in_numbers
from robodyn.errors import InputError
from robodyn.robot.load import assemble, load_description
from robodyn.robot.masses.declared import robot_inertia
from robodyn.solids.inertia.properties import View

sympy = pytest.importorskip("sympy")
VIEWS = (View("com"), View("origin"), View((0.1, -0.2, 0.3), (0.4, -0.5, 0.6)))


def description(name):
    return load_description(ROBOTS / f"{name}.urdf")


def spread(d):
    return d.dot(d) * sympy.eye(3) - d * d.T


def symbol(name):
    return sympy.Symbol(name, real=True)


def vanishes(difference):
    return all(sympy.simplify(sympy.expand_trig(x)) == 0 for x in np.ravel(difference))


def test_satellite_for_any_angles_by_hand():
    found = in_letters(description("satellite"), View("origin"))
    m0, m1, l, c = map(symbol, ("m_0", "m_1", "l_0", "c_1y"))
    c0 = sympy.Matrix([symbol(f"c_0{axis}") for axis in "xyz"])
    I0 = sympy.Matrix(3, 3, lambda i, j: symbol("I_0" + "xyz"[min(i, j)] + "xyz"[max(i, j)]))
    I1 = sympy.diag(*(symbol(f"I_1{axis}{axis}") for axis in "xyz"))
    whole = I0 + m0 * spread(c0)
    for q, side in ((symbol("q_1"), 1), (symbol("q_2"), -1)):
        R = sympy.Matrix([[sympy.cos(q), 0, sympy.sin(q)], [0, 1, 0], [-sympy.sin(q), 0, sympy.cos(q)]])
        whole += R * I1 * R.T + m1 * spread(sympy.Matrix([0, side * (l + c), 0]))
    assert vanishes(found.whole.inertia - np.array(whole))
    assert vanishes(found.whole.c - np.array(m0 * c0 / (m0 + 2 * m1)).ravel())


@pytest.mark.parametrize("about", ["origin", pytest.param("com", marks=pytest.mark.slow)])
def test_scara_by_homogeneous_matrices(about):
    found = in_letters(description("scara"), View(about))
    q, l = [symbol(f"q_{k}") for k in (1, 2, 3)], [symbol(f"l_{k}") for k in range(3)]
    turn = [sympy.rot_axis3(-angle) for angle in q[:2]]
    steps = [(turn[0], (0, 0, l[0])), (turn[1], (l[1], 0, 0)), (sympy.eye(3), (l[2], 0, -q[2]))]
    centres = [(symbol("c_1x"), 0, 0), (symbol("c_2x"), 0, 0), (0, 0, symbol("c_3z"))]
    moments = [[symbol(f"I_{k}{a}") for a in axes] for k, axes in
               ((1, ("xx", "yy", "zz")), (2, ("xx", "yy", "zz")), (3, ("xx", "xx", "zz")))]  # fmt: skip
    T, bodies = sympy.eye(4), []
    for k, ((R, p), c, I) in enumerate(zip(steps, centres, moments, strict=True), 1):
        T = T * R.row_join(sympy.Matrix(p)).col_join(sympy.Matrix([[0, 0, 0, 1]]))
        centre = (T * sympy.Matrix([*c, 1]))[:3, 0]
        bodies.append((symbol(f"m_{k}"), centre, T[:3, :3] * sympy.diag(*I) * T[:3, :3].T))
    total = sum(m for m, _, _ in bodies)
    com = sum((m * c for m, c, _ in bodies), sympy.zeros(3, 1)) / total
    point = com if about == "com" else sympy.zeros(3, 1)
    whole = sum((I + m * spread(c - point) for m, c, I in bodies), sympy.zeros(3))
    names = sorted(whole.free_symbols | com.free_symbols, key=str)
    differences = [*(found.whole.inertia - np.array(whole)).ravel(), *(found.whole.c - np.array(com).ravel())]
    difference = sympy.lambdify(names, differences, "numpy")
    states = np.random.default_rng(1).uniform(0.2, 2.0, (50, len(names)))
    assert max(np.abs(difference(*state)).max() for state in states) < 1e-12


def test_composite_of_boxes_in_closed_form():
    found = robot_inertia(description("composite"), links=["deck", "ball"])
    m, M, x, z = 12.0, 4.0, 0.2, 0.09
    reduced, ball = m * M / (m + M), 0.4 * M * 0.08**2
    d = np.array([x, 0.0, z])
    expected = np.diag([m * (0.4**2 + 0.02**2), m * (0.02**2 + 0.6**2), m * (0.6**2 + 0.4**2)]) / 12
    expected += ball * np.eye(3) + reduced * (d @ d * np.eye(3) - np.outer(d, d))
    assert np.abs(found.body.inertia - expected).max() < 1e-14
    assert np.abs(found.body.com - M / (m + M) * d).max() < 1e-15


def tree(rng, joints=4):
    """A random tree of bodies, joints and products of inertia, with a link that is fixed to another."""
    text = []
    for k in range(joints + 2):
        A = rng.normal(size=(3, 3))
        S = A @ A.T
        I = np.trace(S) * np.eye(3) - S
        numbers = dict(zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), I[np.triu_indices(3)].tolist(), strict=True))
        inertia = " ".join(f'{key}="{value!r}"' for key, value in numbers.items())
        xyz, rpy = (" ".join(map(repr, rng.uniform(-1, 1, 3).tolist())) for _ in range(2))
        text.append(
            f'<link name="b{k}"><inertial><origin xyz="{xyz}" rpy="{rpy}"/><mass value="{rng.uniform(1, 3)!r}"/>'
            f"<inertia {inertia}/></inertial></link>"
        )
        if k:
            kind = "fixed" if k > joints else rng.choice(["revolute", "prismatic", "continuous"])
            axis = "xyz"[rng.integers(3)]
            axis = " ".join("1" if a == axis else "0" for a in "xyz")
            xyz, rpy = (" ".join(map(repr, rng.uniform(-1, 1, 3).round(2).tolist())) for _ in range(2))
            text.append(
                f'<joint name="j{k}" type="{kind}"><parent link="b{rng.integers(k)}"/><child link="b{k}"/>'
                f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
                '<limit lower="-9" upper="9" effort="1" velocity="1"/></joint>'
            )
    return f'<robot name="tree">{"".join(text)}</robot>'


def agree(description, view, links=(), frame="base", kinds="mlcI", seed=0):
    model = assemble(description)
    rng = np.random.default_rng(seed)
    q, qd = rng.uniform(-1, 1, (2, model.n))
    numbers = in_numbers(robot_inertia(description, q, links, frame), description, view, qd)
    letters = in_letters(description, view, tuple(kinds), links, frame, momentum=True)
    joints = [(k, body.joint.rate) for k, body in enumerate(model.bodies) if k]
    values = {f"q_{k}": q[i] for k, i in joints} | {f"qd_{k}": qd[i] for k, i in joints}
    values |= {letter.name: letter.value for letter in letters.letters}
    entries = [x for name in ("inertia", "c", "P", "L") for x in np.ravel(getattr(letters.whole, name))]
    symbols = sorted(set().union(*(x.free_symbols for x in entries)), key=str)
    found = np.array(sympy.lambdify(symbols, entries, "numpy")(*(values[str(x)] for x in symbols)))
    expected = np.concatenate([np.ravel(getattr(numbers.whole, name)) for name in ("inertia", "c", "P", "L")])
    assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()


def test_letters_of_a_random_tree_agree_with_numbers(tmp_path):
    (tmp_path / "tree.urdf").write_text(tree(np.random.default_rng(0), 1))
    agree(load_description(tmp_path / "tree.urdf"), VIEWS[0], frame="b1", kinds="mc")


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 2, 3))])
def test_letters_of_more_random_trees_agree_with_numbers(seed, tmp_path):
    (tmp_path / "tree.urdf").write_text(tree(np.random.default_rng(seed + 10), 1))
    kinds = ("lI", "m", "", "mc")[seed]
    agree(load_description(tmp_path / "tree.urdf"), VIEWS[seed % 3], frame=("base", "b1")[seed % 2], kinds=kinds)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("puma", marks=pytest.mark.slow),
        pytest.param("cylindrical", marks=pytest.mark.slow),
        "two_link_spatial",
    ],
)
def test_letters_of_robots_agree_with_numbers(name):
    agree(description(name), View("origin"))


def test_momenta_in_letters_of_a_base_that_moves():
    found = in_letters(description("satellite"), View("origin"), momentum=True, moving_base=True)
    model = assemble(description("satellite"), moving_base=True)
    rng = np.random.default_rng(2)
    angles, qd = rng.uniform(-1, 1, 2), rng.uniform(-1, 1, model.n)
    expected = robodyn.momenta(model, [0, 0, 0, 0, 0, 0, 1, *angles], qd, frame="bus")
    rates = ("w_x", "w_y", "w_z", "v_x", "v_y", "v_z", "qd_1", "qd_2")
    values = dict(zip(map(symbol, ("q_1", "q_2", *rates)), (*angles, *qd), strict=True))
    values |= {symbol(letter.name): letter.value for letter in found.letters}
    P, L = (np.array([x.subs(values) for x in vector], dtype=float) for vector in (found.whole.P, found.whole.L))
    assert np.abs(P - expected.linear).max() <= 1e-12 * np.abs(expected.linear).max()
    assert np.abs(L - expected.angular).max() <= 1e-12 * np.abs(expected.angular).max()


def test_letters_of_some_links_in_the_frame_of_another():
    agree(description("scara"), VIEWS[0], ["inner_arm", "spindle"], "outer_arm")


@pytest.mark.parametrize("view", VIEWS)
def test_shares_add_up_to_the_whole(view):
    given = description("meshed_arm")
    found = robot_inertia(given, {"elbow": 0.5, "waist": -0.3}, frame="hand")
    shares = in_numbers(found, given, view, {"waist": 1.0})
    _, matrix = view.inertia(found.body)
    scale = np.abs(matrix).max()
    for total in (shares.whole.inertia, sum(share.inertia for share in shares.bodies)):
        assert np.abs(total - matrix).max() <= 1e-13 * scale
    assert np.abs(np.asarray(shares.whole.c - found.body.com, dtype=float)).max() <= 1e-14


@pytest.mark.parametrize("name", ["puma560", "meshed_arm"])
def test_momenta_are_those_of_the_robot_and_of_pinocchio(name):
    given = description(name)
    model = assemble(given)
    q, qd = np.random.default_rng(3).uniform(-1, 1, (2, model.n))
    for about in ("com", "origin"):
        found = in_numbers(robot_inertia(given, q), given, View(about), qd).whole
        expected = robodyn.momenta(model, q, qd, about=about)
        for mine, theirs in ((found.P, expected.linear), (found.L, expected.angular), (found.c, expected.com)):
            assert np.abs(np.asarray(mine) - theirs).max() <= 1e-13 * max(1.0, np.abs(theirs).max())
    c = robodyn.centre_of_mass(model, q)
    assert np.abs(c.m * c.J @ qd - expected.linear).max() <= 1e-13 * np.abs(expected.linear).max()
    assert np.abs(c.c - expected.com).max() <= 1e-14


def test_momentum_against_pinocchio():
    given = description("puma560")
    model, peer = assemble(given), pin.buildModelFromUrdf(str(ROBOTS / "puma560.urdf"))
    data = peer.createData()
    q, qd = np.random.default_rng(4).uniform(-1, 1, (2, model.n))
    h = pin.computeCentroidalMomentum(peer, data, q, qd)
    found = in_numbers(robot_inertia(given, q), given, View("com"), qd).whole
    assert np.abs(np.asarray(found.P) - h.linear).max() <= 1e-12 * np.abs(h.linear).max()
    assert np.abs(np.asarray(found.L) - h.angular).max() <= 1e-12 * np.abs(h.angular).max()
    J = pin.jacobianCenterOfMass(peer, data, q)
    assert np.abs(robodyn.centre_of_mass(model, q).J - J).max() <= 1e-13


def test_centre_of_mass_of_links_in_a_frame():
    given = description("scara")
    model, q = assemble(given), np.random.default_rng(5).uniform(-0.2, 0.2, (4, 3))
    found = robodyn.centre_of_mass(model, q, ["inner_arm", "spindle"], "outer_arm")
    assert (found.c.shape, found.J.shape) == ((4, 3), (4, 3, 3))
    for one, c in zip(q, found.c, strict=True):
        expected = robot_inertia(given, one, ["inner_arm", "spindle"], "outer_arm").body
        assert found.m == expected.mass
        assert np.abs(c - expected.com).max() <= 1e-14
    h, R = 1e-6, robodyn.forward_kinematics(model, q, "outer_arm").R
    ground = robodyn.centre_of_mass(model, q, ["inner_arm", "spindle"])
    for k in range(3):
        step = h * np.eye(3)[k]
        ends = [robodyn.centre_of_mass(model, q + s * step, ["inner_arm", "spindle"]).c for s in (1, -1)]
        assert np.abs(ground.J[..., k] - (ends[0] - ends[1]) / (2 * h)).max() < 1e-9
    assert np.abs(R @ found.J - ground.J).max() < 1e-14
    for names, frame in ((["spindel"], "ground"), (["base"], "ground"), (None, "spindel")):
        with pytest.raises(InputError):
            robodyn.centre_of_mass(model, q, names, frame)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("--links inner_arm,spindel", "no link 'spindel' (did you mean 'spindle'?)"),
        ("--frame spindel", "no link 'spindel'"),
        ("--symbols m,x", "no symbols 'x'"),
        ("--symbols --at 1,2,3", "--at is not for letters"),
        ("--symbols --format urdf", "--format urdf is for numbers"),
        ("--format latex", "--format latex is for a URDF with --symbols"),
        ("--qd 1,2,3", "--qd is for --momentum"),
        ("--moving-base", "--moving-base is for --symbols --momentum"),
        ("--momentum --qd 1e308,1e308,1e308", "overflows"),
        ("--about 1e160,0,0 --symbols", "too far away"),
        ("--links inner_arm,", "not names between commas"),
        ("--links base", "no mass"),
        ("--links base --symbols", "no mass"),
    ],
)
def test_calls_that_contradict_are_refused_in_a_line(arguments, said):
    result = run("inertia", str(ROBOTS / "scara.urdf"), *arguments.split())
    assert result.status == 2
    assert said in result.err
    assert result.err.count("\n") == 1


def test_a_file_is_no_kind_of_letters():
    result = run("inertia", "--symbols", str(ROBOTS / "scara.urdf"))
    assert (result.status, "put it before --symbols" in result.err) == (2, True)


def test_what_is_too_long_is_refused_with_a_way_out():
    result = run("inertia", str(ROBOTS / "puma560.urdf"), "--symbols")
    assert result.status == 2
    assert "too long (fewer --links, --about origin, fewer letters as --symbols m, or --at for numbers)" in result.err


def test_rounding_of_zeros_is_not_printed():
    said = run("inertia", str(ROBOTS / "two_link_planar.urdf"), "--at", "0.5,0.5").out
    assert "1           0        0.540302  0.000000  0.841471" in said
    assert "-0.0" not in said.replace("-0.0000 of", "-0.00")
    assert not any(f"e-{digit}" in said for digit in "123")


def test_links_fixed_to_each_other_are_one_body_in_letters():
    with pytest.raises(InputError, match="fixed to 'deck'"):
        in_letters(description("composite"), View(), links=["deck"])


def test_what_symmetry_makes_vanish_is_said_with_its_plane():
    said = run("inertia", str(ROBOTS / "composite.urdf")).out
    assert "I_xy = I_yz = 0: y is a principal axis, as a plane of symmetry y = 0 would make it" in said
    off = run("inertia", str(ROBOTS / "composite.urdf"), "--about", "0.2,0.1,0.09", "--links", "ball").out
    assert "y is a principal axis, but by no plane of symmetry: the mass centre is not at y = 0.1" in off
    letters = json.loads(run("inertia", str(ROBOTS / "composite.urdf"), "--symbols", "--format", "json").out)
    assert letters["inertia_about"]["matrix"][0][1] == "0"
