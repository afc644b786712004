"""`linearize`: the state, the modes in words, and whether it is stable."""

from __future__ import annotations

from cmath import phase
from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import ceil, inf, log10, pi

import numpy as np

from robodyn.equations.linearized.linearize import Linearized
from robodyn.equations.linearized.modes import Mode
from robodyn.equations.ode import units_of
from robodyn.report import document as doc
from robodyn.report.charts import plane_chart
from robodyn.report.limits import exceeded_words
from robodyn.report.table import number
from robodyn.support.wording import count

_SAME = 0.1
"""Of half a turn: how far a phase may be from in step or against."""
_PICTURED = 12
"""Modes that move in the page, the slowest."""
_PRINTED = 60
"""States of which a page has A and B as tables, at most."""
_TURN, _SHIFT = 0.35, 0.15
"""rad, and parts of the robot's size: how far the joints go at most in the picture of a mode."""


def linearized_sections(found: Linearized, tabled: int = 16) -> Iterator[doc.Section]:
    """Yield the state and what holds it, the modes, A and B of at most so many states, and the verdict."""
    verdict, modes = stability(found), found.modes.modes
    how = "an equilibrium" if found.balanced else "the state given"
    sizes = f"{count(len(found.states), 'state')}, {count(len(found.inputs), 'input')}"
    lines = [f"{found.robot}: linear about {how}, {sizes}"]
    if found.held.any() and not found.motion.at_rest:
        lines.append("the torques added keep its speeds constant; they stay as they are in the linear equations")
    elif found.held.any():
        lines.append("it is no equilibrium: torques added hold it; --equilibrium looks for a state without them")
    if found.step is not None:
        step = f"steps of {found.step:.6g} s, inputs held in between"
        lines.append(f"A and B are those of {step}; modes are those of A before")
    yield doc.paragraphs(lines)
    names, floating = found.model.coordinates, len(found.q) - len(found.qd)
    state = [(name, f"{x:.6g}", "", "", "", "") for name, x in zip(names[: 7 * floating], found.q, strict=False)]
    largest = float(max(abs(found.held).max(initial=0.0), abs(found.drive).max(initial=0.0)))
    for k, (name, unit) in enumerate(zip(found.model.rates, units_of(found.model), strict=True)):
        position = "" if k < 6 * floating else f"{found.q[k + floating]:.6g}"
        drive, added = (number(float(each[k]), largest) for each in (found.drive, found.held))
        state.append((name, position, f"{found.qd[k]:.6g}", drive, added, unit))
    yield [doc.Table("State", ("joint", "q", "qd", "drive", "torque added", "unit"), state)]
    rows = []
    for mode in modes:
        value = f"{0.0 if mode.undecided else mode.real:.4g}" + (f" +- {mode.imag:.4g}i" if mode.oscillates else "")
        waves = [f"{mode.frequency:.4g}", f"{mode.damping_ratio:.3g}"] if mode.oscillates else ["-", "-"]
        time = "-" if mode.time_constant == inf else f"{mode.time_constant:.4g}"
        rows.append([_kind(mode), *waves, time, value, moves(found.model.rates, mode)])
    error = max((mode.error for mode in modes), default=0.0)
    above = f"1e{ceil(log10(error)):03d}" if error else "0"  # its digits are the processor's
    note = f"Eigenvalues are within {above} /s. What moves: rad or m of each joint per 1 of the first."
    head = ("mode", "frequency [Hz]", "damping ratio", "time constant [s]", "eigenvalue [1/s]", "what moves")
    yield [doc.Table("Modes, the slowest first", head, rows, note)]
    if len(found.states) > tabled:
        yield doc.paragraphs(["A and B are in --out FILE.npz and --format json."])
    elif found.states:
        law = "x' = A x + B u" if found.step is None else f"x(t + {found.step:.6g} s) = A x(t) + B u"
        for name, M, over in (("A", found.A, found.states), ("B", found.B, found.inputs)):
            half = len(M) // 2
            scales = [abs(part).max(initial=0.0) for part in (M[:half], M[half:])]
            cells = [[number(x, scales[k >= half]) for x in row] for k, row in enumerate(M.tolist())]
            rows = [[state, *row] for state, row in zip(found.states, cells, strict=True)]
            yield [doc.Table(f"{name} of {law}", ("", *over), rows)]
    yield doc.remarks("warning", found.warnings)
    yield doc.paragraphs([f"{verdict.headline}.", *verdict.reasons])


