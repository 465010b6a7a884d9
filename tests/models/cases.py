#!/usr/bin/env python3
"""Writes the hard cases of reading STEP, and what each must come to, into this folder: `python3 cases.py`.

Areas stand beside each face as closed formulas (one B-spline's length is a Gauss sum): no program that reads STEP has
been asked. Coordinates are in millimetres but for inches.step.
"""

from math import acos, asinh, atan, cos, pi, sin, sqrt, tau
from pathlib import Path

import entities  # noqa: F401 (these add their cases)
import structures  # noqa: F401
from shapes import (CASES, MINUS_X, MINUS_Y, MINUS_Z, assembled, box_faces, case, moved, parameter_curve, rational,
                    rectangle)
from step_text import ORIGIN, X, Y, Z, plus, real, write

# Length of y = x^2 from 0 to 1, and the area of z = r^2 up to r = 1.
PARABOLA = sqrt(5) / 2 + asinh(2) / 4
PARABOLOID = pi / 6 * (5 * sqrt(5) - 1)


def torus_frame(s, major, minor, *, us, vs):
    """The four circular edges around u in us, v in vs, counter-clockwise seen from outside."""
    def meridian(u):
        out = (cos(u), sin(u), 0.0)
        return s.arc_edge(plus(ORIGIN, (major, out)), (sin(u), -cos(u), 0.0), out, minor, vs[0], vs[1])

    def parallel(v):
        return s.arc_edge((0.0, 0.0, minor * sin(v)), Z, X, major + minor * cos(v), us[0], us[1])
    low, right, high, left = parallel(vs[0]), meridian(us[1]), parallel(vs[1]), meridian(us[0])
    return [low, right, "-" + high, "-" + left]


def torus_area(major, minor, du, v0, v1):
    return minor * du * (major * (v1 - v0) + minor * (sin(v1) - sin(v0)))


@case("torus_across_seams", "A torus trimmed across both seams")
def _(s):
    loop = s.loop(*torus_frame(s, 10.0, 3.0, us=(-0.7, 0.7), vs=(-0.9, 0.9)))
    face = s.face(s.elementary("TOROIDAL_SURFACE", 10.0, 3.0), [loop], torus_area(10.0, 3.0, 1.4, -0.9, 0.9))
    s.product("part", s.shells([face]))


@case("torus_window", "A whole torus but for a window across both seams: its only bound is wound around the window")
def _(s):
    low, right, high, left = torus_frame(s, 10.0, 3.0, us=(-0.7, 0.7), vs=(-0.9, 0.9))
    loop = s.bound(s.loop(left[1:], high[1:], "-" + right, "-" + low))
    area = 4 * pi**2 * 30.0 - torus_area(10.0, 3.0, 1.4, -0.9, 0.9)
    s.product("part", s.shells([s.face(s.elementary("TOROIDAL_SURFACE", 10.0, 3.0), [loop], area)]))


def window(s, edges):
    """The loop around a window, with the rest of the surface to its left."""
    low, right, high, left = edges
    flip = lambda e: e[1:] if e.startswith("-") else "-" + e
    return s.bound(s.loop(flip(left), flip(high), flip(right), flip(low)))


def cylinder_frame(s, radius, us, vs):
    at = lambda u, v: (radius * cos(u), radius * sin(u), v)
    low, high = (s.arc_edge((0.0, 0.0, v), Z, X, radius, us[0], us[1]) for v in vs)
    right, left = (s.line_edge(at(u, vs[0]), at(u, vs[1])) for u in (us[1], us[0]))
    return [low, right, "-" + high, "-" + left]


def cylinder_with_holes(s, holes):
    """Radius 2, height 6, without a seam edge."""
    circle = lambda z: s.arc_edge((0.0, 0.0, z), Z, X, 2.0)
    bounds = [s.loop(circle(0.0)), s.loop("-" + circle(6.0))]
    bounds += [window(s, cylinder_frame(s, 2.0, u, v)) for u, v in holes]
    area = 24 * pi - sum(2.0 * (u[1] - u[0]) * (v[1] - v[0]) for u, v in holes)
    s.product("part", s.shells([s.face(s.elementary("CYLINDRICAL_SURFACE", 2.0), bounds, area)]))


@case("cylinder_hole_across_seam", "A cylinder without a seam edge, with a hole where its circles start")
def _(s):
    cylinder_with_holes(s, [((-0.5, 0.4), (2.0, 3.0))])


@case("cylinder_holes_all_around", "A cylinder without a seam edge, with holes that leave no room for a straight seam")
def _(s):
    cylinder_with_holes(s, [((-1.0, 1.5), (0.5, 1.5)), ((1.0, 3.8), (2.0, 3.0)), ((3.5, 5.9), (3.5, 4.5))])


def torus_with_holes(s, holes):
    bounds = [window(s, torus_frame(s, 10.0, 3.0, us=u, vs=v)) for u, v in holes]
    area = 4 * pi**2 * 30.0 - sum(torus_area(10.0, 3.0, u[1] - u[0], *v) for u, v in holes)
    s.product("part", s.shells([s.face(s.elementary("TOROIDAL_SURFACE", 10.0, 3.0), bounds, area)]))


@case("torus_two_windows", "A whole torus but for two windows: one across both seams, one opposite")
def _(s):
    torus_with_holes(s, [((-0.7, 0.7), (-0.9, 0.9)), ((2.6, 3.6), (2.4, 3.9))])


