"""Meshes are closed, wound outwards, free of overlaps, and their coordinates are numbers.

Mass, signed distance and many collision engines need a surface that encloses a volume. Reported are
coordinates that are no numbers; shells wound inwards that are no cavities; STL files that hold more triangles than
their header counts; surfaces with one side only; faces wound against their neighbours; open edges, by the
boundary chain; and shells that reach into another, as far as a few points of each show. The last is a remark; the
three before it are one where a mesh is only a <visual>, and a warning in a <collision>. The bad example stands beside a
file `open.stl`, a box without lid; the good one beside `closed.stl`.
"""

from robodyn.checks.examples import a_mesh
from robodyn.checks.meshes.facts import MeshFacts
from robodyn.checks.meshes.files import MeshName, State, all_facts, mesh_names
from robodyn.checks.rule import Context, Faults, Severity, rule

_REMEDY = "repair it where mass, collision or simulation is computed from it; `robodyn inertia` says what to do"


@rule(Severity.WARNING, good=a_mesh("closed.stl"), bad=("closed", "open"))
def check(context: Context) -> Faults:
    for uri, facts in context.once(all_facts).items():
        name = context.once(mesh_names)[uri]
        found = _wrong(facts, name)
        if found is None or name.state is State.OTHER_CASE:
            continue
        what, severity = found
        yield name.fault(what, _REMEDY, severity)


def _wrong(facts: MeshFacts, name: MeshName) -> tuple[str, Severity] | None:
    """Return what is wrong, worst first; what hardly shows is a remark where the mesh is only looked at."""
    if not facts.finite:
        return f"has a coordinate that is no number: {facts.problem}", Severity.WARNING
    if facts.inverted:
        inside_out = "is inside out" if facts.volume < 0 else f"has {facts.inverted} shells that are inside out"
        return inside_out, Severity.WARNING
    if facts.doubt:
        return f"may not be whole: {facts.doubt}", Severity.WARNING
    what, severity = None, Severity.NOTE if name.is_seen_only else Severity.WARNING
    if facts.one_sided:
        what = f"has {facts.one_sided} faces in surfaces with one side only: it encloses nothing"
    elif facts.mixed:
        what = "has faces wound against their neighbours"
    elif not facts.closed and facts.problem is None:
        what = "is not closed: it encloses no definite volume"
    elif facts.overlapping:
        what, severity = "has shells that overlap: what they share counts twice", Severity.NOTE
    return None if what is None else (what, severity)
