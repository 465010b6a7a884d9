#!/usr/bin/env python3
"""A third opinion on a face's area: `area_inside_edges.py FILE NUMBER...`.

Run with target/peers/venv/bin/python. The face's edges in space are sampled and projected to the surface point by point,
and the surface's area element is summed over a fine grid of parameters inside that polygon: no pcurve, no quadrature and
no mesh of the peer, and nothing of halfpixel. Good to about 1e-4. For faces with one bound, away from seams and poles.
"""

import argparse
from pathlib import Path

import numpy
from matplotlib.path import Path as Polygon
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepTools import BRepTools, BRepTools_WireExplorer
from OCP.GeomAPI import GeomAPI_ProjectPointOnSurf
from OCP.TopAbs import TopAbs_REVERSED
from OCP.gp import gp_Pnt, gp_Vec

from areas import Transferred, faces_of, integral

EDGE_POINTS, GRID = 60, 240


def boundary(face):
    """The outer wire's edges in the parameter plane, and how far off the surface they are."""
    surface, corners, largest = BRep_Tool.Surface_s(face), [], 0.0
    explorer = BRepTools_WireExplorer(BRepTools.OuterWire_s(face), face)
    while explorer.More():
        edge = explorer.Current()
        explorer.Next()
        curve = BRepAdaptor_Curve(edge)
        ends = curve.FirstParameter(), curve.LastParameter()
        first, last = ends[::-1] if edge.Orientation() == TopAbs_REVERSED else ends
        for step in range(EDGE_POINTS):
            point = curve.Value(first + (last - first) * step / EDGE_POINTS)
            projection = GeomAPI_ProjectPointOnSurf(point, surface)
            corners.append(projection.LowerDistanceParameters())
            largest = max(largest, projection.LowerDistance())
    return numpy.array(corners), largest


def area_inside(face):
    polygon, off = boundary(face)
    low, high = polygon.min(0), polygon.max(0)
    middles = (numpy.arange(GRID) + 0.5) / GRID
    u, v = (grid.ravel() for grid in numpy.meshgrid(*(low[k] + middles * (high[k] - low[k]) for k in (0, 1))))
    inside = Polygon(polygon).contains_points(numpy.column_stack([u, v]))
    surface, point, along_u, along_v = BRepAdaptor_Surface(face, False), gp_Pnt(), gp_Vec(), gp_Vec()
    total = 0.0
    for a, b in zip(u[inside], v[inside]):
        surface.D1(a, b, point, along_u, along_v)
        total += along_u.Crossed(along_v).Magnitude()
    return total * (high - low).prod() / GRID**2, off


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("file", type=Path)
    parser.add_argument("faces", type=int, nargs="+", help="entity numbers")
    args = parser.parse_args()
    transferred = Transferred(args.file)
    for face in faces_of(transferred.shape):
        number = transferred.number(face)
        if number in args.faces:
            area, off = area_inside(face)
            print(f"#{number}: {area:.6g} mm² inside its edges (up to {off:.1e} mm off the surface), {integral(face, 1e-8):.6g} by "
                  "Open CASCADE's integral")


if __name__ == "__main__":
    main()
