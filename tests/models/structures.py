"""Surfaces of surfaces, sets and shells, units side by side, what is hidden, what stands in other files."""

from math import asinh, atan, cos, pi, sin, sqrt, tan, tau

from entities import in_units, trimmed
from shapes import MINUS_X, MINUS_Y, MINUS_Z, assembled, box_faces, case
from step_text import ORIGIN, X, Y, Z, plus, real

PARABOLA = sqrt(5) / 2 + asinh(2) / 4


def offset_curve(s, basis, distance):
    return s.entity(f"OFFSET_CURVE_3D('',{basis},{real(distance)},.F.,{s.direction(Z)})")


@case("offset_curves", "Edges along offsets of a circle, a line, a parabola and an ellipse")
def _(s):
    faces = []
    ring = s.edge((3.5, 0.0, 0.0), (3.5, 0.0, 0.0), offset_curve(s, s.circle(ORIGIN, Z, X, 3.0), -0.5))
    faces.append(s.face(s.plane(), [s.loop(ring)], pi * 3.5**2))
    # Half a millimetre to the left of its line.
    a, b, c, d = (10.0, 0.5, 0.0), (14.0, 0.5, 0.0), (14.0, 2.0, 0.0), (10.0, 2.0, 0.0)
    low = s.edge(a, b, offset_curve(s, s.line((10.0, 0.0, 0.0), (14.0, 0.0, 0.0)), 0.5))
    sides = [s.line_edge(b, c), s.line_edge(c, d), s.line_edge(d, a)]
    faces.append(s.face(s.plane(), [s.loop(low, *sides)], 6.0))
    # Between y = x^2 and its offset to the inside of the bend.
    points = [(20.0, 0.0, 0.0), (20.5, 0.0, 0.0), (21.0, 1.0, 0.0)]
    curve = s.bspline_curve(2, points, [3, 3], [0.0, 1.0])
    start, end = (20.0, 0.25, 0.0), plus(points[2], (0.25 / sqrt(5), (-2.0, 1.0, 0.0)))
    outer, inner = s.edge(points[0], points[2], curve), s.edge(start, end, offset_curve(s, curve, 0.25))
    loop = s.loop(outer, s.line_edge(points[2], end), "-" + inner, s.line_edge(start, points[0]))
    faces.append(s.face(s.plane(), [loop], 0.25 * PARABOLA - 0.25**2 / 2 * atan(2.0)))
    # Steiner: an offset adds the perimeter times the distance, and a disc. The sum over a period is exact to rounding.
    place = s.axis((30.0, 0.0, 0.0))
    perimeter = sum(sqrt(9.0 * sin(t)**2 + 4.0 * cos(t)**2) for t in (tau * k / 256 for k in range(256))) * tau / 256
    rim = s.edge((34.0, 0.0, 0.0), (34.0, 0.0, 0.0), offset_curve(s, s.entity(f"ELLIPSE('',{place},3.,2.)"), -1.0))
    faces.append(s.face(s.plane(), [s.loop(rim)], 6.0 * pi + perimeter + pi))
    s.warnings = ["offset curve approximated to 1e-6 mm"] * 2
    s.product("part", s.shells(faces))


def window(s, surface, u, v, senses=(".T.", ".T.")):
    numbers = ",".join(real(t) for t in (*u, *v))
    return s.entity(f"RECTANGULAR_TRIMMED_SURFACE('',{surface},{numbers},{','.join(senses)})")


