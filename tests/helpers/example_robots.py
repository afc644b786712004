"""The robots of example-robot-data as tests of dynamics need them."""

from __future__ import annotations

import importlib.metadata
from functools import cache
from pathlib import Path

from robodyn.robot.load import load

LARGE = ("tiago", "talos", "icub", "g1_29dof", "centauro", "alex", "romeo", "pr2")
"""Beginnings of the names of robots with 30 joints and more, which take seconds each; one of them stands for them."""
VARIANTS = ("alex_sake_hands", "g1_29dof_rev_1_0", "icub_reduced", "romeo_small", "romeo_laas_small", "tiago_dual")
VARIANTS += ("tiago_no_hand", "tiago_pro", "talos_full_v2_box", "talos_reduced_box", "talos_reduced_corrected")
"""Large robots that differ little from another; where one takes seconds the other stands for it."""
REFUSED = {
    "alex_psyonic_hands.urdf": "a mimic joint follows a joint that does not exist",
    "ur3.urdf": "an empty <robot>",
}
"""Files that no reader can use, and why."""


def all_paths():
    files = importlib.metadata.files("example-robot-data") or []
    return sorted(Path(str(file.locate())) for file in files if file.suffix == ".urdf")


PATHS = [path for path in all_paths() if path.name not in REFUSED]
LARGE_ONES = {path.stem for path in PATHS if path.stem.startswith(LARGE)} - {"talos_full_v2"}
"""Those that one stands for where each takes ten seconds."""


def cases(leave_out=()):
    """The robots as parameters of a test, the large ones among the slow."""
    import pytest

    for path in PATHS:
        if path.stem not in leave_out:
            slow = path.stem.startswith(LARGE) and path.stem != "talos_full_v2"
            yield pytest.param(path, id=f"{path.parent.parent.name}-{path.stem}", marks=[pytest.mark.slow] * slow)


def path_of(stem):
    return next(path for path in PATHS if path.stem == stem)


KINDS = ("ur5_robot", "panda", "anymal", "allegro_left_hand")
"""An arm, slides that mimic, legs under a trunk, a hand that branches: by default they stand for all."""
MORE_KINDS = ("xarm7", "so101", "double_pendulum_continuous", "hextilt_flying_arm_5", "baxter", "simple_humanoid")
MORE_KINDS += ("talos_full_v2", "g1_29dof_with_hand_rev_1_0")


def kinds():
    """Twelve robots of every kind as parameters of a test, most of them among the slow."""
    import pytest

    slow = [pytest.param(path_of(stem), id=stem, marks=pytest.mark.slow) for stem in MORE_KINDS]
    return [*(pytest.param(path_of(stem), id=stem) for stem in KINDS), *slow]


@cache
def real(stem, moving_base=False):
    return load(path_of(stem), moving_base=moving_base)
