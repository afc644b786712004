#!/usr/bin/env bash
# Installs what ROBODYN_INSTALL names in a virtual environment of its own, since the Python of a system refuses pip, and
# puts that on the path of the steps that follow.
set -euo pipefail

home="${RUNNER_TEMP}/robodyn"
python3 -m venv "$home"
programs="$home/bin"
[[ -d "$programs" ]] || programs="$home/Scripts"
"$programs/python" -m pip install --quiet "$ROBODYN_INSTALL"
echo "$programs" >> "$GITHUB_PATH"
