#!/usr/bin/env python3
"""halfpixel beside Open CASCADE and F3D, in one run: `run.py FILE... [-n 5] [-o bench/results/peers]`.

Each file N times by turns: `halfpixel render` to a 1920x1080 PNG (whole process), Open CASCADE reading, transferring and
meshing it at half a pixel's deflection (mesh_time.py: those three steps alone, the process around them beside it), F3D
to the same picture with its own mesh settings (whole process). Medians, least and largest; peak memory of the process.
Then `halfpixel verify --samples` says what our picture's error is; a mesh has none that anyone states.
"""

import argparse
import csv
import json
import statistics
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from library import PROGRAM, ROOT, commit, machine, parsed, run

PYTHON = ROOT / "target/peers/venv/bin/python"
HERE = Path(__file__).resolve().parent
LIMIT = 600
SIZE = "1920x1080"


def succeeded(result, what):
    if result["code"] != 0:
        raise SystemExit(f"{what}: exit {result['code']}: {result['errors'].strip()[-500:]}")
    return result


def version(package):
    code = f"import importlib.metadata as m; print(m.version('{package}'))"
    return subprocess.run([PYTHON, "-c", code], capture_output=True, text=True, check=True).stdout.strip()


def spread(values):
    return {"median": statistics.median(values), "min": min(values), "max": max(values)}


def measure(path, repeats, samples, pictures):
    # The fit of our own picture, so that all three look through the same camera.
    info = parsed(succeeded(run([PROGRAM, "info", path, "--json"], LIMIT), f"info {path.name}"))
    bounds = "--bounds=" + ",".join(repr(x) for corner in info["bounds"] for x in corner)
    ours, mesh, viewer = [], [], []
    for _ in range(repeats):
        picture = pictures / f"{path.stem}-halfpixel.png"
        ours.append(succeeded(run([PROGRAM, "render", path, "--size", SIZE, "-o", picture], LIMIT), path.name))
        result = succeeded(run([PYTHON, HERE / "mesh_time.py", path, bounds, "--size", SIZE], LIMIT), "Open CASCADE")
        mesh.append({**result, "inside": parsed(result)})
        picture = pictures / f"{path.stem}-f3d.png"
        viewer.append(succeeded(run([PYTHON, HERE / "f3d_time.py", path, bounds, "--size", SIZE, "-o", picture], LIMIT), "F3D"))
    checked = run([PROGRAM, "verify", path, "--size", SIZE, "--samples", str(samples), "--json"], LIMIT)
    report = parsed(checked) or {}
    error = report.get("parametric_error_px") or {}
    seconds = spread([r["seconds"] for r in ours])
    peer = spread([r["inside"]["seconds"] for r in mesh])
    picture = spread([r["seconds"] for r in viewer])
    inside = mesh[-1]["inside"]
    peak = lambda runs: statistics.median(r["peak_mb"] for r in runs)
    return {
        "file": path.name, "runs": repeats,
        "our_s": seconds["median"], "our_min_s": seconds["min"], "our_max_s": seconds["max"],
        "occ_s": peer["median"], "occ_min_s": peer["min"], "occ_max_s": peer["max"],
        "ratio": seconds["median"] / peer["median"],
        "occ_process_s": statistics.median(r["seconds"] for r in mesh),
        "f3d_s": picture["median"], "f3d_min_s": picture["min"], "f3d_max_s": picture["max"],
        "f3d_ratio": seconds["median"] / picture["median"],
        "our_peak_mb": peak(ours), "occ_peak_mb": peak(mesh), "occ_loaded_mb": inside["memory_before_mb"],
        "f3d_peak_mb": peak(viewer), "peak_ratio": peak(ours) / peak(mesh),
        "our_faces": info["faces"], "occ_faces": inside["faces"], "occ_faces_without_mesh": inside["faces_without_mesh"],
        "occ_triangles": inside["triangles"], "deflection_mm": inside["deflection_mm"],
        "error_max_px": error.get("max"), "error_p999_px": error.get("p999"),
        "grid_error_max_px": (report.get("grid_error_px") or {}).get("max"),
        "checked": report.get("pixels"),
        **{key: report.get(key) for key in ("violations", "cracks", "covering_failures", "depth_failures")},
    }


COLUMNS = [
    ("file", "file"), ("our s", "our_s"), ("OCC s", "occ_s"), ("ours / OCC", "ratio"), ("OCC process s", "occ_process_s"),
    ("F3D s", "f3d_s"), ("ours / F3D", "f3d_ratio"), ("our peak MB", "our_peak_mb"), ("OCC peak MB", "occ_peak_mb"),
    ("of it Python and libraries MB", "occ_loaded_mb"), ("F3D peak MB", "f3d_peak_mb"), ("error max px", "error_max_px"),
    ("p999 px", "error_p999_px"), ("violations", "violations"), ("cracks", "cracks"),
]


def cell(value):
    if value is None:
        return "-"
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def markdown(data):
    head = "| " + " | ".join(name for name, _ in COLUMNS) + " |\n"
    rule = "|" + "|".join(" --- " if i == 0 else " ---: " for i in range(len(COLUMNS))) + "|\n"
    rows = "".join("| " + " | ".join(cell(row[key]) for _, key in COLUMNS) + " |\n" for row in data["rows"])
    return (
        "# Beside other programs\n\nFrom a STEP file to a picture of 1920x1080 (view iso): ours and F3D's whole process; Open CASCADE only "
        "reads, transfers and meshes, at half a pixel's deflection at the model's centre, without loading itself. By turns "
        f"in one run, medians of {data['runs']}; the .csv has the spread. Errors are those of our picture (`verify`).\n\n"
        f"Measured on {data['machine']}, commit {data['commit']}, {data['date']}; Open CASCADE {data['open_cascade']}, "
        f"F3D {data['f3d']}.\n\n" + head + rule + rows)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("-n", "--runs", type=int, default=5)
    parser.add_argument("--samples", type=int, default=20000)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "bench/results/peers")
    parser.add_argument("--pictures", type=Path, help="a folder to keep both pictures in")
    args = parser.parse_args()
    if not PYTHON.exists():
        raise SystemExit("there is no target/peers/venv: run bench/peers/setup.sh")
    with tempfile.TemporaryDirectory() as spare:
        pictures = args.pictures or Path(spare)
        pictures.mkdir(parents=True, exist_ok=True)
        rows = []
        for path in args.files:
            rows.append(measure(path, args.runs, args.samples, pictures))
            print(json.dumps(rows[-1]), flush=True)
    data = {"runs": args.runs, "machine": machine(), "commit": commit(), "date": date.today().isoformat(),
            "open_cascade": version("cadquery-ocp"), "f3d": version("f3d"), "rows": rows}
    args.output.parent.mkdir(parents=True, exist_ok=True)
    args.output.with_suffix(".json").write_text(json.dumps(data, indent=1) + "\n")
    args.output.with_suffix(".md").write_text(markdown(data))
    with args.output.with_suffix(".csv").open("w", newline="") as file:
        facts = {k: data[k] for k in ("machine", "commit", "date", "open_cascade", "f3d")}
        writer = csv.DictWriter(file, [*rows[0], *facts])
        writer.writeheader()
        writer.writerows({**row, **facts} for row in rows)
    print(markdown(data))


if __name__ == "__main__":
    main()
