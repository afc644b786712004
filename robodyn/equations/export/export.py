"""The dynamics of a robot as source code for other programs."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Sequence
from functools import partial

import numpy as np

from robodyn.dynamics.function import KINDS
from robodyn.dynamics.plan import Plan, plan
from robodyn.equations.export.files import Job, c_file, python_file
from robodyn.errors import InputError
from robodyn.programs.export import LIBRARIES
from robodyn.robot.model import Model
from robodyn.scene.fit import check_moves, refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.files import write_whole
from robodyn.support.wording import alternatives, listed

WORDS = {kind.word: kind for kind in KINDS.values()}
TARGETS: dict[str, Callable[[Plan, Sequence[Job]], str]] = {
    "c": c_file,
    **{name: partial(python_file, library=library) for name, library in LIBRARIES.items()},
}
"""By the name that a user gives: what writes a file."""


def export(
    model: Model,
    to: str,
    what: str | Iterable[str] = "torques",
    *,
    scene: Scene = DEFAULT,
    out: str | os.PathLike[str] | None = None,
) -> str:
    """Return source code that computes the dynamics of a robot in a scene, without robodyn.

    Every target has the same operations: those of the traced recursion, with the scene folded in. No library is needed
    to write; what is written imports that of its target, and nothing else.

    Args:
        to: "c" (C99), "numpy", "casadi", "jax" or "torch" (Python modules).
        what: the functions, each of which is named as here: "torques" (what `inverse_dynamics` returns), "mass_matrix",
            "bias" (`bias_forces`), "coriolis" (`coriolis_matrix`), "forward" (`forward_dynamics`), "derivatives"
            (`inverse_dynamics_derivatives`), "forward_derivatives" (`forward_dynamics_derivatives`), "regressor";
            several as a list, or with commas.
        scene: gravity, friction and so on. Where its wrenches name columns, these are one more argument.
        out: a file to write it to as well.

    Returns:
        The text of the file. Its head says units, the order of joints, and what derivatives are by.

    Raises:
        InputError: no such target or function, nothing can move, a constant overflows, `out` cannot be written.
        SceneError: the scene does not fit the model, or closes loops.

    Accuracy: within 1e-12 of the largest result; of derivatives of the code that libraries find too.
    """
    refuse_others(model, scene)
    _check_known("target", to, TARGETS)
    words = _words(what)
    out = None if out is None else os.fspath(out)
    a_plan = plan(model, scene)
    check_moves(model)
    name, ending = os.path.splitext(os.path.basename(out or "").lower())
    if to in LIBRARIES and ending == ".py" and (name in LIBRARIES or name in sys.stdlib_module_names):
        what = f"a module of this name hides {name}, which it or what it imports needs"
        raise InputError(what, remedy="name another file", file=out)
    with np.errstate(all="ignore"):
        text = TARGETS[to](a_plan, [Job.of(WORDS[word], a_plan) for word in words])
    if out is not None:
        write_whole(out, text.encode(), remedy="name another file")
    return text


def _words(what: str | Iterable[str]) -> list[str]:
    """Return the functions that are asked for, each once."""
    asked = what.split(",") if isinstance(what, str) else what if isinstance(what, Iterable) else [what]
    words = [word.strip() if isinstance(word, str) else word for word in asked]
    for word in words:
        _check_known("function", word, WORDS)
    if not words:
        raise InputError("no function to export is named", remedy=f"functions: {listed(tuple(WORDS))}")
    return list(dict.fromkeys(words))


def _check_known(noun: str, word: str, known: Iterable[str]) -> None:
    if word not in tuple(known):
        remedy = alternatives(str(word), tuple(known), f"{noun}s")
        raise InputError(f"there is no {noun} {word!r} to export", remedy=remedy)
