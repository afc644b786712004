"""The descriptions of robots/: they load everywhere, say where they come from, and carry the reference parameters."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.peers import pin
from helpers.robot_files import FOLDER, NAMES, REFERENCE, model

from robodyn.robot.load import load_description

SAME_PARAMETERS = {
    "puma": "puma_3r",
    "puma560": "puma560_corke",
    "scara": "scara_rrp",
    "cylindrical": "cylindrical_rppp",
    "satellite": "satellite_two_arrays_fixed_bus",
}


@pytest.mark.parametrize("name", NAMES)
def test_pinocchio_agrees_on_joints_and_mass_and_joints_have_limits(name):
    ours, oracle = load_description(FOLDER / f"{name}.urdf"), model(name)
    assert ours.name == name
    assert {joint.name for joint in ours.joints if joint.type != "fixed"} == set(oracle.names) - {"universe"}
    assert ours.notes == ()
    for joint in ours.joints:
        if joint.type not in ("fixed", "floating"):
            assert min(joint.limit.effort, joint.limit.velocity) > 0
            assert joint.type == "continuous" or joint.limit.lower < joint.limit.upper
    masses = [link.inertial.mass for link in ours.links if link.inertial]
    assert sum(masses) == pytest.approx(pin.computeTotalMass(oracle) + oracle.inertias[0].mass, rel=1e-15)


@pytest.mark.parametrize(("name", "reference"), SAME_PARAMETERS.items())
def test_parameters_are_those_of_the_reference(name, reference):
    ours, theirs = model(name), pin.buildModelFromUrdf(str(REFERENCE / "urdf" / f"{reference}.urdf"))
    assert ours.njoints == theirs.njoints
    for i in range(1, ours.njoints):
        assert ours.parents[i] == theirs.parents[i]
        assert ours.joints[i].shortname() == theirs.joints[i].shortname()
        np.testing.assert_array_equal(ours.jointPlacements[i].homogeneous, theirs.jointPlacements[i].homogeneous)
        assert ours.inertias[i].mass == theirs.inertias[i].mass
        np.testing.assert_allclose(ours.inertias[i].lever, theirs.inertias[i].lever, rtol=0, atol=1e-52)
        np.testing.assert_allclose(ours.inertias[i].inertia, theirs.inertias[i].inertia, rtol=0, atol=1e-51)
