"""Loops that a description closes by <constraint> elements."""

from __future__ import annotations

import json

import numpy as np
import pytest
from helpers.closed_chains import crank_slider
from helpers.command_line import run
from helpers.small_robots import joint, link, numbers, urdf
from scipy.spatial.transform import Rotation

import robodyn
from robodyn.errors import DescriptionError
from robodyn.scene.scene import Loop, Scene


def constraint(name, kind, parent, child, **parts):
    inner = "".join(
        f"<{tag} " + " ".join(f'{key}="{numbers(values)}"' for key, values in part.items()) + "/>"
        for tag, part in parts.items()
    )
    return (
        f'<constraint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inner}</constraint>'
    )


def two_arms(*more):
    """Two branches of a frame, each of one hinge."""
    parts = [link("frame"), link("a", 1.0), link("b", 1.0)]
    return urdf(*parts, joint("j1", "frame", "a", axis=(0, 0, 1)), joint("j2", "frame", "b", axis=(0, 1, 0)), *more)


def loops_of(*more, scene=None):
    model = robodyn.load(two_arms(*more))
    return robodyn.scene_of(model, *([] if scene is None else [scene])).loops


PARENT = {"xyz": (0.1, 0.2, 0.3), "rpy": (0.4, -0.5, 2.0)}
CHILD = {"xyz": (-0.3, 0.1, 0.0), "rpy": (-1.0, 0.7, 0.2)}
AXIS = (0.36, 0.48, 0.8)


@pytest.mark.parametrize(("written", "kind"), [("Continuous", "hinge"), ("ball", "point")])
def test_frames_and_axes_are_those_of_the_links(written, kind):
    parts = {"parent_origin": PARENT, "child_origin": CHILD, "parent_axis": {"xyz": AXIS}, "child_axis": {"xyz": AXIS}}
    (loop,) = loops_of(constraint("tie", written, "a", "b", **parts))
    assert (loop.name, loop.kind, loop.link, loop.to) == ("tie", kind, "b", "a")
    assert (loop.point, loop.to_point) == (CHILD["xyz"], PARENT["xyz"])
    if kind == "hinge":
        assert np.allclose(loop.axis, Rotation.from_euler("xyz", CHILD["rpy"]).apply(AXIS), atol=1e-15)
        assert np.allclose(loop.to_axis, Rotation.from_euler("xyz", PARENT["rpy"]).apply(AXIS), atol=1e-15)


@pytest.mark.parametrize("rpy", [(0.4, -0.5, 2.0), (0.3, np.pi / 2, -1.0), (0, 0, np.pi)])
def test_a_weld_turns_the_childs_frame_onto_the_parents(rpy):
    parts = {"parent_origin": {"rpy": rpy, "xyz": (0, 0, 0)}, "child_origin": CHILD}
    (loop,) = loops_of(constraint("tie", "fixed", "a", "b", **parts))
    turned = Rotation.from_euler("xyz", loop.rpy) * Rotation.from_euler("xyz", CHILD["rpy"])
    assert np.abs(turned.as_matrix() - Rotation.from_euler("xyz", rpy).as_matrix()).max() <= 8 * np.finfo(float).eps


def test_a_loop_of_the_scene_replaces_the_one_of_its_name():
    own = Scene(loops=(Loop("tie", "a", (0, 0, 1)), Loop("more", "b")), gravity=(0, 0, -1))
    found = loops_of(constraint("tie", "universal", "a", "b"), constraint("pin", "ball", "a", "b"), scene=own)
    assert [each.name for each in found] == ["pin", "tie", "more"]
    assert found[1:] == own.loops
    model = robodyn.load(two_arms())
    assert robodyn.scene_of(model, own) is own
    (bare,) = loops_of(constraint("tie", "revolute", "a", "b"))
    assert bare == Loop("tie", "b", to="a", kind="hinge", axis=(1, 0, 0), to_axis=(1, 0, 0))


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (constraint("tie", "universal", "a", "b"), "type 'universal', which is no loop here (types: fixed, revolute,"),
        (constraint("tie", "ball", "a", "c"), "the child of constraint 'tie' is link 'c', which does not exist"),
        (constraint("tie", "ball", "a", "a"), "constraint 'tie' ties link 'a' to itself"),
        (constraint("tie", "ball", "a", "b") * 2, "a second constraint 'tie'"),
        (constraint("tie", "ball", "a", "b").replace('name="tie" ', ""), "<constraint> has no attribute 'name'"),
        (
            constraint("tie", "revolute", "a", "b", child_axis={"xyz": (0, 0, 0)}),
            "<child_axis> of constraint 'tie' has the",
        ),
        (constraint("tie", "ball", "a", "b", child_origin={"xyz": (0, 0)}), "has 2 numbers, not 3"),
    ],
)
def test_what_is_wrong_is_one_line_with_its_place(more, said):
    model = robodyn.load(two_arms(more))
    with pytest.raises(DescriptionError) as caught:
        robodyn.scene_of(model)
    assert said in str(caught.value)
    assert caught.value.line == 8


def test_commands_close_what_the_description_closes(tmp_path):
    """A crank-slider whose last pin is in the description moves as with a scene that has it."""
    model, scene = crank_slider()
    pin = constraint("pin", "spherical", "slider", "rod", child_origin={"xyz": (0.8, 0, 0)})
    file = tmp_path / "crank.urdf"
    file.write_bytes(model.description.data.replace(b"</robot>", pin.encode() + b"</robot>"))
    rest = 'joint_limits = "ignore"\n[initial]\nq = {main = 0.7, rail = 0.9, big_end = -0.9}\nqd = {main = 2.0}\n'
    (tmp_path / "rest.toml").write_text(rest)
    loop = '[[loop]]\nname = "pin"\nlink = "rod"\npoint = [0.8, 0, 0]\nto = "slider"\n'
    (tmp_path / "whole.toml").write_text(f"{rest}{loop}")
    (tmp_path / "open.urdf").write_bytes(model.description.data)
    results = []
    for robot, surroundings in ((file, "rest.toml"), (tmp_path / "open.urdf", "whole.toml")):
        options = ["--scene", str(tmp_path / surroundings), "--duration", "0.02", "--format", "json"]
        outcome = run("simulate", str(robot), *options)
        assert (outcome.status, outcome.err) == (0, "")
        results.append(json.loads(outcome.out))
    assert results[0]["loops"] == results[1]["loops"]
    assert results[0]["loops"]["freedoms"] == 1
    assert robodyn.scene_of(robodyn.load(file)).loops == scene.loops


def test_info_counts_them_and_reads_no_more(tmp_path):
    file = tmp_path / "arms.urdf"
    file.write_bytes(two_arms(constraint("tie", "universal", "a", "nothing")))
    outcome = run("info", str(file))
    assert outcome.status == 0
    assert "degrees of freedom: 2; of the open tree, which 1 constraint closes\n" in outcome.out
    assert json.loads(run("info", str(file), "--format", "json").out)["counts"]["loops"] == 1
    refused = run("simulate", str(file), "--duration", "1")
    assert (refused.status, refused.out) == (2, "")
    assert refused.err.startswith(f"error: {file}:8: the child of constraint 'tie' is link 'nothing', which")
