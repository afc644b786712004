"""The tables, the charts and the page of `benchmarks.compare`."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np
from benchmarks.libraries import ALGORITHMS, BLOCK, CALLS, CHECKED, NUMBERS, OURS, TURN
from benchmarks.published import PUBLISHED
from helpers.markdown_tables import table

from robodyn.report import document as doc
from robodyn.report.charts import COLOURS, plane_chart

WAYS = {"block": "blocks", "one": "one a call"}


def time_text(seconds: float) -> str:
    """Nanoseconds with three digits."""
    value = 1e9 * seconds
    return f"{value:.0f}" if value >= 99.95 else f"{value:#.3g}"


def spread_text(found: Mapping[str, Any] | None) -> str:
    """A median [ns], and half of what is between the quartiles in percent of it."""
    if found is None:
        return "-"
    seconds = found["seconds"]
    percent = 50.0 * (seconds["high"] - seconds["low"]) / seconds["median"]
    return f"{time_text(seconds['median'])} ±{percent:.0f}%"


class Tables:
    """The tables of a comparison."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        self.data = data
        self.by = {(x["robot"], x["algorithm"], x["library"], x["way"]): x for x in data["results"]}
        self.cases = list(dict.fromkeys((x["robot"], x["joints"], x["algorithm"]) for x in data["results"]))
        self.libraries = list(data["versions"])
        self.ours = [title for title in self.libraries if title.startswith("robodyn")]

    def times(self, way: str, caption: str, note: str) -> list[doc.Table]:
        """A row for each robot and algorithm, a column for each library that has any of them."""
        rows = {case: [self.by.get((*case[::2], title, way)) for title in self.libraries] for case in self.cases}
        rows = {case: found for case, found in rows.items() if any(found)}
        columns = [k for k in range(len(self.libraries)) if any(found[k] for found in rows.values())]
        cells = [
            [f"{robot}, {algorithm}", str(joints), *(spread_text(found[k]) for k in columns)]
            for (robot, joints, algorithm), found in rows.items()
        ]
        head = ["robot", "joints", *(self.libraries[k] for k in columns)]
        return [doc.Table(f"{caption} [ns]", head, cells, note)] if cells else []

    def errors(self) -> doc.Table:
        def cell(robot: str, algorithm: str, title: str) -> str:
            found = [self.by.get((robot, algorithm, title, way)) for way in ("one", "block")]
            return f"{max(x['error'] for x in found if x):.0e}" if any(found) else "-"

        rows = [
            [f"{robot}, {algorithm}", *(cell(robot, algorithm, title) for title in self.libraries)]
            for robot, _, algorithm in self.cases
        ]
        note = "Errors far above rounding: a library takes the description otherwise, or differentiates by differences."
        return doc.Table(f"Errors against {self.data['digits']} digits", ["robot", *self.libraries], rows, note)

    def code(self) -> list[doc.Table]:
        """robodyn's machine code in blocks, of each kind, beside Pinocchio and what arithmetic allows."""
        head = ["robot", "operations", "Pinocchio [ns]", "in"]
        for title in self.ours:
            head += [f"{title} [ns]", "ratio", "of the limit"]
        rows = []
        for robot, _, algorithm in self.cases:
            peers = (self.by.get((robot, algorithm, "Pinocchio", way)) for way in ("block", "one"))
            peer = next(filter(None, peers), None)
            row = ["-", "-"] if peer is None else [time_text(peer["seconds"]["median"]), WAYS[peer["way"]]]
            for title in self.ours:
                found = self.by[robot, algorithm, title, "block"]
                median = found["seconds"]["median"]
                row += [time_text(median), "-" if peer is None else f"{peer['seconds']['median'] / median:.1f}"]
                row.append(f"{found['limit'] / median:.0%}")
            rows.append([f"{robot}, {algorithm}", str(found["operations"]), *row])
        note = "Ratio: Pinocchio's time over ours. Limit: the least time of the arithmetic."
        return [doc.Table("robodyn's machine code, in blocks", head, rows, note)] if self.ours else []

    def published(self) -> doc.Table:
        """Times of others, and of ours here by the widest instructions."""

        def here(robot: str, algorithm: str, way: str) -> str:
            found = [self.by.get((robot, algorithm, title, way)) for title in self.ours]
            return time_text(found[-1]["seconds"]["median"]) if any(found) else "-"

        rows, robots = [], dict.fromkeys(robot for each in PUBLISHED for robot in each.times)
        for robot, algorithm in product(robots, ALGORITHMS):
            times = [each.times.get(robot, {}).get(algorithm) for each in PUBLISHED]
            shown = ("-" if time is None else f"{1e3 * time:.0f}" for time in times)
            if any(times):
                rows.append([f"{robot}, {algorithm}", *shown, *(here(robot, algorithm, way) for way in WAYS)])
        head = ["robot", *(f"{each.program}, {each.hardware} [ns]" for each in PUBLISHED)]
        head += [f"robodyn here, {words} [ns]" for words in WAYS.values()]
        sources = dict.fromkeys(f"{each.source} ({each.address})" for each in PUBLISHED)
        note = f"{'; '.join(sources)}. Other hardware, and descriptions that may differ: for the order of magnitude."
        return doc.Table("One state a call, as others published it", head, rows, note)

    def charts(self) -> list[doc.Block]:
        """A chart for each algorithm and way: time over joints, a colour for each library."""
        figures, colours = [], dict(zip(self.libraries, COLOURS, strict=False))
        for way, algorithm in product(WAYS, dict.fromkeys(case[-1] for case in self.cases)):
            points: dict[str, list[tuple[float, float]]] = {}
            names: dict[str, list[str]] = {}
            for x in self.data["results"]:
                if (x["algorithm"], x["way"]) == (algorithm, way):
                    points.setdefault(x["library"], []).append((x["joints"], 1e9 * x["seconds"]["median"]))
                    names.setdefault(x["library"], []).append(f"{x['library']}, {x['robot']}")
            caption = f"{algorithm}, {WAYS[way]}: {ALGORITHMS[algorithm].meaning}"
            alt = f"Times of {algorithm} over joints, by library; they are in the tables."
            dots = {title: tuple(np.array(pairs, dtype=float).T) for title, pairs in points.items()}
            look = {"dots": dots, "names": names, "colours": colours, "log": True}
            figures += [plane_chart(caption, alt, "joints", "ns per state", **look)] if dots else []
        return doc.gallery(figures)

    def all(self) -> list[doc.Table]:
        empty = ", ".join(f"{title} {time_text(x['median'])} ns" for title, x in self.data["empty_call"].items())
        return [
            *self.times("block", "A state of a block", f"Blocks have {BLOCK} states, of robodyn up to {OURS}."),
            *self.times("one", "One state a call", f"A call that does nothing: {empty}."),
            *self.times(
                "arrays", "One state by robodyn's functions of arrays", "They look at shapes, zeros and the scene."
            ),
            *self.code(),
            self.errors(),
            self.published(),
        ]


