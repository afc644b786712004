"""`robodyn equations`: what it prints, and how it refuses."""

from __future__ import annotations

import re

import numpy as np
import pytest
import sympy
from helpers.command_line import ROBOTS, document, shown
from helpers.example_robots import path_of
from helpers.small_robots import joint, link, urdf

import robodyn

PUMA, GRIPPER, PLANAR = (str(ROBOTS / f"{name}.urdf") for name in ("puma", "gripper", "two_link_planar"))
SCARA, FREE = (str(ROBOTS / f"{name}.urdf") for name in ("scara", "rigid_body"))
SCENE = ("--scene", str(ROBOTS / "gripper.toml"))
STATE = ("--at", "0.3,-0.5,0.05", "--qd", "elbow=2", "--tau", "1,2,-14.7")


def test_text():
    text = shown("equations", GRIPPER, *SCENE, "--at", "0.1,0.2,0.01", "--qd", "wrist=-1")
    titles = [part.splitlines()[0] for part in text.rstrip("\n").split("\n\n")]
    assert titles == [
        "gripper: 3 coordinates, the base is bolted down, gravity (0, 0, -9.81) m/s^2",
        "Configuration",
        "Mass matrix M(q) [kg m^2, kg m or kg]",
        "What tau must supply where nothing accelerates",
    ]
    assert re.search(r"^wrist +0\.2$", text, re.MULTILINE)
    assert re.search(r"^joint +gravity +coriolis +payload +viscous friction .* together +unit$", text, re.MULTILINE)
    assert re.search(r"^Condition number \d+\.\d$", text, re.MULTILINE)


def test_whether_the_base_is_held_is_said():
    """A description does not say it, and of a satellite it is wrong."""
    satellite, scene = (str(ROBOTS / f"satellite.{suffix}") for suffix in ("urdf", "toml"))
    for more in ((), ("--form", "dae")):
        assert ", the base is bolted down, " in shown("equations", satellite, *more).splitlines()[0]
    assert ", the base moves, " in shown("equations", satellite, "--scene", scene).splitlines()[0]


def test_json():
    found = document("equations", PUMA, "--at", "0.1,-0.5,0.3", "--qd", "1,0,-2", "--gravity", "0,0,-1.62")
    model, scene = robodyn.load(PUMA), robodyn.Scene(gravity=(0, 0, -1.62))
    q, qd = found["q"], found["qd"]
    assert (q, qd) == ([0.1, -0.5, 0.3], [1, 0, -2])
    assert found["M"] == robodyn.mass_matrix(model, q).tolist()
    assert found["bias"] == robodyn.bias_forces(model, q, qd, scene=scene).tolist()
    assert np.allclose(np.sum(list(found["shares"].values()), axis=0), found["bias"], rtol=0, atol=1e-14)


def test_a_singular_mass_matrix_is_valid_json(tmp_path):
    robot = tmp_path / "r.urdf"
    robot.write_bytes(urdf(link("a"), link("b"), joint("j", "a", "b", "continuous")))
    assert document("equations", str(robot))["condition"] is None
    assert "M is singular to working precision" in shown("equations", str(robot))


def test_closed_text_and_json_say_the_same():
    call = ("equations", PLANAR, "--form", "closed")
    lines = dict(line.split(" = ") for line in shown(*call).splitlines() if "] = " in line)
    found = document(*call)
    assert found["joints"][0] == {"name": "shoulder", "kind": "revolute", "q": "q_shoulder", "qd": "qd_shoulder"}
    pairs = [(lines["M[1,2]"], found["M"][0][1]), (lines["gravity[1]"], found["shares"]["gravity"][0])]
    pairs.append((lines["coriolis[2]"], found["shares"]["coriolis"][1]))
    for text, exact in pairs:
        assert sympy.nsimplify(sympy.sympify(text), rational=True) == sympy.sympify(exact)
    assert found["check"]["largest_difference"] <= 1e-12


def test_latex():
    assert "M_{12} &= 0.4 + 0.5 c_{2} \\\\\n" in shown("equations", PLANAR, "--form", "closed", "--format", "latex")


def test_letters_as_text_json_latex_and_python():
    call = ("equations", PLANAR, "--symbols")
    text = shown(*call)
    assert "M[1,1] = m_1*c_1x^2 + m_2*(l_1^2 + c_2x^2) + 2*A_1*c_2\n" in text
    assert "\nA_1 = m_2*l_1*c_2x\n" in text
    assert "\nl_1    0.5   from the joint of upper_arm to the next, along x [m]\n" in text
    found = document(*call)
    assert found["constants"] == {"A_1": "c_2x*l_1*m_2"}
    assert found["symbols"][1] == {"name": "m_2", "value": 2.5, "meaning": "mass of forearm [kg]"}
    values = {letter["name"]: letter["value"] for letter in found["symbols"]}
    M_12 = sympy.sympify(found["M"][0][1]).subs({"A_1": found["constants"]["A_1"]}).subs(values)
    assert M_12.subs("q_2", 0) == pytest.approx(0.9, rel=1e-15)
    assert "A_{1} &= m_{2} l_{1} c_{2x} \\\\\n" in shown(*call, "--format", "latex")
    space = {}
    exec(shown(*call, "--format", "python"), space)
    assert space["torques"]([0, 0], [0, 0], [0, 1], g=0)[0] == pytest.approx(0.9, rel=1e-15)
    some = shown("equations", PLANAR, "--symbols", "m,g", "--assume", "m_1 > 0")
    assert "gravity[2] = 0.4*m_2*g*c_12\n" in some