@case("offset_surfaces", "Offsets of each kind of surface, inward and outward, of a reversed one and of another offset")
def _(s):
    def offset(surface, distance):
        return s.entity(f"OFFSET_SURFACE('',{surface},{real(distance)},.F.)")
    items = []
    add = lambda surface, u, v, area: items.append(s.bare(window(s, surface, u, v), area))
    at = lambda k: (30.0 * k, 0.0, 0.0)
    add(offset(s.plane(at(0)), 2.0), (0.0, 2.0), (0.0, 3.0), 6.0)
    angle = pi / 6
    cone = s.elementary("CONICAL_SURFACE", 3.0, angle, origin=at(1))
    add(offset(cone, 0.5), (0.0, 1.0), (0.0, 2.0), (3.0 + 0.5 * cos(angle) + tan(angle)) * 2.0 / cos(angle))
    add(offset(s.elementary("SPHERICAL_SURFACE", 5.0, origin=at(2)), -1.0), (0.0, 1.0), (0.0, pi / 2), 16.0)
    tube = lambda minor, v0, v1: minor * (10.0 * (v1 - v0) + minor * (sin(v1) - sin(v0)))
    add(offset(s.elementary("TOROIDAL_SURFACE", 10.0, 3.0, origin=at(3)), 0.5), (0.0, 1.0), (0.5, 2.0), tube(3.5, 0.5, 2.0))
    # Against its first sense the surface looks inward, and so does its offset.
    cylinder = s.elementary("CYLINDRICAL_SURFACE", 3.0, origin=at(4))
    inward = window(s, cylinder, (1.0, 0.0), (0.0, 2.0), (".F.", ".T."))
    items.append(s.bare(offset(inward, 0.5), 2.5 * 2.0))
    ball = s.elementary("SPHERICAL_SURFACE", 5.0, origin=at(5))
    add(offset(offset(ball, 1.0), -3.0), (0.0, 1.0), (0.0, pi / 2), 9.0)
    up = s.entity(f"VECTOR('',{s.direction(Z)},1.)")
    swept = s.entity(f"SURFACE_OF_LINEAR_EXTRUSION('',{s.circle(at(6), Z, X, 3.0)},{up})")
    add(offset(swept, 0.5), (0.0, 1.0), (0.0, 2.0), 7.0)
    axis = s.entity(f"AXIS1_PLACEMENT('',{s.point(at(7))},{s.direction(Z)})")
    profile = s.circle(plus(at(7), (10.0, X)), MINUS_Y, X, 2.0)
    turned = s.entity(f"SURFACE_OF_REVOLUTION('',{profile},{axis})")
    add(offset(turned, 0.25), (0.0, 1.0), (0.5, 2.0), tube(2.25, 0.5, 2.0))
    s.warnings = ["the offset surface is fitted to within"] * 2
    s.product("part", s.set_of(items))


def operator(s, x, y, origin, scale, z):
    directions = [s.direction(d) for d in (x, y, z)]
    return s.entity(f"CARTESIAN_TRANSFORMATION_OPERATOR_3D('','',{directions[0]},{directions[1]},{s.point(origin)},"
                    f"{real(scale)},{directions[2]})")