def linearized_page(found: Linearized, pictures: bool = True) -> doc.Document:
    """Return whether it is stable, its modes moving, their poles, and A and B in full."""
    blocks: list[doc.Block] = [stability(found)]
    modes = found.modes.modes
    if pictures and modes:
        from robodyn.report import stage

        size = found.model.reach or 1.0
        shown = stage.robot(found.model, [_swing(found, k, size) for k in range(min(len(modes), _PICTURED))])
        words = (
            f"The robot in its modes, enlarged to {_TURN} rad or {number(_SHIFT * size)} m at most; "
            "each plays in 5 s, and the clock is that of the mode"
        )
        some = [f"The slowest {_PICTURED} of {len(modes)} modes move."] if len(modes) > _PICTURED else []
        blocks += [
            doc.Heading("Modes"),
            stage.stage(words, [shown], loop=True),
            *doc.paragraphs(some),
            _pole_map(found),
        ]
    files, how = [("linear.json", linearized_json(found))], "robodyn linearize --format json prints it"
    what = "Linear equations near a state, and modes"
    *sections, _ = linearized_sections(found, _PRINTED)  # the last is the verdict
    return doc.page(found.robot, what, blocks, sections, "Mode", files, how)


def _named(found: Linearized, k: int) -> str:
    mode = found.modes.modes[k]
    swings = f" at {mode.frequency:.4g} Hz" if mode.oscillates else ""
    return f"mode {k + 1}: {_kind(mode)}{swings}; {moves(found.model.rates, mode)}"


def _pole_map(found: Linearized) -> doc.Chart:
    """Return the eigenvalues in the complex plane, by whether they decay; the half where they grow is shaded."""
    dots: dict[str, tuple[list[float], list[float]]] = {}
    names: dict[str, list[str]] = {}
    for k, mode in enumerate(found.modes.modes):
        group = "neither" if mode.undecided else "grows" if mode.real > 0.0 else "decays"
        for imag in (mode.imag, -mode.imag)[: 1 + mode.oscillates]:
            x, y = dots.setdefault(group, ([], []))
            x.append(0.0 if mode.undecided else mode.real)
            y.append(imag)
            names.setdefault(group, []).append(_named(found, k))
    counts = ", ".join(f"{len(each)} {how}" for how, each in names.items())
    return plane_chart(
        f"Poles: eigenvalues of A{' in continuous time' if found.step else ''}; where the plane is shaded, modes grow",
        f"Eigenvalues in the complex plane: {counts}; the table of modes has their values",
        "real part [1/s]",
        "imaginary part [rad/s]",
        dots={how: (np.array(x), np.array(y)) for how, (x, y) in dots.items()},
        names=names,
        colours={"decays": "good", "grows": "bad", "neither": "doubtful"},
        spans=[(0.0, 1e300, "grows")],
    )


def _swing(found: Linearized, k: int, size: float) -> dict[str, object]:
    """Return the motion of a mode by itself, so large that it can be seen: some periods, or four time constants."""
    from robodyn.dynamics.loops.closure import moved
    from robodyn.report import stage

    mode, model = found.modes.modes[k], found.model
    most = np.full(model.n, _TURN)
    for joint in model.independent:
        if joint.kind != "revolute":
            most[slice(joint.rate + 3, joint.rate + 6) if joint.kind == "floating" else joint.rate] = _SHIFT * size
    far = np.abs(mode.shape) / most
    first = mode.shape[int(np.argmax(far >= far.max() * (1.0 - 1e-6)))]
    way = np.array(mode.shape) * np.conj(first) / ((abs(first) or 1.0) * (far.max() or 1.0))
    rate = complex(0.0 if mode.undecided else mode.real, mode.imag if mode.oscillates else 0.0)
    if mode.oscillates:
        period = 2.0 * pi / mode.imag
        time = np.linspace(0.0, period * ceil(min(max(2.0 * mode.time_constant / period, 2.0), 5.0)), 241)
    else:
        time = np.linspace(0.0, 1.0 if mode.undecided else 4.0 * mode.time_constant, 61)
    course = np.exp(rate * time) if rate else np.linspace(-1.0, 1.0, len(time)) + 0j  # what nothing holds goes on
    steps = np.outer(course / np.abs(course).max(), way).real
    q = np.array([moved(model, found.q.tolist(), step.tolist()) for step in steps], dtype=float).T
    return stage.motion(_named(found, k), time, [each if np.ptp(each) else [float(each[0])] for each in q])