def dae(*call):
    return shown("equations", *call, "--form", "dae")


def dae_document(*call):
    return document("equations", *call, "--form", "dae")


def test_text_of_the_dae_form():
    text = dae(SCARA, *STATE)
    titles = [part.splitlines()[0] for part in text.rstrip("\n").split("\n\n")]
    assert titles == [
        "scara: DAE form, 4 bodies, the base is bolted down, gravity (0, 0, -9.81) m/s^2",
        "Unknowns and equations",
        "Bodies: six coordinates each, Newton's and Euler's laws about the mass centre c",
        "Joints: a constraint equation and a reaction for each direction in which it holds",
        "Constraints: x is the joint's point of a body, y that of its parent p; r = x - c, s = x - c_p; n moves with p",
        "State",
        "Accelerations of the bodies: wd in the body's axes, dv/dt of the mass centre in the ground's",
        "Reactions lambda on the body that a joint carries, along its axes at q = 0, fixed in the parent",
        "Elimination of the reactions, to the ODE form with 3 velocities qd",
        titles[-1],
    ]
    assert re.fullmatch(
        r"Both forms: against the ODE form's recursions .* differ by <1e-12 of the largest,", titles[-1]
    )
    for line in (
        "algebraic     reactions lambda  21  constraints                     21",
        "together                        69                                  69",
        "rank of G: 21 of 21, no constraint is redundant",
        "degrees of freedom: 6 x 4 - 21 = 3",
        "index: 3; 2 with constraints differentiated once, 1 twice",
        "  coefficients of (a, lambda) then have rank 24, 24, 45 of 45",
    ):
        assert line in text.splitlines()
    assert re.search(r"^2 outer_arm +4\.000 kg +m2 g \+ F2 - F3 +M2 \+ r2 x F2 - M3 - s3 x F3$", text, re.MULTILINE)
    assert re.search(r"^3 quill +outer_arm - spindle +prismatic +-z +1 +5 .* Fx Fy Mx My Mz$", text, re.MULTILINE)
    assert re.search(r"^elbow +-0\.5 +2\.000 +2\.000 +19\.43$", text, re.MULTILINE)