@case("replicas", "Copies of surfaces and curves, moved, at twice their size, and mirrored")
def _(s):
    items, faces = [], []
    replica = lambda surface, to: s.entity(f"SURFACE_REPLICA('',{surface},{to})")
    angle = pi / 6
    up = s.entity(f"VECTOR('',{s.direction(Z)},1.)")
    axis = s.entity(f"AXIS1_PLACEMENT('',{s.point(ORIGIN)},{s.direction(Z)})")
    parents = [
        (s.plane(), (0.0, 2.0), (0.0, 3.0), 6.0),
        (s.elementary("CYLINDRICAL_SURFACE", 3.0), (0.5, 1.5), (0.0, 2.0), 6.0),
        (s.elementary("CONICAL_SURFACE", 3.0, angle), (0.5, 1.5), (0.0, 2.0), (3.0 + tan(angle)) * 2.0 / cos(angle)),
        (s.elementary("SPHERICAL_SURFACE", 3.0), (0.5, 1.5), (0.2, 1.0), 9.0 * (sin(1.0) - sin(0.2))),
        (s.elementary("TOROIDAL_SURFACE", 5.0, 2.0), (0.5, 1.5), (0.2, 1.0), 2.0 * (4.0 + 2.0 * (sin(1.0) - sin(0.2)))),
        (s.entity(f"SURFACE_OF_LINEAR_EXTRUSION('',{s.entity(f'''PARABOLA('',{s.axis()},0.5)''')},{up})"), (0.0, 1.0), (0.0, 2.0),
         (sqrt(2) + asinh(1)) / 2 * 2.0),
        # Half a turn of the hyperbola's half: checked by Pappus on a line instead, a cone from radius 4 to 2.
        (s.entity(f"SURFACE_OF_REVOLUTION('',{s.line((4.0, 0.0, 0.0), (2.0, 0.0, 2.0))},{axis})"), (0.5, 1.5), (0.0, sqrt(8)),
         3.0 * sqrt(8)),
        (s.bspline_surface((2, 1), [[(x, y, z) for z in (0.0, 2.0)] for x, y in ((0.0, 0.0), (0.5, 0.0), (1.0, 1.0))],
                           ([3, 3], [2, 2]), ([0.0, 1.0], [0.0, 2.0])), (0.0, 1.0), (0.0, 2.0), 2.0 * PARABOLA),
    ]
    for k, (parent, u, v, area) in enumerate(parents):
        turned = operator(s, Y, MINUS_X, (20.0 * k, 0.0, 0.0), 2.0, Z)
        mirrored = operator(s, MINUS_X, Y, (20.0 * k, 30.0, 0.0), 1.0, Z)
        items.append(s.bare(window(s, replica(parent, turned), u, v), 4.0 * area))
        items.append(s.bare(window(s, replica(parent, mirrored), u, v), area))
    # A face on a mirrored cone, between mirrored copies of edges, at twice the size: x to -x, y to y, z to z.
    cone = s.elementary("CONICAL_SURFACE", 3.0, angle)
    mirror = operator(s, MINUS_X, Y, (0.0, -40.0, 0.0), 2.0, Z)
    copy = lambda curve: s.entity(f"CURVE_REPLICA('',{curve},{mirror})")
    radius = lambda z: 3.0 + z * tan(angle)
    point = lambda u, z: (radius(z) * cos(u), radius(z) * sin(u), z)
    there = lambda p: (-2.0 * p[0], 2.0 * p[1] - 40.0, 2.0 * p[2])
    arc = lambda z: s.edge(there(point(0.3, z)), there(point(1.4, z)), copy(s.circle((0.0, 0.0, z), Z, X, radius(z))))
    side = lambda u: s.edge(there(point(u, 0.0)), there(point(u, 2.0)), copy(s.line(point(u, 0.0), point(u, 2.0))))
    loop = s.loop(arc(0.0), side(1.4), "-" + arc(2.0), "-" + side(0.3))
    faces.append(s.face(replica(cone, mirror), [loop], 4.0 * 1.1 * (3.0 + tan(angle)) * 2.0 / cos(angle)))
    # An edge along a copy of an arc with ends of its own, and of a B-spline.
    up = operator(s, X, Y, (0.0, -80.0, 0.0), 3.0, Z)
    half = s.entity(f"CURVE_REPLICA('',{trimmed(s, s.circle(ORIGIN, Z, X, 1.0), 0.0, pi)},{up})")
    dip = s.entity(f"CURVE_REPLICA('',{s.bspline_curve(2, [(-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0)], [3, 3], [0.0, 1.0])},{up})")
    a, b = (3.0, -80.0, 0.0), (-3.0, -80.0, 0.0)
    faces.append(s.face(s.plane(), [s.loop(s.edge(a, b, half), s.edge(b, a, dip))], 9.0 * (pi / 2 + 2 / 3)))
    shell = s.entity(f"OPEN_SHELL('',({','.join(faces)}))")
    items = [s.entity(f"GEOMETRIC_SET('',({','.join(items)}))"), s.entity(f"SHELL_BASED_SURFACE_MODEL('',({shell}))")]
    s.product("part", s.represent("SHAPE_REPRESENTATION", items))


def bezier_area(points, weights=None):
    """Between a plane Bezier curve and its chord; Gauss-Legendre sums of a hundred parts."""
    n = len(points) - 1
    weights = weights or [1.0] * (n + 1)

    def at(t):
        line = [(w * p[0], w * p[1], w) for p, w in zip(points, weights)]
        while len(line) > 1:
            line = [tuple((1 - t) * a + t * b for a, b in zip(p, q)) for p, q in zip(line, line[1:])]
        return line[0][0] / line[0][2], line[0][1] / line[0][2]
    nodes, total = [(0.5 - sqrt(15) / 10, 5 / 18), (0.5, 4 / 9), (0.5 + sqrt(15) / 10, 5 / 18)], 0.0
    for part in range(100):
        for x, w in nodes:
            t, h = (part + x) / 100, 1e-5
            (x0, y0), (x1, y1), (x, y) = at(t - h), at(t + h), at(t)
            total += w / 100 * 0.5 * ((x - points[0][0]) * (y1 - y0) - (y - points[0][1]) * (x1 - x0)) / (2 * h)
    return abs(total)


