"""Meshes are closed, wound outwards, free of overlaps, and their coordinates are numbers.

Mass and signed distance need a surface that encloses a volume. Reported are
coordinates that are no numbers; shells wound inwards that are no cavities; STL files that hold more triangles than
their header counts; surfaces with one side only; faces wound against their neighbours; open edges, by the
boundary chain; and shells that reach into another, as far as a few points of each show. The last is a remark; the
three before it are a warning where a link takes its mass from the mesh, being a <collision> of one without <inertial>,
and remarks otherwise: MuJoCo and Drake collide with the convex hull, and others with the triangles.
Of an open surface it is said, with the numbers that `robodyn inertia` goes by, whether its gaps are small enough to be
filled, a remark then, or what is missing. The bad example stands beside a file `open.stl`, a box without lid; the good
one beside `closed.stl`.
"""

from robodyn.checks.examples import a_mesh
from robodyn.checks.meshes.facts import MeshFacts
from robodyn.checks.meshes.files import MeshName, State, all_facts, mesh_names
from robodyn.checks.rule import Context, Faults, Severity, rule
from robodyn.support.wording import figure

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
    """Return what is wrong, worst first; what only the mass of it shows is a remark where nothing takes that."""
    if not facts.finite:
        return f"has a coordinate that is no number: {facts.problem}", Severity.WARNING
    if facts.inverted:
        inside_out = "is inside out" if facts.volume < 0 else f"has {facts.inverted} shells that are inside out"
        return inside_out, Severity.WARNING
    if facts.doubt:
        return f"may not be whole: {facts.doubt}", Severity.WARNING
    what, severity = None, Severity.WARNING if name.gives_mass else Severity.NOTE
    if facts.one_sided:
        what = f"has {facts.one_sided} faces in surfaces with one side only: it encloses nothing"
    elif facts.mixed:
        what = "has faces wound against their neighbours"
    elif not facts.closed and facts.problem is None:
        what, severity = _gaps(facts), severity if facts.left or facts.mended is None else Severity.NOTE
    elif facts.overlapping:
        what = "has shells that overlap: what they share counts twice where they are not united"
        severity = Severity.NOTE
    return None if what is None else (what, severity)


def _gaps(facts: MeshFacts) -> str:
    if facts.left:
        share = figure(100 * facts.missing, 2)
        return f"is not closed: {share} % of its surface is missing, in gaps that are too large to be filled"
    if facts.mended:
        return f"is open by small gaps only ({facts.mended}): filled, it encloses a volume"
    return "is not closed" if facts.mended is None else "is closed but for faces without area, or given twice"
