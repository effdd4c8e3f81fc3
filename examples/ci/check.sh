#!/usr/bin/env bash
# The CAN loopback test of a joint file, for a project's own CI: export it, compile the C, stream
# simulated sensor lengths to it over CAN and compare every angle with the model, bit for bit.
#
#   check.sh joint.toml [more.toml ...]
#
# Needs ccgen and a C compiler; no CAN hardware, driver, root or network. Ends with status 1 on a
# mismatch or a lost frame, with 2 on a wrong joint file. SNAPSHOTS sets how many cross each bus.
set -euo pipefail

if [ "$#" -eq 0 ]; then
  echo "usage: $0 joint.toml [more.toml ...]" >&2
  exit 2
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for joint in "$@"; do
  folder="$work/$(basename "$joint" .toml)"
  echo "== $joint"
  ccgen export "$joint" -o "$folder"
  ccgen verify "$folder" --target host --snapshots "${SNAPSHOTS:-20000}"
done
