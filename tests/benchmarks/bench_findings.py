"""What `robodyn check` finds in published robots: `cd tests && python -m benchmarks.bench_findings`.

Every description of example-robot-data, icub-models and jvrc-description that is installed: by rule, at how many places
it finds something, in how many findings it says so (one for each cause in a file), how many of them are shown by
default, and in how many files; below, the median and the most of a file. With `--list 40` so many findings of the
default set follow, spread evenly over all, for judging them by hand.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from statistics import median

from helpers.markdown_tables import main, table
from pinned_findings import name_of, published

from robodyn.checks.catalogue import BY_CODE
from robodyn.checks.check import Found, Options, check_one, select_findings
from robodyn.checks.groups import places
from robodyn.checks.rule import Finding


def by_rule(files: Sequence[Found], single: Sequence[Sequence[Finding]]) -> str:
    """Return the rules that find something, those with the most shown findings first."""
    columns = (
        Counter(one.code for found in single for one in found),
        Counter(one.code for found in files for one in (*found.shown, *found.hidden)),
        Counter(one.code for found in files for one in found.shown),
        Counter(code for found in files for code in {one.code for one in found.shown}),
    )
    order = sorted(columns[0], key=lambda code: (-columns[2][code], code))
    rows = [(f"{code} {BY_CODE[code].name}", *(str(column[code] or "-") for column in columns)) for code in order]
    rows.append(("all", *(str(column.total()) for column in columns[:3]), "-"))
    return table(("rule", "places", "findings", "shown", "in files"), rows)


def by_file(files: Sequence[Found], single: Sequence[Sequence[Finding]]) -> str:
    """Return median, upper quartile and most of a file, and how many files have none."""
    ways: dict[str, Callable[[int], Sequence[Finding]]] = {
        "every place of every rule": lambda k: single[k],
        "every finding": lambda k: (*files[k].shown, *files[k].hidden),
        "shown by default": lambda k: files[k].shown,
        "places of these": lambda k: places(files[k].shown),
        "errors among these": lambda k: [one for one in files[k].shown if one.severity.value == "error"],
    }
    rows = []
    for name, found in ways.items():
        each = sorted(len(found(k)) for k in range(len(files)))
        upper = each[(3 * len(each)) // 4]
        rows.append((name, f"{median(each):g}", str(upper), str(each[-1]), str(each.count(0))))
    return table(("findings per file", "median", "upper quartile", "most", "files without"), rows)


def sample(names: Sequence[str], files: Sequence[Found], amount: int) -> str:
    """Return so many of the shown findings, each with its robot and the number of its places."""
    shown = [(name, one) for name, found in zip(names, files, strict=True) for one in found.shown]
    chosen = [shown[(k * len(shown)) // amount] for k in range(min(amount, len(shown)))]
    return "".join(
        f"{name}:{one.line} {one.severity.value} {one.code} ({len(one.places)}): {one.message}\n"
        for name, one in chosen
    )


def report(list: int) -> str:
    paths = published()
    single = [check_one(str(path)) for path in paths]
    files = [select_findings(found, Options()) for found in single]
    head = f"All rules on {len(paths)} published descriptions.\n\n"
    text = f"{head}{by_file(files, single)}\n{by_rule(files, single)}"
    return f"{text}\n{sample([*map(name_of, paths)], files, list)}" if list else text


if __name__ == "__main__":
    main(report, __doc__, list=0)
