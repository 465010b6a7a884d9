#!/usr/bin/env python3
"""The viewer F3D from a STEP file to a picture: `f3d_time.py FILE -o out.png`, JSON on standard output.

Run with target/peers/venv/bin/python, and time the whole process from outside. Without a display it draws through EGL
in software (Debian's libegl1 and libgl1-mesa-dri). Camera, size and background are those of `halfpixel render`. Its own
mesh settings are kept unless `--half-pixel` asks for half a pixel's deflection.
"""

import time

start = time.monotonic()

import argparse
import json
import resource
import sys

import f3d

from camera import Camera, parse_bounds


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("file")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--bounds", type=parse_bounds, help="x0,y0,z0,x1,y1,z1 in mm [default: F3D's own fit]")
    parser.add_argument("--size", default="1920x1080")
    parser.add_argument("--view", default="iso")
    parser.add_argument("--zoom", type=float, default=1.0)
    parser.add_argument("--half-pixel", action="store_true")
    args = parser.parse_args()
    size = tuple(int(v) for v in args.size.split("x"))
    camera = Camera(args.bounds, size, args.view, args.zoom) if args.bounds else None

    f3d.Log.set_verbose_level(f3d.Log.ERROR)
    engine = f3d.Engine.create_egl()
    f3d.Engine.autoload_plugins()
    if args.half_pixel:
        if camera is None:
            sys.exit("--half-pixel needs --bounds")
        f3d.Engine.set_reader_option("STEP.relative_deflection", "0")
        f3d.Engine.set_reader_option("STEP.linear_deflection", repr(camera.half_pixel()))
    engine.window.size = size
    engine.options.update({
        "scene.up_direction": "+Z", "render.grid.enable": False, "render.background.color": [1.0, 1.0, 1.0],
        "ui.axis": False, "ui.filename": False, "ui.fps": False, "ui.loader_progress": False,
    })
    engine.scene.add(args.file)
    loaded = time.monotonic()
    view = engine.window.camera
    if camera is None:
        view.reset_to_bounds()
    else:
        view.position, view.focal_point, view.view_up = camera.eye, camera.target, camera.up
        view.view_angle = camera.fov_degrees
    engine.window.render_to_image().save(args.output)
    print(json.dumps({
        "file": args.file,
        "version": f3d.__version__,
        "window": str(engine.window.type),
        "load_seconds": loaded - start,
        "process_seconds": time.monotonic() - start,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6,
    }))


if __name__ == "__main__":
    main()
