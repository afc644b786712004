"""The dynamics of a robot as one C99 file: declarations behind a guard, then the functions."""

from __future__ import annotations

from collections.abc import Sequence

from robodyn.dynamics.plan import Plan
from robodyn.dynamics.regressor import parameters
from robodyn.equations.export.description import description, title
from robodyn.equations.export.job import Job
from robodyn.equations.ode import identifier, identifiers
from robodyn.programs.export import c_function, comment, literal, prototype
from robodyn.robot.model import Model


def c_file(plan: Plan, jobs: Sequence[Job]) -> str:
    """Return functions of a robot in a scene as the text of a C99 file.

    Returns:
        ASCII text; it includes <math.h> and nothing else, and compiles without warnings as C99 and as C++.

    Raises:
        InputError: a constant overflows.

    Accuracy: within 1e-13 of robodyn's own results, relative to the largest.
    """
    prefix = identifier(plan.model.name, "robot").lower()
    theta = list(parameters(plan)) if any(job.name == "regressor" for job in jobs) else []
    heads = [_head(f"{prefix}_{job.name}", job) for job in jobs]
    bodies = [c_function(f"{prefix}_{job.name}", job.program, job.widths, job.sizes) for job in jobs]
    if theta:
        array = f"const double {prefix}_theta[{len(theta)}]"
        names = "".join(f"\n   {comment(name)}" for name, _ in theta)
        heads.append(f"/* the parameters, in the order of the columns of Y:{names} */\nextern {array};")
        bodies.append(f"{array} = {{\n" + "".join(f"    {literal(value)},\n" for _, value in theta) + "};\n")
    text = (
        f"{title(plan.model, 'in C')}\n\n{description(plan, jobs)}\n\n"
        "Matrices are in row-major order. An array that is written to may be one that is read.\n"
        f"For declarations alone define {prefix.upper()}_DECLARATIONS_ONLY before including this file."
    )
    top = ["/*", *(f" * {line}".rstrip() for line in comment(text).split("\n")), " */"]
    return "\n".join([*top, _guarded(plan.model, prefix, heads), _implementation(prefix, bodies)])


def _head(name: str, job: Job) -> str:
    results = "".join(f"\n   {result.name}: {result.meaning}" for result in job.kind.results)
    return f"/* {job.meaning}{results} */\n{prototype(name, job.widths, job.sizes)};"


def _guarded(model: Model, prefix: str, heads: Sequence[str]) -> str:
    guard = f"{prefix.upper()}_DYNAMICS_H"
    return "\n".join(
        [
            f"#ifndef {guard}",
            f"#define {guard}",
            "",
            f"#define {prefix.upper()}_NQ {model.nq}",
            f"#define {prefix.upper()}_N {model.n}",
            "",
            "/* places of the coordinates in q, and of their rates in qd, qdd and tau */",
            _enumerated(f"{prefix}_q", model.coordinates),
            _enumerated(f"{prefix}_qd", model.rates),
            "",
            "#ifdef __cplusplus",
            'extern "C" {',
            "#endif",
            *heads,
            "#ifdef __cplusplus",
            "}",
            "#endif",
            "",
            f"#endif /* {guard} */",
            "",
        ]
    )


def _enumerated(prefix: str, names: Sequence[str]) -> str:
    places = enumerate(identifiers(names, "joint"))
    return "enum {\n" + ",\n".join(f"    {prefix}_{name}".upper() + f" = {k}" for k, name in places) + "\n};"


def _implementation(prefix: str, bodies: Sequence[str]) -> str:
    condition = f"{prefix.upper()}_DECLARATIONS_ONLY"
    return "\n".join([f"#ifndef {condition}", "#include <math.h>", "", *bodies, f"#endif /* {condition} */", ""])
