"""What bench/library.sh does with the unpacked library: reads all of it, draws all of it, checks what was drawn.

`library.py report FOLDER RESULTS [LIST]`: every file by itself (`info`: faces against the text, warnings), then all as one
scene (`render`, `perf record` of the same, `verify`), then RESULTS.md and .json. Each step's result is kept under
target/library-run while the program and the list stay the same, so a run that was cut off goes on; delete that folder to
start anew. `library.py sample FOLDER > bench/library_sample.txt` draws the sample, `library.py slice FOLDER FACES` lists the files that
scripts/gpu_bundle.sh packs, and `library.py files FOLDER [LIST]`
lists files that fail, lose faces or have another number of them than the text.
"""

import hashlib
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from datetime import date
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from library_report import markdown

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = Path(os.environ.get("HALFPIXEL") or ROOT / "target/release/halfpixel")
RUNS = ROOT / "target/library-run"
# Faces are entities of these words, by the text alone; the reader has no part in the count.
FACE = re.compile(rb"=\s*(ADVANCED_FACE|FACE_SURFACE)\s*\(")
SEED = 20261123
SIZE = "3840x2160"


def step_files(folder):
    return sorted(p for p in Path(folder).rglob("*") if p.suffix.lower() in (".step", ".stp"))


def count_faces(path):
    """Face entities in the text."""
    return len(FACE.findall(path.read_bytes()))


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


def faces_slice(folder, faces):
    """Files drawn with a seed until they hold so many faces, by name."""
    files = step_files(folder)
    random.Random(SEED).shuffle(files)
    chosen = []
    for path in files:
        if faces <= 0:
            break
        faces -= count_faces(path)
        chosen.append(str(path.relative_to(folder)))
    return sorted(chosen)


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


def fingerprint(files):
    """Of the program and the list: results of others are not used again."""
    digest = hashlib.sha256(PROGRAM.read_bytes())
    for path in files:
        digest.update(str(path).encode())
    return digest.hexdigest()[:16]


class Steps:
    """Results of one run, each kept in a file once it is there."""

    def __init__(self, files):
        self.folder = RUNS / fingerprint(files)
        self.folder.mkdir(parents=True, exist_ok=True)

    def once(self, name, work):
        kept = self.folder / f"{name}.json"
        if kept.is_file():
            return json.loads(kept.read_text())
        start = time.monotonic()
        result = work()
        partial = kept.with_suffix(".partial")
        partial.write_text(json.dumps(result))
        partial.rename(kept)
        print(f"{name}: {time.monotonic() - start:.0f} s", flush=True)
        return result


def look_at(path):
    """One file by itself: what `info` says of it, and what its text says."""
    result = run([PROGRAM, "info", path, "--threads", "1", "--json"], 1200)
    info = parsed(result)
    row = {"file": str(path), "text_bytes": path.stat().st_size, "entities": count_faces(path), "exit": result["code"],
           "seconds": result["seconds"], "peak_mb": result["peak_mb"]}
    if info is None:
        return {**row, "errors": result["errors"].strip()[-300:]}
    kept = ("faces", "unique_faces", "surface_types", "bezier_patches", "area", "bytes", "trim_curves", "lost", "warnings")
    return {**row, **{key: info.get(key) for key in kept}}


def look_at_all(files, cache):
    """Rows of all files; those in the cache (one JSON object a line) are not looked at again."""
    rows = {}
    if cache.is_file():
        for line in cache.read_text().splitlines():
            try:
                row = json.loads(line)
            except json.JSONDecodeError:
                continue  # The last line of a run that was cut off.
            rows[row["file"]] = row
    left = [path for path in files if str(path) not in rows]
    start = time.monotonic()
    with ThreadPoolExecutor(os.cpu_count()) as pool, cache.open("a") as out:
        out.write("\n")
        for done, row in enumerate(pool.map(look_at, left), 1):
            rows[row["file"]] = row
            out.write(json.dumps(row) + "\n")
            out.flush()
            if done % 500 == 0 or done == len(left):
                print(f"{done} of {len(left)} files, {time.monotonic() - start:.0f} s", flush=True)
    return [rows[str(path)] for path in files]


