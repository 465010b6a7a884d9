#!/usr/bin/env python3
"""halfpixel's face areas beside Open CASCADE's: `compare_areas.py FILE... [--worst N] [-o bench/results/areas]`.

The peer's areas come from target/peers/areas/NAME.json; where there is none, areas.py makes it. Exit 1 where totals
differ by more than 1e-5 of the whole, a face by more than 1e-3 of it, or faces are missing on either side. Faces in
ARBITRATED are those where a third method found the peer wrong; they are compared with its result instead. With -o the
findings are written to PREFIX.md and PREFIX.json.
"""

import argparse
import json
import math
import subprocess
import sys
from datetime import date
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from library import PROGRAM, ROOT, commit, machine
from library_report import table

PEER = ROOT / "target/peers/venv/bin/python"
CACHE = ROOT / "target/peers/areas"
TOTAL, FACE = 1e-5, 1e-3
DOUBTFUL = 1e-4

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


def compare(path):
    """What is to be said of one file, or {"file", "error"} where the peer does not read it."""
    peer, ours = peer_areas(path), our_areas(path)
    if "error" in peer:
        return {"file": path.name, "error": peer["error"], "good": True}
    theirs, mine = by_number(peer["faces_list"]), by_number(ours["face_list"])
    other = {face["id"]: face for face in peer["faces_list"]}
    arbitrated = ARBITRATED.get(path.name, {})
    total = peer["area"] + sum(other[n]["instances"] * (area - theirs[n]) for n, area in arbitrated.items())
    judged = {**theirs, **arbitrated}
    faces = [{"face": n, "off": relative(mine[n], judged[n]), "ours": mine[n], "judged": judged[n], "peer": theirs[n],
              **{k: other[n][k] for k in ("gauss", "mesh") if other.get(n, {}).get(k) is not None}}
             for n in judged.keys() & mine.keys()]
    faces.sort(key=lambda f: -f["off"])
    found = {"file": path.name, "faces": ours["faces"], "peer_faces": peer["faces"], "area": ours["area"], "judged": total,
             "peer_area": peer["area"], "off": relative(ours["area"], total), "off_peer": relative(ours["area"], peer["area"]),
             "missing": sorted(judged.keys() - mine.keys()), "extra": sorted(mine.keys() - judged.keys()),
             "stated_error": ours["area_relative_error"], "worst": faces[:8],
             "arbitrated": [f for f in faces if f["face"] in arbitrated]}
    beyond = any(f["off"] > FACE for f in faces)
    found["good"] = found["off"] <= TOTAL and not beyond and not found["missing"] and not found["extra"] \
        and ours["faces"] == peer["faces"]
    return found


def show(found, worst):
    if "error" in found:
        print(f"{found['file']}: the peer does not read it ({found['error']})")
        return
    print(f"{found['file']}: {'ok' if found['good'] else 'DIFFERS'}: faces {found['faces']} / {found['peer_faces']}, area "
          f"{found['area']:.9g} / {found['judged']:.9g} mm², total off by {found['off']:.1e}, worst face by "
          f"{found['worst'][0]['off'] if found['worst'] else 0:.1e}"
          + (f", {len(found['arbitrated'])} by a third method" if found["arbitrated"] else ""))
    if found["missing"] or found["extra"]:
        print(f"  only the peer has {found['missing'][:12]}, only halfpixel has {found['extra'][:12]}")
    for face in found["worst"][:worst]:
        notes = "".join(f", {k} {face[k]:.9g}" for k in ("gauss", "mesh") if k in face)
        print(f"  #{face['face']}: {face['ours']:.9g} / {face['judged']:.9g} mm², off by {face['off']:.1e}{notes}")


def markdown(findings):
    rows, thirds, doubtful = [], [], []
    for f in findings:
        if "error" in f:
            rows.append((f["file"], "-", "-", "-", "-", "-", "-", f"not read by the peer: {f['error']}"))
            continue
        worst = f["worst"][0] if f["worst"] else {"face": 0, "off": 0.0}
        note = "" if f["good"] else "DIFFERS"
        if f["arbitrated"]:
            note += f"{len(f['arbitrated'])} faces by a third method, below; off the peer's own total by {f['off_peer']:.1e}"
        rows.append((f["file"], f["faces"], f"{f['area']:.9g}", f"{f['judged']:.9g}", f"{f['off']:.1e}",
                     f"#{worst['face']}: {worst['off']:.1e}", f"{f['stated_error']:.0e}", note))
        for face in f["worst"]:
            if face["off"] > DOUBTFUL:
                third = [f"{face[k]:.8g}" if k in face else "-" for k in ("gauss", "mesh")]
                doubtful.append((f["file"], f"#{face['face']}", f"{face['ours']:.8g}", f"{face['judged']:.8g}", f"{face['off']:.1e}", *third))
        for face in sorted(f["arbitrated"], key=lambda f: f["face"]):
            off = lambda key: f"{relative(face[key], face['judged']):.1e}"
            thirds.append((f["file"], f"#{face['face']}", f"{face['ours']:.8g}", f"{face['peer']:.8g}", f"{face['judged']:.8g}",
                           off("ours"), off("peer")))
    text = ("# Areas beside Open CASCADE's\n\nAreas of faces inside their trims on the exact surfaces, mm², all instances. "
            "The peer integrates adaptively to 1e-8. Must be: totals within 1e-5, each face within 1e-3; `stated` is what "
            "`info` says its own error is.\n\n"
            f"Measured on {machine()}, commit {commit()}, {date.today().isoformat()}: "
            "`bench/peers/setup.sh && bench/peers/compare_areas.py $M/*.st*p -o bench/results/areas`.\n\n"
            + table(("file", "faces", "area", "reference", "total off by", "worst face", "stated", "note"), rows))
    if doubtful:
        text += (f"\n## Faces off by more than {DOUBTFUL:.0e}\n\nThe peer's other two methods beside them: fixed Gauss points, and "
                 "its triangulation extrapolated to zero deflection, which follows the edges and not the pcurves.\n\n"
                 + table(("file", "face", "halfpixel", "reference", "off by", "Gauss points", "triangulation"), doubtful))
    if thirds:
        text += ("\n## Where the peer is wrong\n\nThese files have no pcurves for these faces. The ones the peer makes run "
                 "beside the edges, by up to 0.06 mm, and it integrates inside them. The third method is a closed form of the "
                 "face inside its edges, or `area_inside_edges.py`; which one stands in `compare_areas.py`.\n\n"
                 + table(("file", "face", "halfpixel", "Open CASCADE", "third method", "halfpixel off by", "Open CASCADE off by"), thirds))
    return text


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--worst", type=int, default=5, help="faces to list for each file")
    parser.add_argument("-o", "--output", type=Path, help="where results go: PREFIX.md, PREFIX.json")
    args = parser.parse_args()
    findings = []
    for path in args.files:
        findings.append(compare(path))
        show(findings[-1], args.worst)
    if args.output:
        args.output.with_suffix(".md").write_text(markdown(findings))
        args.output.with_suffix(".json").write_text(json.dumps(findings, indent=1) + "\n")
    return 0 if all(found["good"] for found in findings) else 1


if __name__ == "__main__":
    sys.exit(main())
