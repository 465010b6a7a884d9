"""RESULTS.md of bench/library.py."""

import re
from collections import Counter

# Symbols that a table of the profile lists, and the least share of a module.
LISTED, LEAST = 25, 0.5


def table(head, body):
    lines = [head, ["---"] * len(head), *body]
    return "\n".join("| " + " | ".join(str(c).replace("|", "\\|") for c in line) + " |" for line in lines) + "\n"


def module_of(symbol):
    """`halfpixel::import::step` of a function in it; what lies outside the program by its crate."""
    # Methods of traits: <type as trait>::method.
    names = re.findall(r"halfpixel(?:::[a-z_]\w*)+", symbol)
    if names:
        parts = names[0].split("::")
        # A function's own name is no module.
        return "::".join(parts[1:-1][: 3 if parts[1] == "import" else 2] or parts[1:])
    return symbol if symbol == "kernel" else re.split(r"::|<|@", symbol.lstrip("<&"))[0] or "other"


def rates(data):
    reading = (data["reading"].get("output") or {}).get("rows") or [{}]
    mb = data["summary"]["text_bytes"] / 1e6
    stats = data["render"].get("stats") or {}
    stages = {row["stage"]: row["ms"] / 1e3 for row in stats.get("stages", [])}
    show = lambda value, digits=1: "-" if value is None else f"{value:.{digits}f}"
    together = stages.get("import", 0) + stages.get("prepare", 0)
    return [
        ("text read (every entity found and numbered), MB/s", show(reading[0].get("text MB/s"))),
        ("to models (import of `render`), MB/s", show(mb / stages["import"] if stages.get("import") else None)),
        ("to one scene (import and prepare of `render`), MB/s", show(mb / together if together else None)),
        ("`render`, whole process, MB/s", show(mb / data["render"]["seconds"] if data["render"]["code"] == 0 else None)),
    ]


def figures(data):
    s, render, verify = data["summary"], data["render"], data["verify"]
    checked = verify.get("output") or {}
    stats = render.get("stats") or {}
    worst = lambda key: (checked.get(key) or {}).get("max", "-")
    return [
        ("files", s["files"]), ("text, MB", f"{s['text_bytes'] / 1e6:.1f}"),
        ("files refused", len(s["failed"])),
        ("face entities in the text", s["face_entities"]), ("unique faces read", s.get("unique_faces", 0)),
        ("faces with their instances", s.get("faces", 0)), ("faces lost", s["lost"]),
        ("files where these counts differ", len(s["differ"])),
        ("trim curves", s.get("trim_curves", 0)), ("Bézier patches drawn", stats.get("patches", "-")),
        ("patches visible", stats.get("patches_visible", "-")), ("triangles", stats.get("triangles", "-")),
        ("scenes of the files, MB", f"{s.get('bytes', 0) / 1e6:.0f}"),
        ("warnings", s["warnings"]), ("files with warnings", s["files_with_warnings"]),
        *rates(data),
        ("`render`, whole process, s", f"{render['seconds']:.1f}"), ("`render`, peak memory, MB", f"{render['peak_mb']:.0f}"),
        ("`verify`, whole process, s", f"{verify['seconds']:.1f}"), ("`verify`, the check alone, s", f"{checked.get('seconds', 0):.1f}"),
        ("`verify`, peak memory, MB", f"{verify['peak_mb']:.0f}"),
        *((what.replace("_", " "), checked.get(what, "-")) for what in
          ("pixels", "drawn", "violations", "cracks", "covering_failures", "depth_failures", "filled")),
        ("grid error, max px", worst("grid_error_px")), ("parametric error, max px", worst("parametric_error_px")),
        ("refined error, max px", worst("refined_error_px")),
    ]


def profiled(profile):
    if not profile:
        return "\nThere is no perf on this machine; the stages above are all.\n"
    if "error" in profile:
        return f"\nperf failed: {profile['error'].splitlines()[-1]}\n"
    modules = Counter()
    for share, symbol in profile["symbols"]:
        modules[module_of(symbol)] += share
    return ("\n`perf record -F 199` of the same `render`, self time.\n\n"
            + table(("module", "%"), [(m, f"{x:.1f}") for m, x in modules.most_common() if x >= LEAST])
            + "\n" + table(("function", "%"), [(f"`{symbol[:110]}`", x) for x, symbol in profile["symbols"][:LISTED]]))


def markdown(data):
    s, render, verify = data["summary"], data["render"], data["verify"]
    text = ("# A library of CAD models\n\nThe STEP files of Debian's package kicad-packages3d, each by itself and all as one "
            f"scene in a grid, drawn at {data['size']} (view iso) and every pixel checked; bench/library.sh.\n\n"
            f"Measured on {data['machine']}, commit {data['commit']}, {data['date']}.\n\n" + table(("what", "value"), figures(data)))
    stats = render.get("stats") or {}
    if stats:
        text += "\n## Stages\n\n" + table(("stage", "ms"), [(r["stage"], f"{r['ms']:.0f}") for r in stats["stages"]])
    text += "\n## Profile\n" + profiled(data["profile"])
    text += "\n## Faces by surface\n\n" + table(("surface", "faces"), sorted(s["surface_types"].items(), key=lambda x: -x[1]))
    if s["warnings_by_kind"]:
        text += "\n## Warnings by kind\n\n" + table(("count", "files", "kind", "example"), [
            (w["count"], w["files"], w["kind"], w["example"]) for w in s["warnings_by_kind"]])
    if s["lost_by_kind"]:
        text += "\n## Faces lost, by kind\n\n" + table(("count", "kind"), [(n, k) for k, n in s["lost_by_kind"]])
    if s["differ"]:
        text += "\n## Files with another number of faces than the text\n\n" + table(
            ("file", "entities", "unique faces", "faces", "lost"), [tuple(d.values()) for d in s["differ"][:60]])
    offenders = (verify.get("output") or {}).get("worst") or []
    if offenders:
        text += "\n## Pixels that break the contract\n\n" + table(("kind", "pixel", "in", "face", "error px"), [
            (o["kind"], f"({o['x']}, {o['y']})", o.get("name") or "-", f"#{o.get('face')}", o.get("error_px")) for o in offenders])
    for what in ("render", "verify"):
        if data[what]["errors"] and data[what]["code"] not in (0, 1):
            text += f"\n`{what}` failed: {data[what]['errors'].strip().splitlines()[-1]}\n"
    for row in s["failed"]:
        text += f"\n{row['file']} is refused: {row['why']}\n"
    return text