@case("spline_edges", "Edges along B-spline curves in all spellings, polynomial and rational")
def _(s):
    faces = []
    h = sqrt(0.5)

    def add(k, text, points, area):
        """`text` with @ for the control points, which run from the first to the last one unless `points` has ends."""
        z = float(k)
        up = [(x, y, z) for x, y in points["net"]]
        start, end = ((*p, z) for p in points.get("ends", (points["net"][0], points["net"][-1])))
        edge = s.edge(start, end, s.entity(text.replace("@", "(" + ",".join(map(s.point, up)) + ")")))
        faces.append(s.face(s.plane((0.0, 0.0, z)), [s.loop(edge, s.line_edge(end, start))], area))

    def spelled(kind, degree, weights, knots=""):
        parts = ["BOUNDED_CURVE()", f"B_SPLINE_CURVE({degree},@,.UNSPECIFIED.,.F.,.F.)", f"{kind}({knots})", "CURVE()",
                 "GEOMETRIC_REPRESENTATION_ITEM()", f"RATIONAL_B_SPLINE_CURVE({weights})", "REPRESENTATION_ITEM('')"]
        return "(" + "".join(sorted(parts)) + ")"
    arch = [(0.0, 0.0), (1.0, 2.0), (3.0, 2.0), (4.0, 0.0)]
    body = "@,.UNSPECIFIED.,.F.,.F."
    cubic = bezier_area(arch)
    add(0, f"BEZIER_CURVE('',3,{body})", {"net": arch}, cubic)
    add(1, f"B_SPLINE_CURVE_WITH_KNOTS('',3,{body},(4,4),(0.,1.),.UNSPECIFIED.)", {"net": arch}, cubic)
    add(2, f"QUASI_UNIFORM_CURVE('',3,{body})", {"net": arch}, cubic)
    # Two parabolas that meet in the middle of the middle leg: half of it for each.
    left, right = [arch[0], arch[1], (2.0, 2.0)], [(2.0, 2.0), arch[2], arch[3]]
    two = bezier_area(left) + bezier_area(right) + 4.0
    add(3, f"QUASI_UNIFORM_CURVE('',2,{body})", {"net": arch}, two)
    # Uniform knots: from the middle of the first leg to the middle of the last one.
    ends = [(0.5, 1.0), (3.5, 1.0)]
    uniform = bezier_area([ends[0], arch[1], (2.0, 2.0)]) + bezier_area([(2.0, 2.0), arch[2], ends[1]]) + 1.5
    add(4, f"UNIFORM_CURVE('',2,{body})", {"net": arch, "ends": ends}, uniform)
    quarter, segment = [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)], pi / 4 - 0.5
    add(5, spelled("BEZIER_CURVE", 2, f"(1.,{real(h)},1.)"), {"net": quarter}, segment)
    add(6, spelled("B_SPLINE_CURVE_WITH_KNOTS", 2, f"(1.,{real(h)},1.)", "(3,3),(0.,1.),.UNSPECIFIED."), {"net": quarter}, segment)
    add(7, spelled("QUASI_UNIFORM_CURVE", 2, f"(2.,{real(2 * h)},2.)"), {"net": quarter}, segment)
    add(8, spelled("UNIFORM_CURVE", 2, "(3.,3.,3.,3.)"), {"net": arch, "ends": ends}, uniform)
    weights = [1.0, 3.0, 0.5, 1.0]
    add(9, spelled("BEZIER_CURVE", 3, "(1.,3.,0.5,1.)"), {"net": arch}, bezier_area(arch, weights))
    s.tolerance = 1e-7
    s.product("part", s.shells(faces))