def document(data: Mapping[str, Any], command: str) -> doc.Document:
    """The page: charts, tables, and how all was measured."""
    tables = Tables(data)
    versions = tuple(f"{title} {version}" for title, version in data["versions"].items())
    blocks = (
        doc.Paragraph(f"{data['machine'].strip()} Processor: {data['processor']}."),
        *tables.charts(),
        doc.Heading("In numbers"),
        *tables.all(),
        doc.Heading("How it was measured"),
        *doc.paragraphs([*METHOD, *data["skipped"]]),
    )
    return doc.Document("Rigid-body dynamics", "robodyn beside other libraries", blocks, command, versions)


METHOD = (
    "All libraries are given the same URDF: links with inertias and joints, without friction, rotors, shapes and "
    "mimicry; gravity acts, and the base is at rest. States are drawn at random, the same for all: angles up to 2, "
    "rates and accelerations up to 3, and for ABA the torques of these motions. Joints are matched by name.",
    "Each library works in a process of its own, by one thread, and is warm. In each of several rounds each has a turn "
    f"of {1e3 * TURN:.0f} ms; times are of the processor. Shown are medians, and in percent half of what is between "
    f"the quartiles. One state a call: {CALLS} states, one after the other, by the library's functions in Python. "
    f"Blocks have {BLOCK} states, those of robodyn {OURS}, but at most {NUMBERS} numbers as results.",
    "An error is the largest difference from robodyn's own recursions in 50 digits over the largest result, on "
    f"{CHECKED['RNEA']} states; of derivatives on {CHECKED['dRNEA']}, the larger one of those by q and by qd.",
    "MuJoCo's RNEA is mj_inverse and its ABA mj_forward without constraints, which do more; its derivatives are finite "
    "differences. Drake's derivatives are by automatic differentiation. iDynTree's forward dynamics has a free base.",
)
"""Paragraphs."""


def printed(data: Mapping[str, Any]) -> str:
    """The tables as Markdown."""
    parts = [f"{each.caption}:\n\n{table(each.head, each.rows)}\n{each.note}\n" for each in Tables(data).all()]
    versions = ", ".join(f"{title} {version}" for title, version in data["versions"].items())
    return "\n".join([*parts, f"{data['machine'].strip()} Processor: {data['processor']}. {versions}.\n"])
