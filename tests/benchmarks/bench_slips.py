"""How many slips of people `robodyn check` names: `cd tests && python -m benchmarks.bench_slips`.

Those of `helpers/planted_slips.py`, by group and half of the robots; below them the kinds of which not all are named.
With `--unseen 1` it prints instead which ones are not named or have something reported beside them, for
`data/unseen_slips.txt`; with `--rules 1` it writes the rules that name the others into `data/planted_slips.json`.
"""

from __future__ import annotations

import json

from helpers.markdown_tables import main, table
from helpers.planted_slips import FILE, HARMLESS, NAMED, NEAR, UNSEEN, Outcome, Slip, outcome, slips

Judged = list[tuple[Slip, Outcome]]
_HEADS = tuple(f"{half}: {head}" for half in "AB" for head in ("planted", "named", "place only", "unseen", "elsewhere"))


def slips_table(found: Judged) -> str:
    groups = dict.fromkeys(slip.group for slip, _ in found)
    rows = [(group, _kinds(each), *_counts(each)) for group in groups if (each := _of(found, group))]
    defects = [one for one in found if one[0].group != HARMLESS]
    rows.append(("all defects", _kinds(defects), *_counts(defects)))
    return table(("group", "kinds", *_HEADS), rows)


def kinds_table(found: Judged) -> str:
    """Return the kinds of which not all are named."""
    rows = []
    for group, kind in dict.fromkeys((slip.group, slip.kind) for slip, _ in found if slip.group != HARMLESS):
        own = [one for one in found if one[0].kind == kind]
        if any(judged.verdict != NAMED for _, judged in own):
            rows.append((kind, group, *_counts(own)))
    return table(("not always named", "group", *_HEADS), rows, left=(0, 1))


def _of(found: Judged, group: str) -> Judged:
    return [one for one in found if one[0].group == group]


def _kinds(found: Judged) -> str:
    return str(len({slip.kind for slip, _ in found}))


def _counts(found: Judged) -> list[str]:
    columns: list[str] = []
    for half in "AB":
        own = [(slip, one) for slip, one in found if slip.half == half]
        verdicts = [one.verdict for slip, one in own if slip.group != HARMLESS]
        counts = [len(own), *(verdicts.count(verdict) for verdict in (NAMED, NEAR, UNSEEN))]
        columns += [str(count or "-") for count in (*counts, sum(bool(one.elsewhere) for _, one in own))]
    return columns


def unseen_ones(found: Judged) -> str:
    """Return the slips that are not named, and the changes that something is said of."""
    return "".join(
        f"{slip}\n" for slip, one in found if (bool(one.elsewhere) if slip.group == HARMLESS else one.verdict != NAMED)
    )


def with_rules(found: Judged) -> str:
    """Return the slips as they are written, each with the rule that names it."""
    rows = (json.dumps({**slip._asdict(), "rule": one.rule}) for slip, one in found)
    return "[\n" + ",\n".join(rows) + "\n]\n"


def report(unseen: int, rules: int) -> str:
    found = [(slip, outcome(slip)) for slip in slips()]
    if rules:
        FILE.write_text(with_rules(found), encoding="utf-8")
    return unseen_ones(found) if unseen else f"{slips_table(found)}\n{kinds_table(found)}"


if __name__ == "__main__":
    main(report, __doc__ or "", unseen=0, rules=0)
