"""Runs `robodyn check` once: annotations on standard output; SARIF in a file; in the job's summary how often each rule
speaks; in a comment of the pull request how the dynamics differ from those of its base, which fails no check."""

import json
import os
import re
import subprocess
import sys
import tempfile
from collections import Counter

MARK = "<!-- robodyn check -->"
MOST = 100
"""Lines of a comment."""
DYNAMICS = "RD902"


def check(variables, json_file):
    """Return the exit status, of which changed dynamics are no part."""
    options = variables.get("ROBODYN_OPTIONS", "").split()
    files = [line for line in variables.get("ROBODYN_FILES", "").splitlines() if line.strip()] or ["."]
    base, sarif = variables.get("ROBODYN_BASE", ""), variables.get("ROBODYN_SARIF", "")
    if base and "--against" not in options and has(base):
        options += ["--against", base]
    also = [f"json={json_file}", *([f"sarif={sarif}"] if sarif else [])]
    written = [word for each in also for word in ("--also", each)]
    call = ["robodyn", "check", *options, "--format", "github", *written, "--", *files]
    status = subprocess.run(call, check=False).returncode
    if status == 1 and options[-2:] == ["--against", base]:
        failing = {"error", "warning"} if "--strict" in options else {"error"}
        status = int(any(one["severity"] in failing for one in read(json_file) if one["code"] != DYNAMICS))
    return status


def has(base):
    """Whether git has the commit of the base, which a shallow checkout is without until it is fetched."""
    calls = (["cat-file", "-e", f"{base}^{{commit}}"], ["fetch", "--quiet", "--depth=1", "origin", base])
    found = any(subprocess.run(["git", *call], check=False, capture_output=True).returncode == 0 for call in calls)
    if not found:
        print(f"::notice title=robodyn::the dynamics are not compared: git cannot fetch {base}")
    return found


def read(json_file):
    with open(json_file, encoding="utf-8") as stream:
        return json.load(stream)["findings"]


def fenced(lines):
    """Return lines in which nothing is Markdown, of at most MOST: names in them may be anybody's."""
    more = [f"and {len(lines) - MOST} more"] if len(lines) > MOST else []
    text = "\n".join([*lines[:MOST], *more])
    fence = "`" * max(3, 1 + max(map(len, re.findall("`+", text)), default=0))
    return f"{fence}text\n{text}\n{fence}\n"


def summary(findings):
    counts = Counter(f"{one['severity']:8} {one['code']} {one['name']}" for one in findings)
    lines = [f"{number:5} {rule}" for rule, number in counts.most_common()]
    return "### robodyn check\n" + (fenced(lines) if lines else "Nothing found.\n")


def dynamics(findings):
    lines = [
        f"{place['file']}: {' '.join(place['message'].split())}"
        for one in findings
        if one["code"] == DYNAMICS
        for place in one["places"]
    ]
    return f"### Dynamics against the base\n{fenced(lines)}" if lines else ""


def comment(text, repository, number):
    """Write the comment, in place of an earlier one; without changes only where there is one. A token that may not,
    as in pull requests from forks, is no error."""
    place = f"repos/{repository}/issues"
    own = f'.[] | select((.body | startswith("{MARK}")) and .user.type == "Bot") | .id'
    try:
        call = ["gh", "api", "--paginate", f"{place}/{number}/comments", "--jq", own]
        earlier = subprocess.run(call, check=True, capture_output=True, text=True).stdout.split()
        if not text and not earlier:
            return
        to = ["PATCH", f"{place}/comments/{earlier[0]}"] if earlier else ["POST", f"{place}/{number}/comments"]
        body = json.dumps({"body": f"{MARK}\n{text or 'The dynamics are those of the base.'}"})
        call = ["gh", "api", "--silent", "--method", *to, "--input", "-"]
        subprocess.run(call, check=True, input=body, text=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError) as error:
        print(f"::notice title=robodyn::no comment is written: {str(error).splitlines()[0]}")


def append(file, text):
    if file:
        with open(file, "a", encoding="utf-8") as stream:
            stream.write(text)


def main(variables):
    with tempfile.TemporaryDirectory() as folder:
        json_file = os.path.join(folder, "findings.json")
        status = check(variables, json_file)
        if os.path.exists(json_file):
            findings = read(json_file)
            changed = dynamics(findings)
            append(variables.get("GITHUB_STEP_SUMMARY"), summary(findings) + changed)
            if variables.get("ROBODYN_COMMENT") == "true" and variables.get("ROBODYN_NUMBER"):
                comment(changed, variables["GITHUB_REPOSITORY"], variables["ROBODYN_NUMBER"])
    append(variables.get("GITHUB_OUTPUT"), f"status={status}\n")
    return status


if __name__ == "__main__":
    sys.exit(main(os.environ))
