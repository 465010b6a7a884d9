#!/usr/bin/env python3
"""How long Open CASCADE takes to read, transfer and mesh a STEP file: `mesh_time.py FILE`, JSON on standard output.

Run with target/peers/venv/bin/python. The deflection is half a pixel of the 1920x1080 iso view that fits the model
(camera.py), absolute; the angular deflection is the library's default of 0.5 rad; meshing runs on all cores. `seconds`
is only the three steps; starting Python and loading the library are in `process_seconds`, and `memory_before_mb` is
what they take.
"""

import time

start = time.monotonic()

import argparse
import json
import resource

from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.IFSelect import IFSelect_RetDone
from OCP.Message import Message
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS

from camera import Camera, parse_bounds

ANGULAR_DEFLECTION = 0.5


def peak_mb():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6


def box_of(shape):
    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box, False)
    box.SetGap(0.0)
    low, high = box.CornerMin(), box.CornerMax()
    return (low.X(), low.Y(), low.Z()), (high.X(), high.Y(), high.Z())


def count_triangles(shape):
    triangles = bare = faces = 0
    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        triangulation = BRep_Tool.Triangulation_s(TopoDS.Face(explorer.Current()), TopLoc_Location())
        faces += 1
        if triangulation is None:
            bare += 1
        else:
            triangles += triangulation.NbTriangles()
        explorer.Next()
    return {"faces": faces, "faces_without_mesh": bare, "triangles": triangles}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("file")
    parser.add_argument("--bounds", type=parse_bounds, help="x0,y0,z0,x1,y1,z1 in mm [default: the peer's own box]")
    parser.add_argument("--size", default="1920x1080")
    args = parser.parse_args()
    size = tuple(int(v) for v in args.size.split("x"))
    for printer in list(Message.DefaultMessenger_s().Printers()):
        Message.DefaultMessenger_s().RemovePrinter(printer)
    before = peak_mb()
    loaded = time.monotonic()
    reader = STEPControl_Reader()
    if reader.ReadFile(args.file) != IFSelect_RetDone:
        raise SystemExit(f"{args.file}: Open CASCADE does not read it")
    read = time.monotonic()
    reader.TransferRoots()
    shape = reader.OneShape()
    transferred = time.monotonic()
    if shape.IsNull():
        raise SystemExit(f"{args.file}: Open CASCADE finds no shape in it")
    bounds = args.bounds or box_of(shape)
    deflection = Camera(bounds, size).half_pixel()
    mesh_start = time.monotonic()
    BRepMesh_IncrementalMesh(shape, deflection, False, ANGULAR_DEFLECTION, True)
    meshed = time.monotonic()
    print(json.dumps({
        "file": args.file,
        "bounds": bounds,
        "deflection_mm": deflection,
        "read_seconds": read - loaded,
        "transfer_seconds": transferred - read,
        "mesh_seconds": meshed - mesh_start,
        "seconds": transferred - loaded + meshed - mesh_start,
        "process_seconds": meshed - start,
        "memory_before_mb": before,
        "peak_mb": peak_mb(),
        **count_triangles(shape),
    }))


if __name__ == "__main__":
    main()
