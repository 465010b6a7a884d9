"""Entities that few files have: each kind of curve, surface and item once, in as many spellings as there are."""

from math import acos, asinh, atan, cos, cosh, pi, sin, sinh, sqrt, tan, tau

from shapes import MINUS_Y, MINUS_Z, assembled, box_faces, case, parameter_curve, rational, rectangle
from step_text import MILLIMETRE, ORIGIN, X, Y, Z, cross, plus, real, reals


def in_units(s, millimetres):
    """A context with lengths of so many millimetres, angles in degrees."""
    millimetre, radian = s.once(MILLIMETRE), s.once("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
    length = s.entity(f"LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({real(millimetres)}),{millimetre})")
    degree = s.once(f"PLANE_ANGLE_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE({real(pi / 180)}),{radian})")
    return s.context(f"(CONVERSION_BASED_UNIT('LENGTH',{length})LENGTH_UNIT()NAMED_UNIT($))",
                     f"(CONVERSION_BASED_UNIT('DEGREE',{degree})NAMED_UNIT($)PLANE_ANGLE_UNIT())")


def trimmed(s, curve, start, end, sense=".T.", by="PARAMETER"):
    """Ends as numbers (parameters), points, or both."""
    def select(end):
        parts = end if isinstance(end, list) else [end]
        return "(" + ",".join(s.point(p) if isinstance(p, tuple) else f"PARAMETER_VALUE({real(p)})" for p in parts) + ")"
    return s.entity(f"TRIMMED_CURVE('',{curve},{select(start)},{select(end)},{sense},.{by}.)")


def composite(s, curves, kind="COMPOSITE_CURVE"):
    """Curves by name; `-#12` is a segment against its curve."""
    parts = [s.entity(f"COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,{'.F.' if c.startswith('-') else '.T.'},{c.lstrip('-')})")
             for c in curves]
    return s.entity(f"{kind}('',({','.join(parts)}),.F.)")


def polyline(s, *points):
    return s.entity(f"POLYLINE('',({','.join(map(s.point, points))}))")


def bounded(s, surface, *boundaries, implicit=False):
    return s.entity(f"CURVE_BOUNDED_SURFACE('',{surface},({','.join(boundaries)}),{'.T.' if implicit else '.F.'})")


def cut_by(s, z, curve, start, end, area):
    """The part of the plane at height z between a curve and its chord."""
    boundary = composite(s, [curve, polyline(s, end, start)], "OUTER_BOUNDARY_CURVE")
    return s.bare(bounded(s, s.plane((0.0, 0.0, z)), boundary), area)


@case("trimmed_curves", "Trimmed curves by points, parameters or both, with and against their sense")
def _(s):
    items = []
    segment = lambda t: 4.5 * (t - sin(t))
    a, b = (lambda z: (3.0, 0.0, z)), (lambda z: (0.0, 3.0, z))
    spellings = [
        (0.0, pi / 2, ".T.", "PARAMETER"), (a, b, ".T.", "CARTESIAN"), (0.0, pi / 2, ".F.", "PARAMETER"),
        (a, b, ".F.", "CARTESIAN"), ([a, 0.0], [pi / 2, b], ".T.", "PARAMETER"), ([a, 0.0], [pi / 2, b], ".F.", "UNSPECIFIED"),
        # The file says which of the two it means.
        ([a, 1.0], [b, 2.0], ".T.", "CARTESIAN"), (-tau, -1.5 * pi, ".T.", "PARAMETER"),
    ]
    for k, (start, end, sense, by) in enumerate(spellings):
        z = float(k)
        place = lambda e: [p(z) if callable(p) else p for p in e] if isinstance(e, list) else e(z) if callable(e) else e
        curve = trimmed(s, s.circle((0.0, 0.0, z), Z, X, 3.0), place(start), place(end), sense, by)
        items.append(cut_by(s, z, curve, a(z), b(z), segment(pi / 2 if sense == ".T." else 1.5 * pi)))
    for k in range(2):
        z = 10.0 + k
        # A whole turn: from a point to itself, from 0 to 2 pi.
        ends = (0.0, tau) if k == 0 else (a(z), a(z))
        turn = trimmed(s, s.circle((0.0, 0.0, z), Z, X, 3.0), *ends, ".T.", "PARAMETER" if k == 0 else "CARTESIAN")
        items.append(s.bare(bounded(s, s.plane((0.0, 0.0, z)), composite(s, [turn], "BOUNDARY_CURVE")), 9 * pi))
    # An ellipse of radii 3 and 2, a parabola of focal length 0.5, a hyperbola of radii 2 and 1.
    place = s.axis((0.0, 0.0, 20.0))
    at = lambda t: (3.0 * cos(t), 2.0 * sin(t), 20.0)
    ellipse = trimmed(s, s.entity(f"ELLIPSE('',{place},3.,2.)"), 0.3, 1.8)
    items.append(cut_by(s, 20.0, ellipse, at(0.3), at(1.8), 3.0 * (1.5 - sin(1.5))))
    place = s.axis((0.0, 0.0, 21.0))
    at = lambda t: (0.5 * t * t, t, 21.0)
    parabola = trimmed(s, s.entity(f"PARABOLA('',{place},0.5)"), -1.0, 2.0)
    items.append(cut_by(s, 21.0, parabola, at(-1.0), at(2.0), 3.0**3 / 12))
    place = s.axis((0.0, 0.0, 22.0))
    at = lambda t: (2.0 * cosh(t), sinh(t), 22.0)
    hyperbola = trimmed(s, s.entity(f"HYPERBOLA('',{place},2.,1.)"), at(1.0), at(-1.0), ".F.", "CARTESIAN")
    items.append(cut_by(s, 22.0, hyperbola, at(1.0), at(-1.0), 2.0 * (sinh(1) * cosh(1) - 1)))
    # A trimmed curve of a trimmed one; a polyline by its parameter, which counts its points.
    inner = trimmed(s, trimmed(s, s.circle((0.0, 0.0, 23.0), Z, X, 3.0), -1.0, 3.0), a(23.0), b(23.0), ".T.", "CARTESIAN")
    items.append(cut_by(s, 23.0, inner, a(23.0), b(23.0), segment(pi / 2)))
    bent = trimmed(s, polyline(s, (0.0, 0.0, 24.0), (4.0, 0.0, 24.0), (4.0, 2.0, 24.0), (0.0, 2.0, 24.0)), 0.5, 2.5)
    items.append(cut_by(s, 24.0, bent, (2.0, 0.0, 24.0), (2.0, 2.0, 24.0), 4.0))
    # A composite curve by its parameter: those of its segments one after the other.
    line = s.entity(f"LINE('',{s.point((0.0, 0.0, 25.0))},{s.entity(f'''VECTOR('',{s.direction(X)},2.)''')})")
    arc = trimmed(s, s.circle((4.0, 1.0, 25.0), Z, MINUS_Y, 1.0), 0.0, pi)
    both = trimmed(s, composite(s, [trimmed(s, line, 0.0, 2.0), arc]), 1.0, 2.0 + pi / 2)
    items.append(cut_by(s, 25.0, both, (2.0, 0.0, 25.0), (5.0, 1.0, 25.0), 0.5 + pi / 4))
    s.product("part", s.set_of(items))


@case("trimmed_degrees", "Trimmed conics with parameters in degrees, lengths in quarters of an inch")
def _(s):
    s.scale = 6.35
    context = in_units(s, 6.35)
    arc = trimmed(s, s.circle(ORIGIN, Z, X, 3.0), 0.0, 90.0)
    parabola = trimmed(s, s.entity(f"PARABOLA('',{s.axis((0.0, 0.0, 1.0))},0.5)"), -1.0, 2.0)
    hyperbola = trimmed(s, s.entity(f"HYPERBOLA('',{s.axis((0.0, 0.0, 2.0))},2.,1.)"), 1.0, -1.0, ".F.")
    at = lambda t: (2.0 * cosh(t), sinh(t), 2.0)
    items = [
        cut_by(s, 0.0, arc, (3.0, 0.0, 0.0), (0.0, 3.0, 0.0), 4.5 * (pi / 2 - 1)),
        cut_by(s, 1.0, parabola, (0.5, -1.0, 1.0), (2.0, 2.0, 1.0), 3.0**3 / 12),
        cut_by(s, 2.0, hyperbola, at(1.0), at(-1.0), 2.0 * (sinh(1) * cosh(1) - 1)),
    ]
    # From 30 to 120 degrees of an arc turned about an axis that it does not meet: a part of a torus.
    profile = trimmed(s, s.circle((0.0, 9.0, 0.0), X, Y, 2.0), 30.0, 120.0)
    surface = s.entity(f"SURFACE_OF_REVOLUTION('',{profile},{s.entity(f'''AXIS1_PLACEMENT('',{s.point(ORIGIN)},{s.direction(Z)})''')})")
    turned = s.entity(f"RECTANGULAR_TRIMMED_SURFACE('',{surface},0.,45.,30.,120.,.T.,.T.)")
    items.append(s.bare(turned, pi / 4 * 2.0 * (9.0 * pi / 2 + 2.0 * (sin(2 * pi / 3) - sin(pi / 6)))))
    s.product("part", s.represent("GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION",
                                  [s.entity(f"GEOMETRIC_SET('',({','.join(items)}))")], context))


@case("composite_edges", "Edges along composite curves with reversed segments, and along polylines")
def _(s):
    arc = lambda center, t0, t1, sense=".T.": trimmed(s, s.circle(center, Z, X, 3.0), t0, t1, sense)
    a, b = (3.0, 0.0, 0.0), (-3.0, 0.0, 0.0)
    half = composite(s, [arc(ORIGIN, 0.0, pi / 2), "-" + arc(ORIGIN, pi, pi / 2, ".F.")])
    zigzag = polyline(s, b, (-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), a)
    disc = s.face(s.plane(), [s.loop(s.edge(a, b, half), s.edge(b, a, zigzag))], 4.5 * pi + 4.0)
    # The same curves for edges that run against them.
    up = lambda p: plus(p, (5.0, Z))
    half = composite(s, [arc(up(ORIGIN), 0.0, pi / 2), "-" + arc(up(ORIGIN), pi, pi / 2, ".F.")])
    zigzag = polyline(s, up(b), up((-1.0, -1.0, 0.0)), up((1.0, -1.0, 0.0)), up(a))
    edges = [s.edge(up(b), up(a), half, same=False), s.edge(up(a), up(b), zigzag, same=False)]
    other = s.face(s.plane(up(ORIGIN)), [s.loop("-" + edges[0], "-" + edges[1])], 4.5 * pi + 4.0)
    # One closed composite curve, used from a vertex that is not where it starts.
    square = composite(s, [polyline(s, (0.0, 0.0, 9.0), (2.0, 0.0, 9.0), (2.0, 2.0, 9.0)),
                           "-" + polyline(s, (0.0, 0.0, 9.0), (0.0, 2.0, 9.0), (2.0, 2.0, 9.0))],
                       "COMPOSITE_CURVE_ON_SURFACE")
    corner = (2.0, 0.0, 9.0)
    closed = s.face(s.plane((0.0, 0.0, 9.0)), [s.loop(s.edge(corner, corner, square))], 4.0)
    # Around a cylinder: four arcs, two of them reversed.
    def ring(z):
        c = (20.0, 0.0, z)
        return composite(s, [arc(c, 0.0, 1.0), "-" + arc(c, 3.0, 1.0, ".F."), arc(c, 3.0, 4.0), "-" + arc(c, tau, 4.0, ".F.")])
    rings = [s.edge((23.0, 0.0, z), (23.0, 0.0, z), ring(z)) for z in (0.0, 2.0)]
    band = s.face(s.elementary("CYLINDRICAL_SURFACE", 3.0, origin=(20.0, 0.0, 0.0)),
                  [s.loop(rings[0]), s.loop("-" + rings[1])], 12 * pi)
    s.product("part", s.shells([disc, other, closed, band]))


@case("conic_edges", "Plane faces bounded by parabolas, hyperbolas and parts of ellipses, used both ways")
def _(s):
    faces = []
    kinds = [
        ("PARABOLA", "0.5", lambda t: (0.5 * t * t, t), -1.0, 2.0, 3.0**3 / 12),
        ("HYPERBOLA", "2.,1.", lambda t: (2.0 * cosh(t), sinh(t)), -1.0, 1.5, (sinh(2.5) - 2.5)),
        ("ELLIPSE", "3.,2.", lambda t: (3.0 * cos(t), 2.0 * sin(t)), -0.7, 2.0, 3.0 * (2.7 - sin(2.7))),
    ]
    for k, (kind, radii, at, t0, t1, area) in enumerate(kinds):
        for same in (True, False):
            z = 2.0 * k + (0.0 if same else 1.0)
            curve = s.entity(f"{kind}('',{s.axis((0.0, 0.0, z))},{radii})")
            start, end = ((*at(t), z) for t in (t0, t1))
            edge = s.edge(start, end, curve) if same else "-" + s.edge(end, start, curve, same=False)
            faces.append(s.face(s.plane((0.0, 0.0, z)), [s.loop(edge, s.line_edge(end, start))], area))
    s.product("part", s.shells(faces))


@case("cone_sections", "A cone cut by planes: in an ellipse, a parabola and a hyperbola")
def _(s):
    s.exact = True
    # Half angle 30 degrees, apex at the origin: areas are those seen along the axis over sin 30 degrees.
    angle = pi / 6
    k, height = 1 / tan(angle), 10.0
    radius = height / k
    surface = lambda: s.elementary("CONICAL_SURFACE", 0.0, angle)
    cap = lambda distance: radius**2 * acos(distance / radius) - distance * sqrt(radius**2 - distance**2)
    # Between the circle at the top and the plane z = 3 + x/2: the rim of the lower end is an ellipse.
    top = s.arc_edge((0.0, 0.0, height), Z, X, radius)
    # r k = 3 + r cos(t)/2: a focus of the ellipse, seen from above, is on the axis.
    p, e = 3.0 / k, 0.5 / k
    seen_a, seen_b = p / (1 - e * e), p / sqrt(1 - e * e)
    center_x = e * seen_a
    along = (1.0 / sqrt(1.25), 0.0, 0.5 / sqrt(1.25))
    axis = s.axis((center_x, 0.0, 3.0 + center_x / 2), cross(along, Y), along)
    ellipse = s.entity(f"ELLIPSE('',{axis},{real(seen_a * sqrt(1.25))},{real(seen_b)})")
    start = (seen_a + center_x, 0.0, 3.0 + (seen_a + center_x) / 2)
    low = s.edge(start, start, ellipse)
    frustum = s.face(surface(), [s.loop(top), s.loop(low)], (pi * radius**2 - pi * seen_a * seen_b) / sin(angle), same=False)
    # Beyond the plane x = 2: z = k sqrt(4 + y^2) is a hyperbola.
    y = sqrt(radius**2 - 4.0)
    ends = [(2.0, y, height), (2.0, -y, height)]
    hyperbola = s.entity(f"HYPERBOLA('',{s.axis((2.0, 0.0, 0.0), X, Z)},{real(2 * k)},2.)")
    turn = acos(2.0 / radius)
    arc = s.arc_edge((0.0, 0.0, height), Z, X, radius, -turn, turn)
    # The hyperbola's second axis is X x Z = -Y: it runs from +y to -y.
    flank = s.face(surface(), [s.loop(arc, s.edge(ends[0], ends[1], hyperbola))], cap(2.0) / sin(angle), same=False)
    # Beyond the plane z = k (x + 1), which is parallel to a ruling: r = x + 1 is a parabola about the axis.
    c = 1.0
    x = radius - c
    y = sqrt(2 * c * x + c * c)
    slope = sqrt(1 + k * k)
    up = (1 / slope, 0.0, k / slope)
    # In the plane: distance s up from the vertex at x = -c/2; y^2 = 2 c (x + c/2) = 2 c s / slope.
    focal = c / (2 * slope)
    parabola = s.entity(f"PARABOLA('',{s.axis((-c / 2, 0.0, k * c / 2), cross(up, Y), up)},{real(focal)})")
    ends = [(x, -y, height), (x, y, height)]
    turn = acos(x / radius)
    arc = s.arc_edge((0.0, 0.0, height), Z, X, radius, turn, tau - turn)
    wing = s.edge(ends[0], ends[1], parabola)
    # Seen from above it is what r = c / (1 - cos t) leaves of the disc.
    inner = lambda t: -(1 / tan(t / 2) + 1 / tan(t / 2)**3 / 3) / 2
    seen = 0.5 * (radius**2 * (tau - 2 * turn) - c * c * (inner(tau - turn) - inner(turn)))
    shovel = s.face(surface(), [s.loop(arc, wing)], seen / sin(angle), same=False)
    s.product("part", s.shells([frustum, flank, shovel]))


@case("cylinder_sections", "A cylinder between two oblique planes, whole and in part, and one cut by a slanted window")
def _(s):
    s.exact = True
    # z = 2 x / 3 below, z = 6 - x / 3 + y / 2 above; radius 3.
    surface = s.elementary("CYLINDRICAL_SURFACE", 3.0)
    height = lambda plane, x, y: plane[0] + plane[1] * x + plane[2] * y

    def ellipse(plane):
        _, a, b = plane
        steep = sqrt(a * a + b * b)
        flat = (a / steep, b / steep, 0.0)
        along = tuple(v / sqrt(1 + steep**2) for v in (flat[0], flat[1], steep))
        place = s.axis((0.0, 0.0, plane[0]), cross(along, cross(Z, flat)), along)
        return s.entity(f"ELLIPSE('',{place},{real(3 * sqrt(1 + steep**2))},3.)")

    def at(plane, t):
        x, y = 3.0 * cos(t), 3.0 * sin(t)
        return (x, y, height(plane, x, y))
    low, high = (0.0, 2 / 3, 0.0), (6.0, -1 / 3, 0.5)
    rims = [s.edge(at(plane, 0.4), at(plane, 0.4), ellipse(plane)) for plane in (low, high)]
    whole = s.face(surface, [s.loop(rims[0]), s.loop("-" + rims[1])], tau * 3.0 * 6.0)
    # From 1 to 4.5 radians of it, farther up.
    low, high = (10.0, 2 / 3, 0.0), (16.0, -1 / 3, 0.5)
    t0, t1 = 1.0, 4.5
    edges = [s.edge(at(plane, t0), at(plane, t1), ellipse(plane)) for plane in (low, high)]
    sides = [s.line_edge(at(low, t), at(high, t)) for t in (t1, t0)]
    area = 3.0 * (6.0 * (t1 - t0) + 3.0 * (-1.0 * (sin(t1) - sin(t0)) - 0.5 * (cos(t1) - cos(t0))))
    part = s.face(surface, [s.loop(edges[0], sides[0], "-" + edges[1], "-" + sides[1])], area)
    s.product("part", s.shells([whole, part]))


@case("extrusion_sections", "Extrusions cut by oblique planes: of a circle, and of a B-spline")
def _(s):
    s.exact = True
    vector = s.entity(f"VECTOR('',{s.direction(Z)},1.)")
    tube = s.entity(f"SURFACE_OF_LINEAR_EXTRUSION('',{s.circle(ORIGIN, Z, X, 3.0)},{vector})")
    ring = s.arc_edge(ORIGIN, Z, X, 3.0)
    along = (1 / sqrt(2), 0.0, 1 / sqrt(2))
    start = (3.0, 0.0, 8.0)
    slanted = s.edge(start, start, s.entity(f"ELLIPSE('',{s.axis((0.0, 0.0, 5.0), cross(along, Y), along)},{real(3 * sqrt(2))},3.)"))
    band = s.face(tube, [s.loop(ring), s.loop("-" + slanted)], tau * 3.0 * 5.0)
    # y = x^2 from 0 to 1, up to the plane z = 1 + x: the area is the integral of (1 + x) sqrt(1 + 4 x^2).
    profile = lambda z: [(10.0, 0.0, z(0.0)), (10.5, 0.0, z(0.5)), (11.0, 1.0, z(1.0))]
    curve = lambda z: s.bspline_curve(2, profile(z), [3, 3], [0.0, 1.0])
    flat, tilted = (lambda x: 0.0), (lambda x: 1.0 + x)
    sheet = s.entity(f"SURFACE_OF_LINEAR_EXTRUSION('',{curve(flat)},{vector})")
    low, high = (s.edge(profile(z)[0], profile(z)[2], curve(z)) for z in (flat, tilted))
    left, right = (s.line_edge(profile(flat)[k], profile(tilted)[k]) for k in (0, 2))
    area = sqrt(5) / 2 + asinh(2) / 4 + (5 * sqrt(5) - 1) / 12
    fin = s.face(sheet, [s.loop(low, right, "-" + high, "-" + left)], area)
    s.product("part", s.shells([band, fin]))


@case("boundary_curves", "Curve-bounded surfaces with pcurves in their boundary, reversed segments, and their own border")
def _(s):
    cylinder = s.elementary("CYLINDRICAL_SURFACE", 3.0)
    pcurve = lambda a, b: parameter_curve(s, cylinder, [a, b])
    corners = [(-0.5, 1.0), (1.0, 1.0), (1.0, 3.0), (-0.5, 3.0)]
    sides = [pcurve(corners[k], corners[(k + 1) % 4]) for k in range(4)]
    sides[2] = "-" + pcurve(corners[3], corners[2])
    # One side as a curve in space that knows its pcurve.
    up = s.line((3.0 * cos(1.0), 3.0 * sin(1.0), 1.0), (3.0 * cos(1.0), 3.0 * sin(1.0), 3.0))
    ends = [(3.0 * cos(1.0), 3.0 * sin(1.0), z) for z in (1.0, 3.0)]
    sides[1] = s.entity(f"SURFACE_CURVE('',{trimmed(s, up, *ends, '.T.', 'CARTESIAN')},({sides[1]}),.CURVE_3D.)")
    window = s.bare(bounded(s, cylinder, composite(s, sides, "OUTER_BOUNDARY_CURVE")), 9.0)
    # A rectangle's own border, with a round hole in it, and two holes of which one is a composite curve on the surface.
    plane = s.plane((20.0, 0.0, 0.0))
    sheet = s.entity(f"RECTANGULAR_TRIMMED_SURFACE('',{plane},0.,4.,0.,3.,.T.,.T.)")
    hole = composite(s, ["-" + trimmed(s, s.circle((21.0, 1.5, 0.0), Z, X, 0.5), 0.0, tau)], "BOUNDARY_CURVE")
    slot = [trimmed(s, s.circle((23.0, 1.5, 0.0), Z, X, 0.5), 0.0, pi), polyline(s, (22.5, 1.5, 0.0), (23.5, 1.5, 0.0))]
    slot = composite(s, slot, "BOUNDARY_CURVE")
    items = [window, s.bare(bounded(s, sheet, hole, slot, implicit=True), 12.0 - 0.25 * pi - 0.125 * pi)]
    # The border of a B-spline surface: y = x^2 moved by 2.
    net = [[(x, y, z) for z in (0.0, 2.0)] for x, y in ((30.0, 0.0), (30.5, 0.0), (31.0, 1.0))]
    spline = s.bspline_surface((2, 1), net, ([3, 3], [2, 2]), ([0.0, 1.0], [0.0, 2.0]))
    hole = [parameter_curve(s, spline, [a, b]) for a, b in
            [((0.0, 0.5), (0.0, 1.5)), ((0.0, 1.5), (1.0, 1.5)), ((1.0, 1.5), (1.0, 0.5)), ((1.0, 0.5), (0.0, 0.5))]]
    items.append(s.bare(bounded(s, spline, composite(s, hole, "BOUNDARY_CURVE"), implicit=True), sqrt(5) / 2 + asinh(2) / 4))
    s.warnings = ["approximated in space"] * 7
    s.product("part", s.set_of(items))


@case("lone_pcurves", "Edges that only their pcurves give, and a pole that a degenerate pcurve names")
def _(s):
    surface = s.elementary("CYLINDRICAL_SURFACE", 3.0)
    at = lambda u, v: (3.0 * cos(u), 3.0 * sin(u), v)
    corners = [(0.2, 0.0), (1.7, 0.5), (1.7, 2.0), (0.2, 2.0)]
    pairs = [(corners[k], corners[(k + 1) % 4]) for k in range(4)]
    edges = [s.edge(at(*a), at(*b), parameter_curve(s, surface, [a, b])) for a, b in pairs]
    helical = s.face(surface, [s.loop(*edges)], 3.0 * (1.5 * 2.0 - 0.5 * 1.5 * 0.5))
    sphere = s.elementary("SPHERICAL_SURFACE", 5.0, origin=(20.0, 0.0, 0.0))
    c, pole = (20.0, 0.0, 0.0), (20.0, 0.0, 5.0)
    arcs = [s.arc_edge(c, Z, X, 5.0, 0.0, pi / 2), s.arc_edge(c, X, Y, 5.0, 0.0, pi / 2), s.arc_edge(c, Y, Z, 5.0, 0.0, pi / 2)]
    space = s.once("(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()REPRESENTATION_CONTEXT('',''))")
    line = s.bspline_curve(1, [(pi / 2, pi / 2), (0.0, pi / 2)], [2, 2], [0.0, 1.0])
    definition = s.entity(f"DEFINITIONAL_REPRESENTATION('',({line}),{space})")
    point = s.edge(pole, pole, s.entity(f"DEGENERATE_PCURVE('',{sphere},{definition})"))
    octant = s.face(sphere, [s.loop(arcs[0], arcs[1], point, arcs[2])], 25 * pi / 2)
    s.warnings = ["approximated in space"] * 4
    s.product("part", s.shells([helical, octant]))