def stability(found: Linearized) -> doc.Verdict:
    """Return whether the robot comes back after a small push, and how soon or how fast it goes."""
    modes, how = found.modes.modes, found.modes.verdict
    free = sum(mode.free for mode in modes)
    steady = sum(mode.undecided and not mode.free for mode in modes)
    words = [f"{count(free, 'mode is', 'modes are')} held by nothing"] if free else []
    words += [f"{count(steady, 'mode is', 'modes are')} not damped within rounding"] if steady else []
    verdict = doc.Verdict("doubtful", f"Neither stable nor unstable: {' and '.join(words)}")
    if how == "moving":
        said = "No verdict on stability: the state moves"
        verdict = doc.Verdict("neutral", said, ("The modes are those of this instant.",))
    elif how == "unstable":
        fastest = max(modes, key=lambda mode: mode.real).time_constant
        some = count(sum(mode.real > mode.error for mode in modes), "mode grows", "modes grow")
        verdict = doc.Verdict("bad", f"Unstable: {some}", (f"The fastest grows by a factor of e in {fastest:.4g} s.",))
    elif how == "stable":
        margin = found.modes.margin
        assert margin is not None, "there are modes, and all are held"
        slowest = f"The slowest decays to 1/e in {1 / margin:.4g} s, a margin of {margin:.4g} /s."
        verdict = doc.Verdict("good", "Stable: every small push dies away", (slowest,))
    if found.exceeded:
        what = "The equilibrium is" if found.balanced else "The state is"
        reasons = (*map(exceeded_words, found.exceeded), f"Without limits: {verdict.headline}.", *verdict.reasons)
        return doc.Verdict("bad", f"{what} beyond limits: the robot cannot stay there", reasons)
    if not found.held.any() or not found.motion.at_rest:
        return verdict
    return replace(verdict, reasons=(*verdict.reasons, "That is so while the torques added stay as they are."))


def _kind(mode: Mode) -> str:
    if mode.free:
        return "held by nothing"
    grows = mode.real > 0.0 and not mode.undecided
    if mode.oscillates:
        return "oscillates and grows" if grows else "oscillates, undamped" if mode.undecided else "oscillates"
    return "undecided" if mode.undecided else "grows" if grows else "decays"


def moves(names: Sequence[str], mode: Mode) -> str:
    """Return which joints move how much, in step or against each other, those with most kinetic energy first."""
    order = sorted(range(len(names)), key=lambda k: (mode.shape[k] != 1.0, -round(mode.shares[k], 6), k))
    least = 0.05 * max(map(abs, mode.shape))  # less is not named
    shown = [k for k in order if k == order[0] or (abs(mode.shape[k]) >= least and mode.shares[k] > 0)][:4]
    words: list[str] = []
    for k in shown:
        angle = phase(mode.shape[k]) if words else 0.0
        how = f" {'ahead' if angle > 0 else 'behind'} by {abs(angle) * 180 / pi:.0f} deg"
        if abs(angle) <= _SAME * pi or abs(angle) >= (1 - _SAME) * pi:
            how = " against" if abs(angle) > pi / 2 else ""
        words.append(f"{names[k]} {abs(mode.shape[k]):.3g}{how}")
    return ", ".join(words) + ("; any mixture with its like" if mode.alike else "")


def linearized_json(found: Linearized) -> str:
    """Return A and B by rows, the state, and the modes; `stable` is null where it is not decided, see `verdict`."""
    modes = []
    for mode in found.modes.modes:
        shape = {"real": [x.real for x in mode.shape], "imag": [x.imag for x in mode.shape]}
        keys = "frequency damping_ratio time_constant? real imag error free alike shape shares"
        modes.append(doc.select(mode, keys, shape=shape))
    return doc.written(
        doc.select(
            found,
            "robot states inputs A B step equilibrium modes stable verdict "
            "margin:modes.margin limits_exceeded:exceeded warnings",
            equilibrium=doc.select(
                found, "is_one:balanced coordinates:model.coordinates q rates:model.rates qd drive added:held"
            ),
            modes=modes,
        )
    )
