#!/usr/bin/env bash
# The joints of one bus, for a project's own CI: check that they go together, then export each of
# them, compile the C, stream simulated sensor lengths to it over CAN and compare every angle with
# the model, bit for bit.
#
#   check.sh PATH [more ...]     joint files, and exported folders that your repository holds
#
# Needs ccgen and a C compiler; no CAN hardware, driver, root or network. Ends with status 1 on
# joints that do not go together, a mismatch or a lost frame, with 2 on a wrong joint file.
#   CCGEN      what runs ccgen where it is not installed, such as "python -m ccgen"
#   JUNIT      an .xml file for the report of the first check
#   SNAPSHOTS  how many cross each bus
set -euo pipefail

if [ "$#" -eq 0 ]; then
  echo "usage: $0 joint.toml|folder [more ...]" >&2
  exit 2
fi

ccgen() {
  if [ -n "${CCGEN:-}" ]; then
    $CCGEN "$@"
  else
    command ccgen "$@"
  fi
}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

ccgen check "$@" ${JUNIT:+--junit "$JUNIT"}

for path in "$@"; do
  echo "== $path"
  folder="$path"
  if [ ! -d "$path" ]; then
    folder="$work/$(basename "$path" .toml)"
    ccgen export "$path" -o "$folder"
  fi
  ccgen verify "$folder" --target host --snapshots "${SNAPSHOTS:-20000}"
done