@case("torus_windows_all_around", "A torus with windows that leave no room for a straight seam either way")
def _(s):
    torus_with_holes(s, [((0.0, 2.5), (-0.7, 2.0)), ((2.6, 6.0), (1.0, 4.5)), ((3.0, 6.1), (4.68, 5.95)),
                         ((-0.25, 1.0), (4.2, 4.65)), ((2.2, 2.8), (4.6, 5.4))])


@case("torus_inner_side", "The inner side of a torus between two circles, without a seam edge")
def _(s):
    v0, v1 = 2.0, tau - 2.0
    circle = lambda v: s.arc_edge((0.0, 0.0, 3.0 * sin(v)), Z, X, 10.0 + 3.0 * cos(v))
    bounds = [s.loop(circle(v0)), s.loop("-" + circle(v1))]
    s.product("part", s.shells([
        s.face(s.elementary("TOROIDAL_SURFACE", 10.0, 3.0), bounds, torus_area(10.0, 3.0, tau, v0, v1))]))


@case("torus_seams", "A whole torus bounded by its two seams, each used twice")
def _(s):
    u, v = s.arc_edge(ORIGIN, Z, X, 13.0), s.arc_edge((10.0, 0.0, 0.0), MINUS_Y, X, 3.0)
    surface = s.elementary("TOROIDAL_SURFACE", 10.0, 3.0)
    s.product("part", s.solid([s.face(surface, [s.loop(u, v, "-" + u, "-" + v)], 4 * pi**2 * 30.0)]))


@case("torus_degenerate", "The apple and the lemon of a torus that crosses itself, as bare faces")
def _(s):
    major, minor = 3.0, 5.0
    phi = acos(-major / minor)
    outer = tau * minor * (2 * major * phi + 2 * minor * sin(phi))
    inner = tau * minor * (2 * minor * sin(phi) - 2 * major * (pi - phi))
    faces = []
    for x, select, area in ((0.0, True, outer), (20.0, False, inner)):
        place = s.axis((x, 0.0, 0.0))
        surface = s.entity(f"DEGENERATE_TOROIDAL_SURFACE('',{place},{real(major)},{real(minor)},{'.T.' if select else '.F.'})")
        apex = s.vertex((x, 0.0, minor * sin(phi)))
        faces.append(s.face(surface, [s.entity(f"VERTEX_LOOP('',{apex})")], area))
    s.product("part", s.shells(faces))


@case("cone_apex_seam", "A cone's apex, reached by a seam that is used twice")
def _(s):
    base = s.arc_edge(ORIGIN, Z, X, 3.0)
    seam = s.line_edge((3.0, 0.0, 0.0), (0.0, 0.0, 4.0))
    surface = s.elementary("CONICAL_SURFACE", 3.0, atan(3 / 4), z=MINUS_Z)
    side = s.face(surface, [s.loop(base, seam, "-" + seam)], 15 * pi)
    floor = s.face(s.plane(z=MINUS_Z), [s.loop("-" + base)], 9 * pi)
    s.product("part", s.solid([side, floor]))


@case("cone_apex_vertex_loop", "A cone bounded by its base and a vertex loop at the apex")
def _(s):
    base = s.loop(s.arc_edge(ORIGIN, Z, X, 3.0))
    apex = s.entity(f"VERTEX_LOOP('',{s.vertex((0.0, 0.0, 4.0))})")
    surface = s.elementary("CONICAL_SURFACE", 3.0, atan(3 / 4), z=MINUS_Z)
    s.product("part", s.shells([s.face(surface, [base, apex], 15 * pi)]))


@case("cone_apex_one_loop", "A cone bounded by its base alone")
def _(s):
    base = s.loop(s.arc_edge(ORIGIN, Z, X, 3.0))
    surface = s.elementary("CONICAL_SURFACE", 3.0, atan(3 / 4), z=MINUS_Z)
    s.product("part", s.shells([s.face(surface, [base], 15 * pi)]))


def sphere_hole(s, toward, x, radius, angle):
    """The loop around a circular hole about the direction `toward`: clockwise seen from outside."""
    edge = s.arc_edge(plus(ORIGIN, (radius * cos(angle), toward)), toward, x, radius * sin(angle))
    return s.bound(s.loop("-" + edge))


@case("sphere_antipodal_hole", "A sphere with one hole, opposite to its seam")
def _(s):
    hole = sphere_hole(s, MINUS_X, Z, 5.0, 0.5)
    s.product("part", s.shells([s.face(s.elementary("SPHERICAL_SURFACE", 5.0), [hole], tau * 25 * (1 + cos(0.5)))]))


@case("sphere_antipodal_holes", "A sphere with two holes, one across its seam and one opposite")
def _(s):
    bounds = [sphere_hole(s, X, Z, 5.0, 0.4), sphere_hole(s, MINUS_X, Z, 5.0, 0.5)]
    area = tau * 25 * (cos(0.4) + cos(0.5))
    s.product("part", s.shells([s.face(s.elementary("SPHERICAL_SURFACE", 5.0), bounds, area)]))