def summary(rows, folder):
    """Sums over the files, and what deserves a look."""
    total, kinds, in_files, examples, surfaces = Counter(), Counter(), Counter(), {}, Counter()
    lost, differ, failed = Counter(), [], []
    for row in rows:
        name = os.path.relpath(row["file"], folder)
        total.update(files=1, text_bytes=row["text_bytes"], face_entities=row["entities"])
        if row["exit"] != 0:
            failed.append({"file": name, "why": row.get("errors", "")})
            continue
        for key in ("faces", "unique_faces", "bezier_patches", "bytes", "trim_curves"):
            total[key] += row.get(key) or 0
        surfaces.update(row["surface_types"])
        if row["unique_faces"] != row["entities"] or row["lost"]:
            differ.append({"file": name, "entities": row["entities"], "unique_faces": row["unique_faces"],
                           "faces": row["faces"], "lost": len(row["lost"])})
        lost.update(kind_of(w) for w in row["lost"])
        own = Counter(kind_of(w) for w in row["warnings"])
        kinds.update(own)
        in_files.update(own.keys())
        for warning in row["warnings"]:
            examples.setdefault(kind_of(warning), f"{name}: {warning if isinstance(warning, str) else warning['message']}")
    warnings = [{"kind": k, "count": n, "files": in_files[k], "example": examples[k]} for k, n in kinds.most_common()]
    return {**total, "lost": sum(lost.values()), "lost_by_kind": lost.most_common(), "surface_types": dict(surfaces),
            "warnings": sum(kinds.values()), "files_with_warnings": sum(1 for r in rows if r.get("warnings")),
            "warnings_by_kind": warnings, "failed": failed, "differ": differ,
            "info_seconds": sum(r["seconds"] for r in rows), "largest_peak_mb": max(r["peak_mb"] for r in rows)}


def profile(source, folder):
    """Where `render` spends its time, by perf's samples; None where there is no perf."""
    if not shutil.which("perf"):
        return None
    data = folder / "perf.data"
    recorded = run(["perf", "record", "-F", "199", "-o", data, PROGRAM, "render", *source, "--size", SIZE,
                    "-o", folder / "profiled.png"], 3600)
    report = run(["perf", "report", "-i", data, "--stdio", "--no-children", "--no-inline", "-F", "overhead,symbol", "-t", ";"], 1800)
    data.unlink(missing_ok=True)
    if recorded["code"] != 0 or report["code"] != 0:
        return {"error": (recorded["errors"] + report["errors"])[-500:]}
    symbols = []
    for line in report["output"].splitlines():
        found = re.match(r"\s*([\d.]+)%\s*;\s*\[(.)\]\s*(.*\S)", line)
        if found:
            symbols.append([float(found[1]), "kernel" if found[2] == "k" else found[3]])
    return {"symbols": symbols}


def report(folder, results, limit=None):
    files = [folder / line for line in limit] if limit else step_files(folder)
    files = [path.resolve() for path in files]
    steps = Steps(files)
    names = steps.folder / "files.txt"
    names.write_text("".join(f"{path}\n" for path in files))
    source = [f"@{names}", "--layout", "grid"]
    rows = look_at_all(files, steps.folder / "files.jsonl")
    picture, stats = results.parent / "library.png", steps.folder / "stats.json"
    results.parent.mkdir(parents=True, exist_ok=True)

    def reading():
        result = run([PROGRAM, "bench", "reading", f"@{names}", "--text-only", "--repeats", "1", "--json"], 3600)
        return {**result, "output": parsed(result)}

    def render():
        result = run([PROGRAM, "render", *source, "--size", SIZE, "--stats", stats, "-o", picture], 3600)
        return {**result, "stats": json.loads(stats.read_text()) if result["code"] == 0 else None}

    def verify():
        result = run([PROGRAM, "verify", *source, "--size", SIZE, "--json"], 3600)
        return {**result, "output": parsed(result)}

    data = {"machine": machine(), "commit": commit(), "date": date.today().isoformat(), "size": SIZE,
            "summary": summary(rows, folder.resolve()), "reading": steps.once("reading", reading),
            "render": steps.once("render", render), "profile": steps.once("profile", lambda: profile(source, steps.folder)),
            "verify": steps.once("verify", verify)}
    results.with_suffix(".json").write_text(json.dumps(data, indent=1) + "\n")
    text = markdown(data)
    results.with_suffix(".md").write_text(text)
    print(text)
    failed = data["summary"]["failed"] or data["summary"]["lost"]
    return 1 if failed or data["render"]["code"] or data["verify"]["code"] else 0


def check_files(paths, root):
    cache = RUNS / fingerprint(paths) / "files.jsonl"
    cache.parent.mkdir(parents=True, exist_ok=True)
    found = summary(look_at_all(paths, cache), root)
    for row in found["failed"] + found["differ"]:
        print(json.dumps(row))
    for row in found["warnings_by_kind"]:
        print(f"{row['count']} in {row['files']} files: {row['kind']}; {row['example']}")
    print(f"{len(paths)} files, {found['unique_faces']} faces for {found['face_entities']} in the text, {found['lost']} lost")
    return 1 if found["failed"] or found["lost"] else 0


def main(arguments):
    match arguments:
        case ["sample", folder]:
            print("\n".join(sample(Path(folder))))
        case ["slice", folder, faces]:
            print("\n".join(faces_slice(Path(folder), int(faces))))
        case ["files", folder]:
            return check_files([p.resolve() for p in step_files(folder)], Path(folder).resolve())
        case ["files", folder, names]:
            paths = [(Path(folder) / name).resolve() for name in Path(names).read_text().split()]
            return check_files(paths, Path(folder).resolve())
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
