#!/usr/bin/env bash
# The programs halfpixel is measured against, in a virtual environment under target/peers: Open CASCADE (as the Python
# package cadquery-ocp) and the viewer F3D. Versions are pinned: a figure belongs to the version that gave it.
set -euo pipefail
cd "$(dirname "$0")/../.."

OPEN_CASCADE=8.0.1.1.0
F3D=4.0.0
venv=target/peers/venv

[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check "cadquery-ocp==$OPEN_CASCADE" "f3d==$F3D"
echo "$venv/bin/python: Open CASCADE $OPEN_CASCADE, F3D $F3D"