@case("sphere_pole_caps", "A cap over each pole, bounded by one circle each")
def _(s):
    surface = s.elementary("SPHERICAL_SURFACE", 5.0)
    height = 5.0 * sin(1.0)
    circles = [s.arc_edge((0.0, 0.0, z), Z, X, 5.0 * cos(1.0)) for z in (height, -height)]
    area = tau * 5.0 * (5.0 - height)
    s.product("part", s.shells([
        s.face(surface, [s.loop(circles[0])], area), s.face(surface, [s.loop("-" + circles[1])], area)]))


@case("sphere_tilted_cap", "A cap that holds the north pole off its middle, and crosses the seam")
def _(s):
    axis, side = (0.6, 0.0, 0.8), (0.8, 0.0, -0.6)
    angle = 0.9
    edge = s.arc_edge(plus(ORIGIN, (5.0 * cos(angle), axis)), axis, side, 5.0 * sin(angle))
    surface = s.elementary("SPHERICAL_SURFACE", 5.0)
    s.product("part", s.shells([s.face(surface, [s.loop(edge)], tau * 25.0 * (1 - cos(angle)))]))


@case("sphere_octant", "An octant with one corner at the pole: three arcs")
def _(s):
    arcs = [s.arc_edge(ORIGIN, Z, X, 5.0, 0.0, pi / 2), s.arc_edge(ORIGIN, X, Y, 5.0, 0.0, pi / 2),
            s.arc_edge(ORIGIN, Y, Z, 5.0, 0.0, pi / 2)]
    s.product("part", s.shells([s.face(s.elementary("SPHERICAL_SURFACE", 5.0), [s.loop(*arcs)], 25 * pi / 2)]))


@case("sphere_whole", "Whole spheres: no bounds, a vertex loop, a seam used twice")
def _(s):
    faces = []
    for index in range(3):
        center = (12.0 * index, 0.0, 0.0)
        surface = s.elementary("SPHERICAL_SURFACE", 5.0, origin=center)
        south, north = plus(center, (-5.0, Z)), plus(center, (5.0, Z))
        if index == 0:
            bounds = []
        elif index == 1:
            bounds = [s.entity(f"VERTEX_LOOP('',{s.vertex(south)})")]
        else:
            seam = s.edge(south, north, s.circle(center, MINUS_Y, X, 5.0))
            bounds = [s.loop(seam, "-" + seam)]
        faces.append(s.face(surface, bounds, 100 * pi))
    s.product("part", s.shells(faces))


@case("torus_whole", "A whole torus without bounds")
def _(s):
    s.product("part", s.shells([s.face(s.elementary("TOROIDAL_SURFACE", 10.0, 3.0), [], 4 * pi**2 * 30.0)]))


@case("plane_wrong_way", "A rectangle with a hole, both wound the wrong way")
def _(s):
    corners = [(0.0, 0.0, 0.0), (0.0, 3.0, 0.0), (4.0, 3.0, 0.0), (4.0, 0.0, 0.0)]
    hole = s.loop(s.arc_edge((2.0, 1.5, 0.0), Z, X, 0.5))
    s.product("part", s.shells([s.face(s.plane(), [s.polygon(corners), hole], 12 - pi / 4)]))


@case("cylinder_wrong_way", "A rectangle on a cylinder, wound the wrong way")
def _(s):
    low, high = (s.arc_edge((0.0, 0.0, z), Z, X, 3.0, 0.0, 1.0) for z in (0.0, 4.0))
    at = lambda t, z: (3.0 * cos(t), 3.0 * sin(t), z)
    left, right = (s.line_edge(at(t, 0.0), at(t, 4.0)) for t in (0.0, 1.0))
    loop = s.loop(left, high, "-" + right, "-" + low)
    s.product("part", s.shells([s.face(s.elementary("CYLINDRICAL_SURFACE", 3.0), [loop], 12.0)]))