@case("parts_of_faces", "Oriented faces and shells, a subface, a subedge, edges without curves, polygons without surfaces")
def _(s):
    square = lambda z, size=4.0: [(0.0, 0.0, z), (size, 0.0, z), (size, size, z), (0.0, size, z)]
    plane = lambda z: s.plane((0.0, 0.0, z))
    plain = s.face(plane(0.0), [s.polygon(square(0.0))], 16.0)
    turned = s.entity(f"ORIENTED_FACE('',*,{plain},.F.)")
    # A part of another face that is not shown itself.
    parent = s.entity(f"FACE_SURFACE('',({s.bound(s.polygon(square(1.0)), outer=True)}),{plane(1.0)},.T.)")
    part = s.entity(f"SUBFACE('',({s.bound(s.polygon(square(1.0, 2.0)), outer=True)}),{parent})")
    s.areas[int(part[1:])] = 4.0
    # A quarter of a circle that is a part of a longer edge.
    whole = s.arc_edge((0.0, 0.0, 2.0), Z, X, 3.0, 0.0, pi)
    a, b, c = (3.0, 0.0, 2.0), (0.0, 3.0, 2.0), (0.0, 0.0, 2.0)
    quarter = s.entity(f"SUBEDGE('',{s.vertex(a)},{s.vertex(b)},{whole})")
    slice = s.face(plane(2.0), [s.loop(quarter, s.line_edge(b, c), s.line_edge(c, a))], 9 * pi / 4)
    # Edges that have vertices only, and a face that has no surface.
    corners = square(3.0)
    straight = [s.entity(f"EDGE('',{s.vertex(p)},{s.vertex(q)})") for p, q in zip(corners, corners[1:] + corners[:1])]
    framed = s.face(plane(3.0), [s.loop(*straight)], 16.0)
    flat = s.entity(f"FACE('',({s.bound(s.polygon([(0.0, 0.0, 4.0), (4.0, 0.0, 6.0), (0.0, 3.0, 4.0)]), outer=True)}))")
    s.areas[int(flat[1:])] = 0.5 * sqrt(12.0**2 + 6.0**2)
    shells = [s.entity(f"OPEN_SHELL('',({','.join(faces)}))") for faces in ([turned, part], [slice, framed, flat])]
    shells[1] = s.entity(f"ORIENTED_OPEN_SHELL('',*,{shells[1]},.F.)")
    model = s.entity(f"SHELL_BASED_SURFACE_MODEL('',({','.join(shells)}))")
    s.product("part", s.represent("NON_MANIFOLD_SURFACE_SHAPE_REPRESENTATION", [model]))


@case("mixed_units", "An assembly in millimetres of parts in inches and degrees and in metres, one in the other")
def _(s):
    at = lambda place, context: s.represent("SHAPE_REPRESENTATION", [place] if place else [], context)
    metres = s.context("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.))")
    cube = s.solid(box_faces(s, 2.0), in_units(s, 25.4))
    cube = s.product("inches", cube), cube
    inner_place = s.axis((0.5, 0.0, 0.0))
    middle = at(inner_place, metres)
    middle = s.product("metres", middle), middle
    assembled(s, middle, cube, inner_place)
    outer_place = s.axis((100.0, 0.0, 0.0), Z, Y)
    whole = at(outer_place, None)
    whole = s.product("millimetres", whole), whole
    assembled(s, whole, middle, outer_place)
    s.areas = {k: a * 25.4**2 for k, a in s.areas.items()}
    # x' = 100 - y, y' = x + 500
    s.bounds = [[100.0 - 50.8, 500.0, 0.0], [100.0, 550.8, 50.8]]


@case("sets_of_curves", "Sets of points, curves and surfaces, and curves alone, which are not shown")
def _(s):
    circle = s.circle(ORIGIN, Z, X, 3.0)
    patch = s.bare(window(s, s.plane(), (0.0, 2.0), (0.0, 3.0)), 6.0)
    mixed = s.entity(f"GEOMETRIC_SET('',({s.point((1.0, 2.0, 3.0))},{circle},{patch}))")
    curves = [trimmed(s, circle, 0.0, pi), s.line(ORIGIN, X)]
    wires = s.entity(f"GEOMETRIC_CURVE_SET('',({','.join(curves)}))")
    s.lone_curves = 3
    s.product("part", s.represent("GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION", [mixed, wires]))


