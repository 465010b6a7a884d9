#!/usr/bin/env python3
"""halfpixel's face areas beside Open CASCADE's: `compare_areas.py FILE... [--worst N]`.

The peer's areas come from target/peers/areas/NAME.json; where there is none, areas.py makes it. Exit 1 where totals
differ by more than 1e-5 of the whole, a face by more than 1e-3 of it, or faces are missing on either side. Faces in
ARBITRATED are those where a third method found the peer wrong; they are compared with its result instead.
"""

import argparse
import json
import math
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "target/release/halfpixel"
PEER = ROOT / "target/peers/venv/bin/python"
CACHE = ROOT / "target/peers/areas"
TOTAL, FACE = 1e-5, 1e-3

# Faces where the pcurves that Open CASCADE makes (these files have none) run beside the edges, by up to 0.06 mm, and it
# integrates inside the pcurves. What follows is inside the edges.
# axom: corners are octants of a sphere, r = 0.29: pi r² / 2. The inner edges are quarters of a cylinder, 0.92 long, with
# tips where three meet: r 0.92 pi / 2 + 4 r² (pi / 4 - sin(pi / 4)). Their meetings are measured by area_inside_edges.py.
# brlcad: four pieces of a torus, by area_inside_edges.py and by the peer's own triangulation; a sphere of r = 13.2 between
# two wires of solid angle 0.788304446 and 0.115710504.
R = 0.29
CORNERS = (25, 37, 57, 69, 105, 117, 137, 149)
TIPS = (22, 23, 24, 34, 35, 36, 54, 55, 56, 66, 67, 68, 102, 103, 104, 114, 115, 116, 134, 135, 136, 146, 147, 148)
MEETINGS = (29, 41, 61, 73, 109, 121, 141, 153)
ARBITRATED = {
    "axom_boxed_sphere.step": {
        **dict.fromkeys(CORNERS, math.pi / 2 * R**2),
        **dict.fromkeys(TIPS, R * 0.92 * math.pi / 2 + 4 * R**2 * (math.pi / 4 - math.sin(math.pi / 4))),
        **dict.fromkeys(MEETINGS, 0.32882),
    },
    "brlcad_ap203_periodic_pole_solid.stp": {
        **dict.fromkeys((829092, 829094, 829096, 829098), 0.490418),
        829101: 13.2**2 * (0.7883044463 - 0.1157105037),
    },
}


def peer_areas(path):
    cached = CACHE / f"{path.name}.json"
    if not cached.is_file():
        subprocess.run([PEER, ROOT / "bench/peers/areas.py", "-o", CACHE, path], check=True)
    return json.loads(cached.read_text())


def our_areas(path):
    command = [PROGRAM, "info", "--faces", "--json", path]
    result = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if result.returncode != 0:
        raise SystemExit(f"{path.name}: {result.stderr.strip()}")
    return json.loads(result.stdout)


def by_number(faces):
    areas = {}
    for face in faces:
        number = face["id"] if "id" in face else face["entity"]
        areas[number] = areas.get(number, 0.0) + face["area"]
    return areas


def relative(a, b):
    return abs(a - b) / max(abs(a), abs(b)) if a != b else 0.0


def compare(path, worst):
    peer, ours = peer_areas(path), our_areas(path)
    if "error" in peer:
        print(f"{path.name}: the peer does not read it ({peer['error']})")
        return True
    theirs, mine = by_number(peer["faces_list"]), by_number(ours["face_list"])
    instances = {face["id"]: face["instances"] for face in peer["faces_list"]}
    arbitrated = ARBITRATED.get(path.name, {})
    total = peer["area"] + sum(instances[n] * (area - theirs[n]) for n, area in arbitrated.items())
    judged = {**theirs, **arbitrated}
    missing, extra = sorted(judged.keys() - mine.keys()), sorted(mine.keys() - judged.keys())
    rows = sorted(((relative(mine[n], judged[n]), n) for n in judged.keys() & mine.keys()), reverse=True)
    off = relative(ours["area"], total)
    beyond = [n for difference, n in rows if difference > FACE]
    good = off <= TOTAL and not beyond and not missing and not extra and ours["faces"] == peer["faces"]
    print(f"{path.name}: {'ok' if good else 'DIFFERS'}: faces {ours['faces']} / {peer['faces']}, area {ours['area']:.9g} / "
          f"{total:.9g} mm², total off by {off:.1e}, worst face by {rows[0][0] if rows else 0:.1e}"
          + (f", {len(arbitrated)} by a third method" if arbitrated else ""))
    if missing or extra:
        print(f"  only the peer has {missing[:12]}, only halfpixel has {extra[:12]}")
    for difference, number in rows[:worst]:
        face = next(f for f in peer["faces_list"] if f["id"] == number)
        notes = "".join(f", {k} {face[k]:.9g}" for k in ("gauss", "mesh") if face.get(k) is not None)
        print(f"  #{number}: {mine[number]:.9g} / {judged[number]:.9g} mm², off by {difference:.1e}{notes}")
    return good


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--worst", type=int, default=5, help="faces to list for each file")
    args = parser.parse_args()
    results = [compare(path, args.worst) for path in args.files]
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main())