def test_the_document_holds_the_whole_system():
    """M, G, f and gamma put together from the document alone are solved by its accelerations and reactions."""
    found = dae_document(GRIPPER, "--qd", "wrist=1", "--tau", "jaw=2")
    bodies, connections = found["bodies"], found["connections"]
    n = 6 * len(bodies)
    M, f = np.zeros((n, n)), np.array([x for body in bodies for x in body["f"]])
    for i, body in enumerate(bodies):
        M[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = body["inertia"]
        M[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = body["mass"] * np.eye(3)

    def row(equation):
        out = np.zeros(n)
        for part in equation["rows"]:
            out[6 * part["body"] : 6 * part["body"] + 6] = part["row"]
        return out

    for rotor in (own for c in connections for own in c["coordinates"]):
        M += rotor["rotor"] * np.outer(row(rotor), row(rotor))
    held = [equation for c in connections for equation in c["equations"]]
    G, a = np.array([row(e) for e in held]).reshape(-1, n), np.array([[*b["wd"], *b["vd"]] for b in bodies]).ravel()
    reactions, gamma = np.array([e["lambda"] for e in held]), np.array([e["gamma"] for e in held])
    size = np.abs(f).max()
    assert np.abs(M @ a - f - G.T @ reactions).max() <= 1e-14 * size
    assert np.abs(G @ a - gamma).max(initial=0.0) <= 1e-14 * max(np.abs(a).max(), 1.0)


def test_a_free_body_needs_no_constraints():
    text, latex = dae(FREE), dae(FREE, "--format", "latex")
    assert "index: 0, there are no reactions" in text
    assert re.search(r"^0 plate +12\.00 kg +m0 g +0$", text, re.MULTILINE)
    assert "Constraints" not in text + latex


def test_mimic_joints_have_an_equation():
    text = dae(GRIPPER)
    assert re.search(r"^pinion follows jaw +palm - pinion +mimic +- +- +1 +M$", text, re.MULTILINE)
    assert "degrees of freedom: 6 x 6 - 33 = 3" in text


@pytest.mark.slow
def test_long_robots_are_cut():
    text = dae(str(path_of("talos_full_v2")))
    assert len(text.splitlines()) < 180
    assert max(map(len, text.splitlines())) < 200
    assert re.search(r"differ by <1e-12 of the largest,\nforces at joints by <1e-12 and moments by <1e-12", text)
    assert "... and 29 more bodies; --format json has them all" in text
    assert len(re.findall(r"^\.\.\. and \d+ more joints; --format json has them all$", text, re.MULTILINE)) == 2


def test_a_robot_that_nothing_holds_back(tmp_path):
    robot = tmp_path / "r.urdf"
    robot.write_bytes(urdf(link("a", 1.0), link("b"), joint("j", "a", "b", "continuous")))
    text = dae(str(robot))
    assert "index: not defined, as accelerations and reactions do not follow from the equations" in text
    assert 'hardly anything resists "j": accelerations and reactions are not defined' in text
    found = dae_document(str(robot))
    assert (found["qdd"], found["comparison"], found["counts"]["index"]) == (None, None, None)


def test_loops_of_a_scene():
    """Two four-bars: --at keeps what it names, the other coordinates close the loops, redundancy is told."""
    urdf_file, scene = (str(ROBOTS / name) for name in ("four_bars.urdf", "four_bars_a02.toml"))
    call = (urdf_file, "--scene", scene, "--at", "A0=1.2", "--qd", "A0=-1", "--tau", "A0=3")
    text = dae(*call)
    assert "rank of G: 35 of 37, 2 redundant (pin_1 Fy; pin_2 Fy)" in text
    assert "degrees of freedom: 6 x 6 - 35 = 1" in text
    assert re.search(
        r"^3 crank_1 +1\.000 kg +m3 g \+ F3 - F4 - FL1 +.* - M4 - s4 x F4 - sL1 x FL1$", text, re.MULTILINE
    )
    assert re.search(r"^L1 pin_1 +crank_1 - coupler_1 +point +- +3 +3 +Fx Fy Fz$", text, re.MULTILINE)
    assert re.search(r"^A0 +1\.2 +-1\.000 +3\.000 ", text, re.MULTILINE)
    assert re.search(r"^Both forms: against the closed chain in joint coordinates .* <1e-12 ", text, re.MULTILINE)
    found = dae_document(*call)
    assert [c["kind"] for c in found["connections"][-2:]] == ["point", "point"]
    assert found["counts"]["redundant"] == [["pin_1", "Fy"], ["pin_2", "Fy"]]
    assert np.abs(np.diff(found["qd"][:3])).max() <= 1e-13
    assert "\\text{pin\\_2, point} && x_{L2} = y_{L2}" in dae(urdf_file, "--scene", scene, "--format", "latex")


def test_what_falls_freely_has_no_reactions_of_rounding():
    """Forces are told beside the weight: of this robot nothing but 1e-15 N of rounding is left."""
    table = re.search(r"^Reactions.*?\n\n", dae(GRIPPER), re.MULTILINE | re.DOTALL)[0]
    assert set(re.findall(r"(?<= )\S*\d\S*$|(?<=  )-?\d\S*(?= )", table)) == {"0"}


def test_latex_of_the_dae_form():
    text = dae(SCARA, "--format", "latex")
    assert "m_{2} \\dot{v}_{2} &= m_{2} g + F_{2} - F_{3} \\\\\nI_{2} \\dot{\\omega}_{2} + " in text
    assert "\\text{quill, prismatic} && n_1 \\cdot (x_{3} - y_{3}) = n_2 \\cdot (x_{3} - y_{3}) = 0" in text
    assert "for 69 equations;\nthe 21 constraints leave $24 - 21 = 3$ degrees of freedom." in text
    assert text.count("\\begin{") == text.count("\\end{")


def test_rotors_and_oblique_axes_are_explained(tmp_path):
    puma, motors = str(ROBOTS / "puma560.urdf"), str(ROBOTS / "puma560_motors.toml")
    line = "a joint passes on tau, less friction and springs: S^T tau in f; a rotor J adds S^T J S to M"
    assert line in dae(puma, "--scene", motors, "--qd", "waist=1")
    oblique = tmp_path / "oblique.urdf"
    axis = joint("j", "a", "b", "continuous", (0.6, 0, 0.8))
    oblique.write_bytes(urdf(link("a", 1.0), link("b", 1.0, (0.2, 0.1, 0)), axis))
    text = dae(str(oblique))
    assert "1, 2 and a are perpendicular, a along an oblique axis" in text
    assert re.search(r"^1 j +a - b +revolute +a = \(0\.6, 0, 0\.8\) +1 +5 .* F1 F2 Fa M1 M2$", text, re.MULTILINE)
