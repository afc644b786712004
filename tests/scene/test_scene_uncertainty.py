"""[uncertainty] of a scene: standard deviations with their units, and covariances; each wrong value in one line."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from helpers.oracles import robot

from robodyn.dynamics.regressor import variations
from robodyn.errors import SceneError
from robodyn.scene.read import load_scene, parse_scene
from robodyn.scene.uncertainty import (
    Covariance,
    Deviation,
    LinkUncertainty,
    Uncertainty,
    covariance_json,
    read_covariance,
)


def uncertainty(text):
    return parse_scene(f"[uncertainty]\n{text}".encode()).uncertainty


def test_every_key():
    found = uncertainty(
        'mass = "5 %"\ncom = "3 mm"\ninertia = "1e-3 kg m^2"\nfriction = "20%"\n'
        '[uncertainty.link.forearm]\nmass = "100 g"\ncom = "0.2 cm"\n'
        '[uncertainty.joint.elbow]\nfriction = "0.5 N*m"\n'
    )
    assert found == Uncertainty(
        mass=Deviation(0.05),
        com=Deviation(0.003, relative=False),
        inertia=Deviation(1e-3, relative=False),
        friction=Deviation(0.2),
        link={"forearm": LinkUncertainty(Deviation(0.1, relative=False), Deviation(0.002, relative=False))},
        joint={"elbow": Deviation(0.5, relative=False)},
    )


def test_what_a_link_does_not_say_all_links_say():
    found = uncertainty('mass = "5 %"\ninertia = "10 %"\n[uncertainty.link.a]\nmass = "0 %"\n')
    assert found.of_link("a") == LinkUncertainty(Deviation(0.0), None, Deviation(0.1))
    assert found.of_link("b") == LinkUncertainty(Deviation(0.05), None, Deviation(0.1))
    assert parse_scene(b"gravity = [0, 0, -1]").uncertainty is None


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("mass = 0.05", '"mass" is 0.05, not a standard deviation with its unit'),
        ('mass = "5"', 'write mass = "5 %" or mass = "5 kg"'),
        ('mass = "-5 %"', "not a standard deviation"),
        ('com = "3 kg"', 'write com = "5 %" or com = "5 m"'),
        ('mass = "1e999 kg"', "not a standard deviation"),
        ('weight = "5 %"', 'unknown key "weight"'),
        ('[uncertainty.link.a]\nfriction = "5 %"', "[uncertainty.link.a]"),
        ('[uncertainty.joint.a]\nmass = "5 %"', "[uncertainty.joint.a]"),
        ('mass = "5 %"\ncovariance = "a.json"', "leave one of them out"),
        ('covariance = "missing.json"', "missing.json"),
    ],
)
def test_what_is_wrong_is_said(text, said):
    with pytest.raises(SceneError, match=re.escape(said)):
        uncertainty(text)


def covariance(folder, names, rows):
    data = {"parameters": names, "values": [5.0, 1.0], "covariance": rows}
    (folder / "found.json").write_text(json.dumps(data))
    (folder / "scene.toml").write_text('[uncertainty]\ncovariance = "found.json"\n')
    return load_scene(folder / "scene.toml")


def test_a_covariance_lies_beside_the_scene(tmp_path):
    names, rows = ("forearm.m", "elbow.viscous"), ((0.04, 0.01), (0.01, 0.09))
    scene = covariance(tmp_path, names, rows)
    assert scene.uncertainty == Uncertainty(covariance=Covariance(names, np.array((5.0, 1.0)), np.array(rows)))
    again = covariance(tmp_path, names, rows)
    assert (scene, hash(scene)) == (again, hash(again))
    assert scene != covariance(tmp_path, names, ((0.04, 0.0), (0.0, 0.09)))
    drawn = variations(robot("puma560"), scene)
    assert tuple(each.name for each in drawn.each) == names
    assert (drawn.factor @ drawn.factor.T)[0, 1] == pytest.approx(0.01 / 0.06, rel=1e-12)


def test_a_covariance_of_other_parameters(tmp_path):
    scene = covariance(tmp_path, ["forearm.mm", "elbow.viscous"], [[1, 0], [0, 1]])
    with pytest.raises(SceneError, match=r"did you mean 'forearm\.m'"):
        variations(robot("puma560"), scene)
    with pytest.raises(SceneError, match="leaves nothing uncertain"):
        variations(robot("puma560"), parse_scene(b'[uncertainty]\nmass = "0 %"\n'))


def test_it_reads_back_to_the_bit(tmp_path):
    rng = np.random.default_rng(0)
    factor = rng.normal(size=(4, 4)) * np.array((1e-9, 1.0, 1e3, 0.0))[:, None]
    known = Covariance(("a.m", "a.mx", "j.viscous", "j.rotor"), rng.normal(size=4), factor @ factor.T)
    path = tmp_path / "covariance.json"
    path.write_bytes(covariance_json(known))
    again = read_covariance(path)
    assert again.parameters == known.parameters
    assert again.values.tolist() == known.values.tolist()
    assert again.covariance.tolist() == known.covariance.tolist()
    assert set(json.loads(path.read_text())) == {"parameters", "values", "covariance"}


GOOD = {"parameters": ["a", "b"], "values": [1, 2], "covariance": [[1, 0], [0, 1]]}


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"values": [1]}, "values of shape"),
        ({"values": [1, [2]]}, "no numbers"),
        ({"values": [1, None]}, "not finite"),
        ({"parameters": ["a", "a"]}, "1 parameters twice"),
        ({"parameters": "ab"}, "no list of names"),
        ({"covariance": [[1, 0.5], [0, 1]]}, "not symmetric"),
        ({"covariance": [[-1, 0], [0, 1]]}, "negative"),
        ({"covariance": [[1, 2], [2, 1]]}, "semidefinite"),
        ({"more": 1}, "just the keys"),
    ],
)
def test_what_is_no_covariance_is_refused(tmp_path, change, what):
    path = tmp_path / "covariance.json"
    with pytest.raises(SceneError, match="cannot be read"):
        read_covariance(path)
    path.write_bytes(b"{")
    with pytest.raises(SceneError, match="is not JSON"):
        read_covariance(path)
    path.write_text(json.dumps(GOOD | change))
    with pytest.raises(SceneError, match=what):
        read_covariance(path)