@case("bounds_reversed", "Bounds with orientation .F., edges with same_sense .F., a face against its surface")
def _(s):
    corners = [(0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (4.0, 3.0, 0.0), (0.0, 3.0, 0.0)]
    edges = [s.edge(a, b, s.line(b, a), same=False) for a, b in zip(corners, corners[1:] + corners[:1])]
    circle = s.circle((2.0, 1.5, 0.0), Z, X, 1.0)
    # From 0 to 90 degrees along the circle, and from 0 to 90 degrees the long way round.
    a, b = (3.0, 1.5, 0.0), (2.0, 2.5, 0.0)
    short, long = s.edge(a, b, circle), s.edge(a, b, circle, same=False)
    bounds = [s.bound(s.loop(*edges), outer=True, same=False), s.bound(s.loop(long, "-" + short), same=False)]
    s.product("part", s.shells([s.face(s.plane(), bounds, 12 - pi, same=False)]))


@case("hole_touches_outer", "A circular hole that touches the outer loop in one point")
def _(s):
    s.product("part", s.shells([rectangle(s, 4.0, 4.0, s.loop("-" + s.arc_edge((2.0, 1.0, 0.0), Z, X, 1.0)), 16 - pi)]))


@case("hole_shares_vertex", "A triangular hole with one corner on the corner of the outer loop")
def _(s):
    hole = s.polygon([(0.0, 0.0, 0.0), (1.0, 2.0, 0.0), (2.0, 1.0, 0.0)])
    s.product("part", s.shells([rectangle(s, 4.0, 4.0, hole, 16 - 1.5)]))


@case("slit", "A rectangle whose loop runs along an edge into its middle and back")
def _(s):
    corners = [(0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (4.0, 3.0, 0.0), (0.0, 3.0, 0.0)]
    edges = [s.line_edge(a, b) for a, b in zip(corners, corners[1:] + corners[:1])]
    slit = s.line_edge(corners[0], (2.0, 1.5, 0.0))
    s.product("part", s.shells([s.face(s.plane(), [s.loop(slit, "-" + slit, *edges)], 12.0)]))


@case("zero_length_edge", "A rectangle with an edge of length zero")
def _(s):
    s.warnings = ["an edge of no length is left out"]
    corners = [(0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (4.0, 3.0, 0.0), (0.0, 3.0, 0.0)]
    edges = [s.line_edge(a, b) for a, b in zip(corners, corners[1:] + corners[:1])]
    edges.insert(1, s.edge(corners[1], corners[1], s.line(corners[0], corners[1])))
    s.product("part", s.shells([s.face(s.plane(), [s.loop(*edges)], 12.0)]))


@case("tiny_gaps", "Edges that miss their vertices by a hundred-thousandth")
def _(s):
    s.warnings = ["edges of a loop miss each other"]
    corners = [(0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (4.0, 3.0, 0.0), (0.0, 3.0, 0.0)]
    shift = lambda p: plus(p, (1e-5, (1.0, 1.0, 0.0)))
    edges = [s.edge(a, b, s.line(shift(a), shift(b))) for a, b in zip(corners, corners[1:] + corners[:1])]
    s.tolerance = 2e-5
    s.product("part", s.shells([s.face(s.plane(), [s.loop(*edges)], 12.0)]))


@case("cylinder_seam", "A solid cylinder: a seam used twice, closed edges shared by two faces")
def _(s):
    low, high = (s.arc_edge((0.0, 0.0, z), Z, X, 3.0) for z in (0.0, 4.0))
    seam = s.line_edge((3.0, 0.0, 0.0), (3.0, 0.0, 4.0))
    side = s.face(s.elementary("CYLINDRICAL_SURFACE", 3.0), [s.loop(low, seam, "-" + high, "-" + seam)], 24 * pi)
    lid = s.face(s.plane((0.0, 0.0, 4.0)), [s.loop(high)], 9 * pi)
    floor = s.face(s.plane(z=MINUS_Z), [s.loop("-" + low)], 9 * pi)
    s.product("part", s.solid([side, lid, floor]))


@case("cylinder_two_loops", "A band between two closed edges that wind around, without a seam")
def _(s):
    low, high = (s.arc_edge((0.0, 0.0, z), Z, X, 3.0) for z in (0.0, 4.0))
    bounds = [s.loop(low), s.loop("-" + high)]
    s.product("part", s.shells([s.face(s.elementary("CYLINDRICAL_SURFACE", 3.0), bounds, 24 * pi)]))


@case("cylinder_half_across_seam", "Half a cylinder, its loop across the seam, and a hole across it")
def _(s):
    low, high = (s.arc_edge((0.0, 0.0, z), Z, X, 3.0, -pi / 2, pi / 2) for z in (0.0, 4.0))
    left, right = (s.line_edge((0.0, y, 0.0), (0.0, y, 4.0)) for y in (-3.0, 3.0))
    # A hole of four edges: its arcs run over the seam.
    at = lambda t, z: (3.0 * cos(t), 3.0 * sin(t), z)
    inner = [s.arc_edge((0.0, 0.0, z), Z, X, 3.0, -0.4, 0.4) for z in (1.0, 2.0)]
    sides = [s.line_edge(at(t, 1.0), at(t, 2.0)) for t in (-0.4, 0.4)]
    hole = s.loop(sides[0], inner[1], "-" + sides[1], "-" + inner[0])
    outer = s.loop(low, right, "-" + high, "-" + left)
    s.product("part", s.shells([s.face(s.elementary("CYLINDRICAL_SURFACE", 3.0), [outer, hole], 12 * pi - 2.4)]))


@case("cylinder_oblique", "A cylinder cut by a plane at 45 degrees: an elliptic edge")
def _(s):
    s.exact = True
    low = s.arc_edge(ORIGIN, Z, X, 3.0)
    top = (3.0, 0.0, 8.0)
    axis = s.axis((0.0, 0.0, 5.0), (-1.0, 0.0, 1.0), (1.0, 0.0, 1.0))
    ellipse = s.edge(top, top, s.entity(f"ELLIPSE('',{axis},{real(3 * sqrt(2))},3.)"))
    seam = s.line_edge((3.0, 0.0, 0.0), top)
    side = s.face(s.elementary("CYLINDRICAL_SURFACE", 3.0), [s.loop(low, seam, "-" + ellipse, "-" + seam)], 30 * pi)
    lid = s.face(s.entity(f"PLANE('',{axis})"), [s.loop(ellipse)], 9 * sqrt(2) * pi)
    floor = s.face(s.plane(z=MINUS_Z), [s.loop("-" + low)], 9 * pi)
    s.product("part", s.solid([side, lid, floor]))


@case("void", "A cube with a cubic void")
def _(s):
    shell = lambda faces: s.entity(f"CLOSED_SHELL('',({','.join(faces)}))")
    outer = shell(box_faces(s, 10.0))
    void = shell(box_faces(s, 4.0, (3.0, 3.0, 3.0), inward=False))
    void = s.entity(f"ORIENTED_CLOSED_SHELL('',*,{void},.F.)")
    brep = s.entity(f"BREP_WITH_VOIDS('',{outer},({void}))")
    s.bounds = [[0.0, 0.0, 0.0], [10.0, 10.0, 10.0]]
    s.product("part", s.represent("ADVANCED_BREP_SHAPE_REPRESENTATION", [brep]))


@case("faceted_brep", "A tetrahedron as a faceted B-rep of polygonal loops")
def _(s):
    corners = [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 6.0)]
    # The slanted side: half of |(-2, 3, 0) x (-2, 0, 6)|.
    slanted = sqrt(18.0**2 + 12.0**2 + 6.0**2)
    sides = [([0, 2, 1], MINUS_Z, X, 3.0), ([0, 1, 3], MINUS_Y, X, 6.0), ([0, 3, 2], MINUS_X, Y, 9.0),
             ([1, 2, 3], (18.0 / slanted, 12.0 / slanted, 6.0 / slanted), (-2 / sqrt(13), 3 / sqrt(13), 0.0), slanted / 2)]
    faces = []
    for order, normal, x, area in sides:
        loop = s.entity(f"POLY_LOOP('',({','.join(s.point(corners[i]) for i in order)}))")
        faces.append(s.face(s.plane(corners[order[0]], normal, x), [loop], area, kind="FACE_SURFACE"))
    shell = s.entity(f"CLOSED_SHELL('',({','.join(faces)}))")
    brep = s.entity(f"FACETED_BREP('',{shell})")
    s.product("part", s.represent("FACETED_BREP_SHAPE_REPRESENTATION", [brep]))


@case("face_based_model", "A face-based surface model")
def _(s):
    face_set = s.entity(f"CONNECTED_FACE_SET('',({rectangle(s, 4.0, 3.0)}))")
    model = s.entity(f"FACE_BASED_SURFACE_MODEL('',({face_set}))")
    s.product("part", s.represent("MANIFOLD_SURFACE_SHAPE_REPRESENTATION", [model]))


@case("no_product", "A cube in a representation of no product")
def _(s):
    s.bounds = [[0.0, 0.0, 0.0], [2.0, 2.0, 2.0]]
    s.solid(box_faces(s, 2.0))


@case("inches", "A cone in inches, its half angle in degrees")
def _(s):
    s.scale = 25.4
    exponents = s.entity("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)")
    millimetre = s.once("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
    inch = s.entity(f"LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),{millimetre})")
    none = s.entity("DIMENSIONAL_EXPONENTS(0.,0.,0.,0.,0.,0.,0.)")
    radian = s.once("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
    degree = s.entity(f"PLANE_ANGLE_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE({real(pi / 180)}),{radian})")
    context = s.context(
        f"(CONVERSION_BASED_UNIT('INCH',{inch})LENGTH_UNIT()NAMED_UNIT({exponents}))",
        f"(CONVERSION_BASED_UNIT('DEGREE',{degree})NAMED_UNIT({none})PLANE_ANGLE_UNIT())")
    base = s.arc_edge(ORIGIN, Z, X, 3.0)
    seam = s.line_edge((3.0, 0.0, 0.0), (0.0, 0.0, 4.0))
    surface = s.elementary("CONICAL_SURFACE", 3.0, atan(3 / 4) * 180 / pi, z=MINUS_Z)
    side = s.face(surface, [s.loop(base, seam, "-" + seam)], 15 * pi)
    # An edge that is a trimmed circle, its parameters in degrees.
    half = [plus(ORIGIN, (3.0, X)), plus(ORIGIN, (-3.0, X))]
    trimmed = s.entity(f"TRIMMED_CURVE('',{s.circle(ORIGIN, Z, X, 3.0)},(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(180.)),.T.,.PARAMETER.)")
    disc = s.face(s.plane(), [s.loop(s.edge(*half, trimmed), s.line_edge(half[1], half[0]))], 4.5 * pi)
    s.product("part", s.shells([side, disc], context))


def clamped(spans, degree):
    return [degree + 1] + [1] * (spans - 1) + [degree + 1], [float(i) for i in range(spans + 1)]


def wave_points(count):
    """Control points of a wavy closed curve around the origin."""
    radius = lambda i: 5.0 if i % 2 else 4.0
    return [(radius(i) * cos(tau * i / count), radius(i) * sin(tau * i / count), 0.0) for i in range(count)]


def closed_cubic_length(points):
    """Length of the closed uniform cubic B-spline: Gauss-Legendre of 8 points on 64 parts of each span."""
    nodes = [(0.1834346424956498, 0.3626837833783620), (0.5255324099163290, 0.3137066458778873),
             (0.7966664774136267, 0.2223810344533745), (0.9602898564975363, 0.1012285362903763)]
    count, parts, total = len(points), 64, 0.0
    for i in range(count):
        p = [points[(i + k) % count] for k in range(4)]
        for part in range(parts):
            for x, w in [(sign * x, w) for x, w in nodes for sign in (-1, 1)]:
                t = (part + (1 + x) / 2) / parts
                b = [-(1 - t)**2 / 2, (3 * t * t - 4 * t) / 2, (1 + 2 * t - 3 * t * t) / 2, t * t / 2]
                dx, dy = (sum(b[k] * p[k][axis] for k in range(4)) for axis in (0, 1))
                total += w / 2 / parts * sqrt(dx * dx + dy * dy)
    return total


@case("periodic_bspline", "A tube over a periodic cubic B-spline with unclamped knots; its two loops wind around")
def _(s):
    ring = wave_points(8)
    wrapped = ring + ring[:3]
    knots = [float(k) for k in range(-3, 12)]
    up = lambda p, z: (p[0], p[1], z)
    surface = s.bspline_surface((3, 1), [[up(p, 0.0), up(p, 2.0)] for p in wrapped], ([1] * 15, [2, 2]),
                                (knots, [0.0, 2.0]), closed=(True, False))
    start = tuple((ring[0][k] + 4 * ring[1][k] + ring[2][k]) / 6 for k in range(3))

    def edge(z):
        curve = s.bspline_curve(3, [up(p, z) for p in wrapped], [1] * 15, knots, closed=True)
        return s.edge(up(start, z), up(start, z), curve)
    low, high = edge(0.0), edge(2.0)
    area = 2.0 * closed_cubic_length(ring)
    s.product("part", s.shells([s.face(surface, [s.loop(low), s.loop("-" + high)], area)]))


@case("rational_closed_tube", "A cylinder as a closed rational quadratic B-spline, trimmed across its seam")
def _(s):
    h = sqrt(0.5)
    square = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]
    net = s.points([[(3.0 * x, 3.0 * y, 0.0), (3.0 * x, 3.0 * y, 4.0)] for x, y in square])
    weights = ",".join(f"({w},{w})" for w in (real(1.0 if i % 2 == 0 else h) for i in range(9)))
    surface = s.entity(rational(
        "SURFACE", f"2,1,{net},.CYLINDRICAL_SURF.,.T.,.F.,.F.",
        "(3,2,2,2,3),(2,2),(0.,1.,2.,3.,4.),(0.,4.),.UNSPECIFIED.", f"({weights})"))
    low, high = (s.arc_edge((0.0, 0.0, z), Z, X, 3.0, -1.0, 1.2) for z in (1.0, 3.0))
    at = lambda t, z: (3.0 * cos(t), 3.0 * sin(t), z)
    left, right = (s.line_edge(at(t, 1.0), at(t, 3.0)) for t in (-1.0, 1.2))
    loop = s.loop(low, right, "-" + high, "-" + left)
    s.product("part", s.shells([s.face(surface, [loop], 3.0 * 2.2 * 2.0)]))


@case("degree_22", "A parabola as a Bezier surface of degree 22")
def _(s):
    n = 22
    ends = lambda z: [(i / n, i * (i - 1) / (n * (n - 1)), z) for i in range(n + 1)]
    rows = [[a, b] for a, b in zip(ends(0.0), ends(3.0))]
    surface = s.bspline_surface((n, 1), rows, ([n + 1] * 2, [2, 2]), ([0.0, 1.0], [0.0, 3.0]))
    curves = [s.edge(net[0], net[-1], s.bspline_curve(n, net, [n + 1] * 2, [0.0, 1.0])) for net in (ends(0.0), ends(3.0))]
    sides = [s.line_edge(low, high) for low, high in (rows[0], rows[-1])]
    loop = s.loop(curves[0], sides[1], "-" + curves[1], "-" + sides[0])
    s.product("part", s.shells([s.face(surface, [loop], 3.0 * PARABOLA)]))


@case("bspline_spellings", "Uniform, quasi-uniform, Bezier and rational surfaces, bare in a geometric set")
def _(s):
    strip = lambda count, y: s.points([[(float(i), y, 0.0), (float(i), y + 1.0, 0.0)] for i in range(count)])
    # A uniform quadratic over points at 0, 1, 2, 3 runs from 0.5 to 2.5, a quasi-uniform one from end to end.
    simple = lambda kind, net: s.entity(f"{kind}('',2,1,{net},.UNSPECIFIED.,.F.,.F.,.F.)")
    h = real(sqrt(0.5))
    quarter = s.points([[(3.0, 0.0, 0.0), (3.0, 0.0, 4.0)], [(3.0, 3.0, 0.0), (3.0, 3.0, 4.0)], [(0.0, 3.0, 0.0), (0.0, 3.0, 4.0)]])
    def spelled(kind, net, weights):
        # The parts of a complex record stand in alphabetical order.
        parts = sorted([
            "BOUNDED_SURFACE()", f"B_SPLINE_SURFACE(2,1,{net},.UNSPECIFIED.,.F.,.F.,.F.)", f"{kind}()",
            "GEOMETRIC_REPRESENTATION_ITEM()", f"RATIONAL_B_SPLINE_SURFACE({weights})", "REPRESENTATION_ITEM('')", "SURFACE()"])
        return s.entity("(" + "".join(parts) + ")")
    items = [
        s.bare(simple("UNIFORM_SURFACE", strip(4, 0.0)), 2.0), s.bare(simple("QUASI_UNIFORM_SURFACE", strip(4, 2.0)), 3.0),
        s.bare(simple("BEZIER_SURFACE", strip(3, 4.0)), 2.0), 
        s.bare(spelled("QUASI_UNIFORM_SURFACE", strip(4, 6.0), "((2.,2.),(2.,2.),(2.,2.),(2.,2.))"), 3.0),
        s.bare(spelled("BEZIER_SURFACE", quarter, f"((1.,1.),({h},{h}),(1.,1.))"), 6.0 * pi),
    ]
    s.product("part", s.set_of(items))


@case("trimmed_in_set", "Rectangular trimmed surfaces in a geometric set, with and against the surface's senses")
def _(s):
    cylinder = s.elementary("CYLINDRICAL_SURFACE", 3.0)
    sphere = s.elementary("SPHERICAL_SURFACE", 5.0, origin=(20.0, 0.0, 0.0))
    trim = lambda base, u0, u1, v0, v1, us, vs: s.entity(
        f"RECTANGULAR_TRIMMED_SURFACE('',{base},{real(u0)},{real(u1)},{real(v0)},{real(v1)},{us},{vs})")
    items = [
        s.bare(trim(cylinder, 0.5, 2.0, 0.0, 4.0, ".T.", ".T."), 18.0),
        # Across the seam: from 6 up to 1 is 1 + 2 pi - 6.
        s.bare(trim(cylinder, 6.0, 1.0, 5.0, 7.0, ".T.", ".T."), 6.0 * (1 + tau - 6)),
        s.bare(trim(sphere, 0.0, 1.0, 0.0, pi / 2, ".T.", ".T."), 25.0),
        s.bare(trim(s.plane((0.0, 0.0, -5.0)), 0.0, 2.0, 0.0, 3.0, ".T.", ".T."), 6.0),
    ]
    s.product("part", s.set_of(items))


@case("curve_bounded", "A half disc as a curve-bounded surface, bounded by a composite curve")
def _(s):
    a, b = s.point((3.0, 0.0, 0.0)), s.point((-3.0, 0.0, 0.0))
    arc = s.entity(f"TRIMMED_CURVE('',{s.circle(ORIGIN, Z, X, 3.0)},({a}),({b}),.T.,.CARTESIAN.)")
    chord = s.entity(f"POLYLINE('',({b},{s.point(ORIGIN)},{a}))")
    parts = [s.entity(f"COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,{curve})") for curve in (arc, chord)]
    boundary = s.entity(f"OUTER_BOUNDARY_CURVE('',({','.join(parts)}),.F.)")
    items = [s.bare(s.entity(f"CURVE_BOUNDED_SURFACE('',{s.plane()},({boundary}),.F.)"), 4.5 * pi)]
    s.product("part", s.set_of(items))


def parabola_curve(s, z=0.0):
    return s.bspline_curve(2, [(0.0, 0.0, z), (0.5, 0.0, z), (1.0, 1.0, z)], [3, 3], [0.0, 1.0])


@case("offset_cylinder", "An offset of a cylinder, outward")
def _(s):
    surface = s.entity(f"OFFSET_SURFACE('',{s.elementary('CYLINDRICAL_SURFACE', 3.0)},0.5,.F.)")
    low, high = (s.arc_edge((0.0, 0.0, z), Z, X, 3.5) for z in (0.0, 4.0))
    seam = s.line_edge((3.5, 0.0, 0.0), (3.5, 0.0, 4.0))
    s.product("part", s.shells([s.face(surface, [s.loop(low, seam, "-" + high, "-" + seam)], 28 * pi)]))


@case("offset_bspline", "An offset of a B-spline surface, bare: it can only be approximated")
def _(s):
    s.warnings = ["the offset surface is fitted to within"]
    net = [[(x, y, 0.0), (x, y, 2.0)] for x, y in ((0.0, 0.0), (0.5, 0.0), (1.0, 1.0))]
    base = s.bspline_surface((2, 1), net, ([3, 3], [2, 2]), ([0.0, 1.0], [0.0, 2.0]))
    # The normal T x Z points to the outside of the bend, where the length grows by the turning angle.
    surface = s.bare(s.entity(f"OFFSET_SURFACE('',{base},0.25,.F.)"), 2.0 * (PARABOLA + 0.25 * atan(2.0)))
    s.tolerance = 1e-4
    s.product("part", s.set_of([surface]))


@case("extrusion", "A parabola extruded, and a circle extruded without a seam edge")
def _(s):
    vector = s.entity(f"VECTOR('',{s.direction(Z)},1.)")
    surface = s.entity(f"SURFACE_OF_LINEAR_EXTRUSION('',{parabola_curve(s)},{vector})")
    low, high = (s.edge((0.0, 0.0, z), (1.0, 1.0, z), parabola_curve(s, z)) for z in (0.0, 2.0))
    left, right = s.line_edge((0.0, 0.0, 0.0), (0.0, 0.0, 2.0)), s.line_edge((1.0, 1.0, 0.0), (1.0, 1.0, 2.0))
    sheet = s.face(surface, [s.loop(low, right, "-" + high, "-" + left)], 2.0 * PARABOLA)
    center = (10.0, 0.0, 0.0)
    tube = s.entity(f"SURFACE_OF_LINEAR_EXTRUSION('',{s.circle(center, Z, X, 3.0)},{vector})")
    rings = [s.arc_edge(plus(center, (z, Z)), Z, X, 3.0) for z in (0.0, 4.0)]
    band = s.face(tube, [s.loop(rings[0]), s.loop("-" + rings[1])], 24 * pi)
    s.product("part", s.shells([sheet, band]))


def paraboloid(s):
    meridian = s.bspline_curve(2, [(0.0, 0.0, 0.0), (0.5, 0.0, 0.0), (1.0, 0.0, 1.0)], [3, 3], [0.0, 1.0])
    axis = s.entity(f"AXIS1_PLACEMENT('',{s.point(ORIGIN)},{s.direction(Z)})")
    return meridian, s.entity(f"SURFACE_OF_REVOLUTION('',{meridian},{axis})")


@case("revolution_pole", "A paraboloid down to its pole, bounded by its rim and a vertex loop")
def _(s):
    _, surface = paraboloid(s)
    # The normal points out of the bowl: seen from there the face lies to the left of a rim that runs clockwise about z.
    rim = s.loop("-" + s.arc_edge((0.0, 0.0, 1.0), Z, X, 1.0))
    pole = s.entity(f"VERTEX_LOOP('',{s.vertex(ORIGIN)})")
    s.product("part", s.shells([s.face(surface, [rim, pole], PARABOLOID)]))


@case("revolution_quarter", "A quarter of a paraboloid with a corner in its pole")
def _(s):
    meridian, surface = paraboloid(s)
    turned = s.bspline_curve(2, [(0.0, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 1.0, 1.0)], [3, 3], [0.0, 1.0])
    first, last = s.edge(ORIGIN, (1.0, 0.0, 1.0), meridian), s.edge(ORIGIN, (0.0, 1.0, 1.0), turned)
    rim = s.arc_edge((0.0, 0.0, 1.0), Z, X, 1.0, 0.0, pi / 2)
    s.product("part", s.shells([s.face(surface, [s.loop(last, "-" + rim, "-" + first)], PARABOLOID / 4)]))


@case("pcurves", "A cylinder with pcurves: two for its seam, and a wrong one at its rim")
def _(s):
    surface = s.elementary("CYLINDRICAL_SURFACE", 3.0)
    pcurve = lambda *points: parameter_curve(s, surface, points)
    low, high = (s.circle((0.0, 0.0, z), Z, X, 3.0) for z in (0.0, 4.0))
    start, end = (3.0, 0.0, 0.0), (3.0, 0.0, 4.0)
    right = pcurve((0.0, 0.0), (tau, 0.0))
    # Half a millimetre below the rim it claims to be.
    wrong = pcurve((0.0, 3.5), (tau, 3.5))
    low_edge = s.edge(start, start, s.entity(f"SURFACE_CURVE('',{low},({right}),.CURVE_3D.)"))
    high_edge = s.edge(end, end, s.entity(f"SURFACE_CURVE('',{high},({wrong}),.CURVE_3D.)"))
    pair = ",".join([pcurve((tau, 0.0), (tau, 4.0)), pcurve((0.0, 0.0), (0.0, 4.0))])
    seam = s.edge(start, end, s.entity(f"SEAM_CURVE('',{s.line(start, end)},({pair}),.CURVE_3D.)"))
    loop = s.loop(low_edge, seam, "-" + high_edge, "-" + seam)
    s.product("part", s.shells([s.face(surface, [loop], 24 * pi)]))


@case("assembly_nested", "A cube twice in a pair, the pair three times in the whole, turned each time")
def _(s):
    cube = s.solid(box_faces(s, 2.0))
    cube = s.product("cube", cube), cube
    inner_places = [((10.0, 0.0, 0.0), Z, X), ((0.0, 0.0, 5.0), X, Y)]
    places = [s.axis(*place) for place in inner_places]
    pair = s.represent("SHAPE_REPRESENTATION", places)
    pair = s.product("pair", pair), pair
    for place in places:
        assembled(s, pair, cube, place)
    outer_places = [((100.0, 0.0, 0.0), Z, Y), ((0.0, 100.0, 0.0), MINUS_Z, X), ((0.0, 0.0, 100.0), X, Z)]
    places = [s.axis(*place) for place in outer_places]
    whole = s.represent("SHAPE_REPRESENTATION", places)
    whole = s.product("whole", whole), whole
    for place in places:
        assembled(s, whole, pair, place)
    s.instances = 6
    boxes = [moved(outer, moved(inner, [(x, y, z) for x in (0, 2) for y in (0, 2) for z in (0, 2)]))
             for outer in outer_places for inner in inner_places]
    corners = [corner for box in boxes for corner in box]
    s.bounds = [[pick(c[k] for c in corners) for k in range(3)] for pick in (min, max)]


@case("mapped_items", "A cube as mapped items: moved, and mirrored at twice its size")
def _(s):
    faces = box_faces(s, 2.0)
    cube = s.solid(faces)
    origin = s.axis()
    source = s.entity(f"REPRESENTATION_MAP({origin},{cube})")
    moved = s.entity(f"MAPPED_ITEM('',{source},{s.axis((10.0, 0.0, 0.0))})")
    # x is mirrored: the three axes are left-handed, which no axis placement can say.
    operator = s.entity(
        f"CARTESIAN_TRANSFORMATION_OPERATOR_3D('','',{s.direction(MINUS_X)},{s.direction(Y)},{s.point(ORIGIN)},2.,"
        f"{s.direction(Z)})")
    mirrored = s.entity(f"MAPPED_ITEM('',{source},{operator})")
    s.instances, s.area_factor = 2, 1 + 4
    s.bounds = [[-4.0, 0.0, 0.0], [12.0, 4.0, 4.0]]
    s.product("part", s.represent("SHAPE_REPRESENTATION", [moved, mirrored]))


if __name__ == "__main__":
    write(CASES, Path(__file__).resolve().parent)
    print(f"{len(CASES)} cases")