@case("hidden_items", "Cubes that are hidden: by their style, by a layer, by their representation; one is shown")
def _(s):
    def cube(x):
        shell = s.entity(f"CLOSED_SHELL('',({','.join(box_faces(s, 2.0, (x, 0.0, 0.0)))}))")
        return s.entity(f"MANIFOLD_SOLID_BREP('cube at {x}',{shell})")
    shown = cube(0.0)
    keep = dict(s.areas)
    styled, layered, alone = cube(10.0), cube(20.0), cube(30.0)
    color = s.entity("COLOUR_RGB('',0.5,0.5,0.5)")
    fill = s.entity(f"FILL_AREA_STYLE('',({s.entity(f'''FILL_AREA_STYLE_COLOUR('',{color})''')}))")
    side = s.entity(f"SURFACE_SIDE_STYLE('',({s.entity(f'SURFACE_STYLE_FILL_AREA({fill})')}))")
    style = s.entity(f"PRESENTATION_STYLE_ASSIGNMENT(({s.entity(f'SURFACE_STYLE_USAGE(.BOTH.,{side})')}))")
    item = s.entity(f"STYLED_ITEM('',({style}),{styled})")
    layer = s.entity(f"PRESENTATION_LAYER_ASSIGNMENT('hidden','',({layered}))")
    s.entity(f"PRESENTATION_LAYER_ASSIGNMENT('seen','',({shown}))")
    part = s.represent("ADVANCED_BREP_SHAPE_REPRESENTATION", [shown, styled, layered])
    other = s.represent("ADVANCED_BREP_SHAPE_REPRESENTATION", [alone])
    s.entity(f"INVISIBILITY(({item},{layer}))")
    s.entity(f"INVISIBILITY(({other}))")
    s.areas, s.hidden = keep, 18
    s.bounds = [[0.0, 0.0, 0.0], [2.0, 2.0, 2.0]]
    s.product("part", part)
    s.product("other", other)


def crossing(s, surface, loops, area):
    return s.face(surface, [s.bound(loop) for loop in loops], area)


@case("crossing_loops", "Loops that cross each other and themselves: what is inside an odd number of them is the face")
def _(s):
    box = lambda x0, x1, y0, y1, z: s.polygon([(x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)])
    plane = lambda z: s.plane((0.0, 0.0, z))
    faces = [crossing(s, plane(0.0), [box(0.0, 4.0, 0.0, 4.0, 0.0), box(2.0, 6.0, 1.0, 3.0, 0.0)], 16.0 + 8.0 - 8.0)]
    tie = s.polygon([(0.0, 0.0, 1.0), (2.0, 2.0, 1.0), (2.0, 0.0, 1.0), (0.0, 2.0, 1.0)])
    faces.append(crossing(s, plane(1.0), [tie], 2.0))
    lens = 2 * pi / 3 - sqrt(3) / 2
    discs = [s.loop(s.arc_edge((x, 0.0, 2.0), Z, X, 1.0)) for x in (0.0, 1.0)]
    faces.append(crossing(s, plane(2.0), discs, tau - 2 * lens))
    # Three rectangles on a cylinder: the second crosses the first, the third is a hole in what both share.
    at = lambda u, v: (3.0 * cos(u), 3.0 * sin(u), v)

    def frame(u0, u1, v0, v1):
        low, high = (s.arc_edge((0.0, 0.0, v), Z, X, 3.0, u0, u1) for v in (v0, v1))
        left, right = (s.line_edge(at(u, v0), at(u, v1)) for u in (u0, u1))
        return s.loop(low, right, "-" + high, "-" + left)
    loops = [frame(0.0, 2.0, 10.0, 12.0), frame(1.0, 2.5, 11.0, 14.0), frame(1.2, 1.7, 11.2, 11.7)]
    area = 3.0 * (4.0 + 4.5 - 2 * 1.0 + 0.25)
    faces.append(crossing(s, s.elementary("CYLINDRICAL_SURFACE", 3.0), loops, area))
    s.product("part", s.shells(faces))


