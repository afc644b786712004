"""The C file of a robot: it compiles without warnings and computes what robodyn computes."""

from __future__ import annotations

import re
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.c_functions import CC, called, compiled_c, needs_c
from helpers.command_line import ROBOTS
from helpers.oracles import random_state, worst
from helpers.small_robots import built, joint, link, random_tree

import robodyn
from robodyn.equations.c_source import c_source
from robodyn.errors import InputError
from robodyn.scene.scene import DEFAULT, Scene

BUSY = replace(BUSY_SCENE, wrenches=tuple(wrench for wrench in BUSY_SCENE.wrenches if not wrench.columns))


def named(name, scene=None):
    scene = robodyn.load_scene(ROBOTS / scene) if scene else DEFAULT
    return robodyn.load(ROBOTS / f"{name}.urdf", moving_base=scene.moving_base), scene


CASES = {
    "scara": lambda: named("scara"),
    "puma560": lambda: named("puma560", "puma560_motors.toml"),
    "mimic": lambda: named("gripper", "gripper.toml"),
    "free": lambda: named("satellite", "satellite.toml"),
    "busy": lambda: (busy_robot(), BUSY),
    "busy_free": lambda: (busy_robot(moving_base=True), BUSY),
    "skew": lambda: (random_tree(7, 5, moving_base=True), DEFAULT),
}


@needs_c
@pytest.mark.parametrize("case", CASES)
def test_it_computes_what_robodyn_computes(case, tmp_path):
    model, scene = CASES[case]()
    text = c_source(model, scene)
    library = compiled_c(text, tmp_path)
    prefix = re.search(r"void (\w+)_inverse_dynamics", text)[1]
    n, (q, qd, qdd) = model.n, random_state(model, np.random.default_rng(1), 10)

    def found(job, *sources, outputs=n):
        return called(getattr(library, f"{prefix}_{job}"), sources, outputs)

    tau = robodyn.inverse_dynamics(model, q, qd, qdd, scene=scene)
    assert worst(found("inverse_dynamics", q, qd, qdd), tau) <= 1e-13
    M = robodyn.mass_matrix(model, q, scene=scene)
    assert worst(found("mass_matrix", q, outputs=n * n).reshape(-1, n, n), M) <= 1e-13
    assert worst(found("bias", q, qd), robodyn.bias_forces(model, q, qd, scene=scene)) <= 1e-13
    expected = robodyn.forward_dynamics(model, q, qd, tau, scene=scene)
    assert worst(found("forward_dynamics", q, qd, tau), expected) <= 1e-13 * np.linalg.cond(M).max()
    assert (
        worst(robodyn.inverse_dynamics(model, q, qd, found("forward_dynamics", q, qd, tau), scene=scene), tau) <= 1e-13
    )


ODD = ["*/ int", "a-b", "a b", "A_b", "\u00fcml\u00e4ut", "??/", "7", "if", "/*"]


@needs_c
def test_odd_names(tmp_path):
    parts = [link("l0"), *(link(f"l{k}", 1, (0.1, 0, 0), (1, 0, 0, 1, 0, 1)) for k in range(1, len(ODD) + 1))]
    escaped = [name.replace("&", "&amp;").replace("<", "&lt;") for name in ODD]
    parts += [joint(name, f"l{k}", f"l{k + 1}", axis=(0, 0, 1)) for k, name in enumerate(escaped)]
    text = c_source(replace(built(*parts), name="3 of */ ??/ them"))
    compiled_c(text, tmp_path)
    assert "void robot_3_of_them_inverse_dynamics(" in text
    enumerated = re.findall(r"ROBOT_3_OF_THEM_QD_(\w+) = (\d+)", text)
    assert len({name for name, _ in enumerated}) == len(ODD)
    assert [int(place) for _, place in enumerated] == list(range(len(ODD)))


@needs_c
def test_declarations_stand_alone_and_twice(tmp_path):
    (tmp_path / "scara.c").write_text(c_source(*named("scara")))
    (tmp_path / "main.c").write_text(
        "#define SCARA_DECLARATIONS_ONLY\n"
        + 2 * '#include "scara.c"\n'
        + "int main(void) { double M[SCARA_N * SCARA_N], q[SCARA_NQ] = {0.0, 0.0, 0.0};\n"
        "scara_mass_matrix(q, M); return M[SCARA_QD_QUILL * SCARA_N + SCARA_QD_QUILL] > 1.4 ? 0 : 1; }\n"
    )
    strict = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O0")
    subprocess.run([CC, *strict, "-o", "main", "main.c", "scara.c", "-lm"], cwd=tmp_path, check=True)
    subprocess.run([tmp_path / "main"], check=True)


FRICTION = "lift: viscous 35.0, forward 18.0, backward -14.0, stribeck 22.0, stribeck_velocity 0.01\n"


def test_the_head_says_what_is_in_the_file():
    text = c_source(*named("gripper", "gripper.toml"))
    head = text[: text.index("*/")]
    for words in (
        '"gripper"',
        "lift: prismatic, m",
        "wrist: revolute, rad",
        "Gravity (0.0, 0.0, -9.81) m/s^2",
        FRICTION,
    ):
        assert words in head
    assert re.search(r"coulomb friction: f sign\(qd\).*; \d joints with Coulomb friction\n", head)
    assert re.search(r"\* +\w+ = -?1\.0 jaw \+ ", head)
    assert re.search(r"/\* tau of a motion; \d+ operations \*/", text)
    assert "No friction." in c_source(*named("scara"))


def test_forward_dynamics_is_left_out_where_nothing_resists():
    parts = (link("a"), link("b", 1, (0.1, 0, 0), (1, 0, 0, 1, 0, 1)), link("c"))
    text = c_source(built(*parts, joint("j1", "a", "b"), joint("j2", "b", "c")))
    assert 'forward_dynamics is left out: joint "j2" moves nothing that has inertia' in text
    assert "_forward_dynamics(" not in text


def test_columns_of_a_trajectory_are_refused():
    with pytest.raises(InputError, match="name columns of a trajectory: 'push', 'twist'"):
        c_source(busy_robot(), BUSY_SCENE)
    with pytest.raises(InputError, match="overflows"):
        c_source(named("scara")[0], Scene(gravity=(0, 0, 1e308)))
