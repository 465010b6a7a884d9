"""bench/trim_cost.sh: `trim_cost.py CSV...` joins the runs of `compare --trims on,off` into bench/results/trim-cost.csv and .md."""

import csv
import sys
from pathlib import Path

RESULTS = Path(__file__).resolve().parent / "results"
VIEWS = ["iso", "front", "top", "left"]


def cell(rows, view, column):
    return {row["trim"]: float(row[column]) for row in rows if row["view"] == view}


def main():
    rows = [row for path in sys.argv[1:] for row in csv.DictReader(open(path))]
    with open(RESULTS / "trim-cost.csv", "w", newline="") as out:
        writer = csv.DictWriter(out, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    first = rows[0]
    on = [row for row in rows if row["trim"] == "on"]
    broken = sum(int(row[kind]) for row in on for kind in ("violations", "cracks", "depth_failures"))
    covering = sum(int(row["covering_failures"]) for row in on)
    print_to = [
        "# What trimming costs",
        "",
        "The whole frame in milliseconds, with trims / with `--trim off`, the medians of one run, a model at a time; and what the sum of the",
        "four views grows by, of the medians and of the fastest frames. `all`: over three distances from far to near, as ETER's table 4 has it",
        f"(there 20 to 100 %). bench/trim_cost.sh; all columns in trim-cost.csv. Of {sum(int(row['checked']) for row in on)}",
        f"checked pixels with trims {broken} are violations, cracks or depth failures, {covering} covering failures; the largest error is "
        f"{max(float(row['parametric_max_px']) for row in on):.3f} px.",
        "",
        f"Measured on {first['device']} with {first['threads']} threads, commit {first['commit']}, {first['date']}, {first['frames']} frames.",
        "",
        "| model | zoom | " + " | ".join(VIEWS) + " | sum | sum of the fastest |",
        "| --- | ---: |" + " ---: |" * (len(VIEWS) + 2),
    ]
    grows = lambda cells: 100 * (sum(c["on"] for c in cells) / sum(c["off"] for c in cells) - 1)
    keys = dict.fromkeys((row["model"], row["zoom"]) for row in rows)
    for model, zoom in keys:
        of_model = [row for row in rows if row["model"] == model]
        zooms = list(dict.fromkeys(row["zoom"] for row in of_model))
        times, least = (
            {z: [cell([r for r in of_model if r["zoom"] == z], view, column) for view in VIEWS] for z in zooms}
            for column in ("total_ms", "total_min_ms")
        )
        if zoom == zooms[0]:
            every = [sum(parts.values(), []) for parts in (times, least)]
            print_to.append(
                f"| **{model.rsplit('.', 1)[0]}** | all |" + " |" * len(VIEWS) + f" **{grows(every[0]):.0f} %** | {grows(every[1]):.0f} % |"
            )
        times, least = times[zoom], least[zoom]
        cells = " | ".join(f"{c['on']:.1f} / {c['off']:.1f}" for c in times)
        print_to.append(f"| {model.rsplit('.', 1)[0]} | {zoom} | {cells} | {grows(times):.0f} % | {grows(least):.0f} % |")
    (RESULTS / "trim-cost.md").write_text("\n".join(print_to) + "\n")


if __name__ == "__main__":
    main()