@case("swept_profiles", "Sweeps of trimmed, composite and straight profiles, of polylines and conics")
def _(s):
    items = []
    up = s.entity(f"VECTOR('',{s.direction(Z)},2.)")
    axis = s.entity(f"AXIS1_PLACEMENT('',{s.point(ORIGIN)},{s.direction(Z)})")
    swept = lambda curve: s.entity(f"SURFACE_OF_LINEAR_EXTRUSION('',{curve},{up})")
    turned = lambda curve: s.entity(f"SURFACE_OF_REVOLUTION('',{curve},{axis})")
    segment = lambda c: f"{s.entity(f'COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,{c})')}"
    # One step of v is the vector's length.
    arc = trimmed(s, s.circle((20.0, 0.0, 0.0), Z, X, 3.0), 1.0, 2.5)
    items.append(s.bare(window(s, swept(arc), (1.0, 2.0), (0.0, 1.5)), 9.0))
    bent = s.entity(f"POLYLINE('',({s.point((30.0, 0.0, 0.0))},{s.point((33.0, 4.0, 0.0))},{s.point((33.0, 6.0, 0.0))}))")
    items.append(s.bare(window(s, swept(bent), (0.5, 2.0), (0.0, 1.0)), (2.5 + 2.0) * 2.0))
    parabola = s.entity(f"PARABOLA('',{s.axis((40.0, 0.0, 0.0))},0.5)")
    items.append(s.bare(window(s, swept(parabola), (0.0, 1.0), (0.0, 1.0)), (sqrt(2) + asinh(1)) / 2 * 2.0))
    line = s.line((5.0, 0.0, 0.0), (3.0, 0.0, 2.0))
    items.append(s.bare(window(s, turned(trimmed(s, line, 0.0, sqrt(8))), (0.0, 1.0), (0.0, sqrt(8))), 4.0 * sqrt(8)))
    # A straight part and an arc as one profile, turned by one radian.
    tail = trimmed(s, s.line((12.0, 0.0, -2.0), (12.0, 0.0, 0.0)), 0.0, 2.0)
    bow = trimmed(s, s.circle((10.0, 0.0, 0.0), MINUS_Y, X, 2.0), 0.0, 1.0)
    both = s.entity(f"COMPOSITE_CURVE('',({segment(tail)},{segment(bow)}),.F.)")
    items.append(s.bare(window(s, turned(both), (0.0, 1.0), (0.0, 3.0)), 24.0 + 2.0 * (10.0 + 2.0 * sin(1.0))))
    s.product("part", s.set_of(items))


def external(s, name, definition):
    """The product's shape stands in another file, as the recommended practices for AP214 and AP242 write it."""
    kind = s.once("DOCUMENT_TYPE('geometry')")
    document = s.entity(f"DOCUMENT_FILE('{name}','','',{kind},'',$)")
    s.entity(f"APPLIED_DOCUMENT_REFERENCE({document},'mandatory',({definition}))")
    role = s.once("IDENTIFICATION_ROLE('external document id and location',$)")
    source = s.once("EXTERNAL_SOURCE(IDENTIFIER(''))")
    s.entity(f"APPLIED_EXTERNAL_IDENTIFICATION_ASSIGNMENT('{name}',{role},{source},({document}))")


@case("external_part", "A cube that another file refers to")
def _(s):
    s.product("cube", s.solid(box_faces(s, 2.0)))


@case("external_parts", "An assembly of a part that stands in another file, twice, and of one whose file is missing")
def _(s):
    context = in_units(s, 25.4)
    parts = []
    for name in ("external_part.step", "not_there.step"):
        shape = s.represent("SHAPE_REPRESENTATION", [], context)
        parts.append((s.product(name, shape), shape))
        external(s, name, parts[-1][0])
    places = [s.axis((0.2, 0.0, 0.0)), s.axis((0.0, 0.2, 0.0)), s.axis((0.0, 0.0, 0.2))]
    whole = s.represent("SHAPE_REPRESENTATION", places, context)
    whole = s.product("whole", whole), whole
    for place, part in zip(places, (parts[0], parts[0], parts[1])):
        assembled(s, whole, part, place)
    cube = type(s)("", "")
    box_faces(cube, 2.0)
    # Inches here, millimetres there.
    s.areas, s.instances = cube.areas, 2
    s.bounds = [[0.0, 0.0, 0.0], [7.08, 7.08, 2.0]]
    s.warnings = ["not_there.step"]
