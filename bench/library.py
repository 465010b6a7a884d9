"""What bench/library.sh does with the unpacked library: reads all of it, draws all of it, checks sampled pixels.

`library.py report FOLDER RESULTS [LIST]`, `library.py sample FOLDER > bench/library_sample.txt`, and
`library.py files FOLDER [LIST]`: file by file, those that fail, lose faces or have another number than the text.
"""

import json
import os
import random
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from datetime import date
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target/release/halfpixel"
MARK = b"ADVANCED_FACE"
SEED = 20261123


def step_files(folder):
    return sorted(p for p in Path(folder).rglob("*") if p.suffix.lower() in (".step", ".stp"))


def count_faces(path):
    """ADVANCED_FACE entities in the text, by the word alone."""
    return path.read_bytes().count(MARK)


def sample(folder):
    """The smallest file of each of the 30 folders that hold the smallest ones, and 30 more drawn with a seed."""
    files = step_files(folder)
    smallest = {}
    for path in sorted(files, key=lambda p: (p.stat().st_size, p)):
        smallest.setdefault(path.parent, path)
    chosen = list(smallest.values())[:30]
    rest = [path for path in files if path not in set(chosen)]
    chosen += random.Random(SEED).sample(rest, 30)
    return [str(path.relative_to(folder)) for path in chosen]


def run(arguments, time_limit):
    """Standard output, seconds and peak memory of a command; output is None where it failed."""
    start = time.monotonic()
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as errors:
        process = subprocess.Popen([str(a) for a in arguments], stdout=out, stderr=errors)
        # The limit is enforced from outside: wait4 has none of its own.
        deadline = start + time_limit
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() > deadline:
                process.kill()
            time.sleep(0.02)
        seconds = time.monotonic() - start
        out.seek(0), errors.seek(0)
        text, complaint = out.read().decode(), errors.read().decode(errors="replace")
    code = os.waitstatus_to_exitcode(status)
    process.returncode = code
    return {"code": code, "seconds": seconds, "peak_mb": usage.ru_maxrss * 1024 / 1e6, "output": text,
            "errors": complaint}


def parsed(result):
    try:
        return json.loads(result["output"])
    except json.JSONDecodeError:
        return None


def kind_of(warning):
    """A warning without what differs from one file to the next: numbers, names in quotes, paths."""
    text = warning if isinstance(warning, str) else warning.get("message", json.dumps(warning))
    text = re.sub(r"^\S*\.ste?p:\s*", "", text, flags=re.I)
    text = re.sub(r"'[^']*'|\"[^\"]*\"", "'…'", text)
    return re.sub(r"#?-?\d+(\.\d+)?([eE][-+]?\d+)?", "N", text)[:160]


