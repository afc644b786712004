"""Files of parameters with their covariance."""

from __future__ import annotations

import json

import numpy as np
import pytest

from robodyn.errors import SceneError
from robodyn.scene.uncertainty import Covariance, covariance_json, read_covariance


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
        ({"values": [1, "x"]}, "no numbers"),
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
    path.write_text(json.dumps(GOOD | change))
    with pytest.raises(SceneError, match=what):
        read_covariance(path)


def test_what_cannot_be_read_is_one_line(tmp_path):
    path = tmp_path / "covariance.json"
    with pytest.raises(SceneError, match="cannot be read"):
        read_covariance(path)
    path.write_bytes(b"{")
    with pytest.raises(SceneError, match="is not JSON"):
        read_covariance(path)
