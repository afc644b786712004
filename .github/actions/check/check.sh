#!/usr/bin/env bash
# Checks the files named in ROBODYN_FILES, one a line, with the options in ROBODYN_OPTIONS. Annotations go to standard
# output, SARIF to the file ROBODYN_SARIF if that is set, a table of rules to the summary of the job, and the exit
# status of the check is this script's and its output `status`.
set -uo pipefail

files=()
while IFS= read -r line; do
  [[ -z "${line//[[:space:]]/}" ]] || files+=("$line")
done <<< "${ROBODYN_FILES:-.}"
read -ra options <<< "${ROBODYN_OPTIONS:-}"

check() { robodyn check ${options[@]+"${options[@]}"} "$@" -- "${files[@]}"; }

check --format github
status=$?
if [[ $status -lt 2 ]]; then
  if [[ -n "${ROBODYN_SARIF:-}" ]]; then check --format sarif > "$ROBODYN_SARIF" 2> /dev/null; fi
  if [[ -n "${GITHUB_STEP_SUMMARY:-}" ]]; then
    { echo '### robodyn check'; echo '```'; check --format text --statistics 2> /dev/null; echo '```'; } >> "$GITHUB_STEP_SUMMARY"
  fi
fi
if [[ -n "${GITHUB_OUTPUT:-}" ]]; then echo "status=$status" >> "$GITHUB_OUTPUT"; fi
exit "$status"
