"""The dynamics of a robot as one Python module, for NumPy, JAX, PyTorch or CasADi."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from robodyn.dynamics.plan import Plan
from robodyn.dynamics.regressor import parameters
from robodyn.equations.export.description import description, title
from robodyn.equations.export.job import Job
from robodyn.programs.export import Library, docstring, literal, python_function, wrapped


def python_file(plan: Plan, jobs: Sequence[Job], library: Library) -> str:
    """Return functions of a robot in a scene as the text of a module, which imports the library and nothing else.

    Raises:
        InputError: a constant overflows.

    Accuracy: within 1e-13 of robodyn's own results, relative to the largest.
    """
    signatures = [f"  {_signature(job)}: {job.meaning}" for job in jobs]
    head = [title(plan.model, f"for {library.title}"), "\n".join(["Functions:", *signatures])]
    text = "\n\n".join([*head, library.notes, description(plan, jobs)])
    constants = [
        _tuple("COORDINATES", map(ascii, plan.model.coordinates)),
        _tuple("RATES", map(ascii, plan.model.rates)),
    ]
    if any(job.name == "regressor" for job in jobs):
        names, theta = zip(*parameters(plan), strict=True)
        constants += [_tuple("PARAMETERS", map(ascii, names)), _tuple("THETA", map(literal, theta))]
    functions = [
        python_function(library, job.name, job.program, job.widths, job.shapes, _doc(job, library)) for job in jobs
    ]
    return "\n".join(
        [f"{docstring(text + chr(10))}\n", library.imports, "", *constants, library.support, "", *functions]
    )


def _signature(job: Job) -> str:
    return f"{job.name}({', '.join(job.widths)}) -> {', '.join(job.shapes)}"


def _doc(job: Job, library: Library) -> str:
    given = ", ".join(f"{source} {library.shape((width,))}" for source, width in job.widths.items())
    found = [
        f"{name} {library.shape(shape)}: {meaning}"
        for (name, _, meaning), shape in zip(job.kind.results, job.shapes.values(), strict=True)
    ]
    return "\n".join([f"Return {job.kind.meaning}.", "", f"Takes {given}; returns", *(f"{line}" for line in found), ""])


def _tuple(name: str, entries: Iterable[str]) -> str:
    return "\n".join([f"{name} = (", *wrapped(entries, 4), ")"])