def machine():
    model = next((line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "?")
    return f"{model} with {os.cpu_count()} threads"


def commit():
    git = lambda *a: subprocess.run(["git", *a], cwd=ROOT, capture_output=True, text=True).stdout.strip()
    return git("rev-parse", "--short=12", "HEAD") + ("-dirty" if git("status", "--porcelain", "-uno") else "")


def report(folder, results, limit=None):
    files = step_files(folder)
    if limit:
        files = [folder / line for line in limit]
    scanning = time.monotonic()
    entities = sum(count_faces(path) for path in files)
    scan_seconds = time.monotonic() - scanning
    size = sum(path.stat().st_size for path in files)
    print(f"{len(files)} files, {size / 1e6:.1f} MB, {entities} ADVANCED_FACE, text scanned in {scan_seconds:.1f} s", flush=True)
    with tempfile.NamedTemporaryFile("w", suffix=".txt") as names:
        names.write("".join(f"{path.resolve()}\n" for path in files))
        names.flush()
        source = ["@" + names.name, "--layout", "grid"]
        info_run = run([PROGRAM, "info", *source, "--json"], 1800)
        print(f"info: {info_run['seconds']:.1f} s, exit {info_run['code']} {info_run['errors'][-300:]}", flush=True)
        picture = results.parent / "library.png"
        stats_file = ROOT / "target/library-stats.json"
        render = run([PROGRAM, "render", *source, "--size", "3840x2160", "--stats", stats_file, "-o", picture], 1800)
        print(f"render: {render['seconds']:.1f} s, exit {render['code']} {render['errors'][-300:]}", flush=True)
        verify = run([PROGRAM, "verify", *source, "--size", "3840x2160", "--samples", "100000", "--json"], 3600)
        print(f"verify: {verify['seconds']:.1f} s, exit {verify['code']} {verify['errors'][-300:]}", flush=True)
    info, checked = parsed(info_run) or {}, parsed(verify) or {}
    stats = json.loads(stats_file.read_text()) if render["code"] == 0 and stats_file.is_file() else None
    warnings = Counter(kind_of(w) for w in info.get("warnings", []))
    read = info_run["code"] == 0 and bool(info)
    lost = info.get("lost") or []
    lost = lost if isinstance(lost, list) else [str(lost)]
    data = {
        "machine": machine(), "commit": commit(), "date": date.today().isoformat(),
        "files": len(files), "bytes_of_text": size, "face_entities": entities,
        "info": {k: v for k, v in info.items() if k not in ("warnings", "face_list", "lost", "model")},
        "info_seconds": info_run["seconds"], "info_peak_mb": info_run["peak_mb"], "info_errors": info_run["errors"][-2000:],
        "info_exit": info_run["code"], "lost": len(lost) if read else None, "lost_by_kind": Counter(kind_of(w) for w in lost).most_common(40),
        "warnings": sum(warnings.values()) if read else None, "warnings_by_kind": warnings.most_common(40),
        "render_seconds": render["seconds"], "render_peak_mb": render["peak_mb"], "render_exit": render["code"],
        "render_errors": render["errors"][-2000:], "stats": stats,
        "verify_seconds": verify["seconds"], "verify_peak_mb": verify["peak_mb"], "verify_exit": verify["code"],
        "verify_errors": verify["errors"][-2000:], "verify": checked,
    }
    results.parent.mkdir(parents=True, exist_ok=True)
    results.with_suffix(".json").write_text(json.dumps(data, indent=1) + "\n")
    results.with_suffix(".md").write_text(markdown(data))
    print(markdown(data))
    return 0 if info_run["code"] == render["code"] == verify["code"] == 0 else 1


def check_file(path):
    """What is wrong with one file, or None."""
    result = run([PROGRAM, "info", path, "--json"], 600)
    info = parsed(result)
    if info is None:
        return f"exit {result['code']} after {result['seconds']:.1f} s: {result['errors'].strip()[-300:]}"
    entities, lost = count_faces(path), info.get("lost") or []
    complaint = f"{info['unique_faces']} faces for {entities} in the text, {len(lost)} lost {lost[:2]}"
    return complaint if lost or info["unique_faces"] != entities else None


def check_files(paths, root):
    wrong = 0
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for path, complaint in zip(paths, pool.map(check_file, paths)):
            if complaint:
                wrong += 1
                print(f"{path.relative_to(root)}: {complaint}", flush=True)
    print(f"{len(paths)} files, {wrong} to look at")
    return 1 if wrong else 0


def stages_of(stats):
    """(stage, milliseconds) rows, whatever nests them."""
    rows = stats if isinstance(stats, list) else stats.get("stages", []) if isinstance(stats, dict) else []
    if isinstance(rows, dict):
        return [(name, value) for name, value in rows.items() if isinstance(value, (int, float))]
    return [(row.get("stage") or row.get("name"), row.get("ms")) for row in rows if isinstance(row, dict)]


def shown(count):
    return "-" if count is None else count


def markdown(data):
    info, checked = data["info"], data["verify"] or {}
    done = lambda what, text: text if data[f"{what}_exit"] == 0 else "-"
    mb = data["bytes_of_text"] / 1e6
    worst = lambda key: (checked.get(key) or {}).get("max", "-")
    rows = [
        ("files", data["files"]), ("text, MB", f"{mb:.1f}"), ("ADVANCED_FACE in the text", data["face_entities"]),
        ("unique faces read", info.get("unique_faces", "-")), ("faces drawn", info.get("faces", "-")),
        ("faces lost", shown(data["lost"])), ("Bézier patches", info.get("bezier_patches", "-")),
        ("bytes of the scene, MB", f"{info['bytes'] / 1e6:.0f}" if info.get("bytes") else "-"),
        ("warnings", shown(data["warnings"])),
        ("`info`: read, measure, prepare, s", done("info", f"{data['info_seconds']:.1f}")),
        ("`render`, whole process, s", done("render", f"{data['render_seconds']:.1f}")),
        ("text over that, MB/s", done("render", f"{mb / data['render_seconds']:.1f}")),
        ("`render`, peak memory, MB", done("render", f"{data['render_peak_mb']:.0f}")),
        ("`verify`, s", "-" if data["verify_exit"] not in (0, 1) else f"{data['verify_seconds']:.1f}"),
        *((what, checked.get(what, "-")) for what in
          ("pixels", "drawn", "violations", "cracks", "covering_failures", "depth_failures")),
        ("grid error, max px", worst("grid_error_px")), ("parametric error, max px", worst("parametric_error_px")),
        ("refined error, max px", worst("refined_error_px")),
    ]
    table = lambda head, body: "\n".join(
        ["| " + " | ".join(head) + " |", "| " + " | ".join("---" for _ in head) + " |",
         *("| " + " | ".join(str(c) for c in row) + " |" for row in body)]) + "\n"
    text = ("# A library of CAD models\n\nAll STEP files of Debian's package kicad-packages3d, as one scene in a grid, "
            "drawn at 3840x2160 (view iso); bench/library.sh.\n\n"
            f"Measured on {data['machine']}, commit {data['commit']}, {data['date']}.\n\n" + table(("what", "value"), rows))
    if data["stats"]:
        text += "\n## Stages\n\n" + table(("stage", "ms"), stages_of(data["stats"]))
    for title, key in (("Faces lost, by kind", "lost_by_kind"), ("Warnings, by kind", "warnings_by_kind")):
        if data[key]:
            text += f"\n## {title}\n\n" + table(("count", "kind"), [(count, kind) for kind, count in data[key]])
    for what in ("info", "render", "verify"):
        if data[f"{what}_errors"] and data[f"{what}_exit"]:
            text += f"\n`{what}` failed: {data[f'{what}_errors'].strip().splitlines()[-1]}\n"
    return text


def main(arguments):
    match arguments:
        case ["sample", folder]:
            print("\n".join(sample(Path(folder))))
        case ["files", folder]:
            return check_files(step_files(folder), folder)
        case ["files", folder, names]:
            return check_files([Path(folder) / name for name in Path(names).read_text().split()], folder)
        case ["report", folder, results]:
            return report(Path(folder), Path(results))
        case ["report", folder, results, names]:
            return report(Path(folder), Path(results), Path(names).read_text().split())
        case _:
            print(__doc__, file=sys.stderr)
            return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
