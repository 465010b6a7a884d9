"""What several cases are built from."""

from math import pi

from step_text import ORIGIN, X, Y, Z, Step, cross, plus, real

MINUS_X, MINUS_Y, MINUS_Z = (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)
CASES = []


def case(name, note):
    def wrap(build):
        step = Step(name + ".step", note)
        build(step)
        CASES.append(step)
        return build
    return wrap


def rectangle(s, width, height, hole=None, area=None, **options):
    corners = [(0.0, 0.0, 0.0), (width, 0.0, 0.0), (width, height, 0.0), (0.0, height, 0.0)]
    bounds = [s.polygon(corners)] + ([hole] if hole else [])
    return s.face(s.plane(), bounds, width * height if area is None else area, **options)


def box_faces(s, size, corner=ORIGIN, inward=False):
    at = lambda i, j, k: plus(corner, (size * i, X), (size * j, Y), (size * k, Z))
    sides = [
        (MINUS_Z, X, [(0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)]), (Z, X, [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]),
        (MINUS_Y, X, [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)]), (Y, X, [(0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 1, 0)]),
        (MINUS_X, Y, [(0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0)]), (X, Y, [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)]),
    ]
    edges = {}

    def edge(a, b):
        if (b, a) in edges:
            return "-" + edges[b, a]
        return edges.setdefault((a, b), s.line_edge(at(*a), at(*b)))
    faces = []
    for normal, x, corners in sides:
        corners = corners[::-1] if inward else corners
        loop = s.loop(*(edge(a, b) for a, b in zip(corners, corners[1:] + corners[:1])))
        faces.append(s.face(s.plane(at(*corners[0]), normal, x), [loop], size * size, same=not inward))
    return faces


def rational(kind, body, knots, weights):
    """A rational B-spline as ISO 10303-21 writes it, as one complex record."""
    common = "GEOMETRIC_REPRESENTATION_ITEM()"
    return (f"(BOUNDED_{kind}()B_SPLINE_{kind}({body})B_SPLINE_{kind}_WITH_KNOTS({knots}){common}"
            f"RATIONAL_B_SPLINE_{kind}({weights})REPRESENTATION_ITEM(''){kind}())")


def parameter_curve(s, surface, points):
    space = s.once("(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()REPRESENTATION_CONTEXT('',''))")
    curve = s.bspline_curve(1, points, [2, 2], [0.0, 1.0])
    definition = s.entity(f"DEFINITIONAL_REPRESENTATION('',({curve}),{space})")
    return s.entity(f"PCURVE('',{surface},{definition})")


def assembled(s, parent, child, place):
    """`child` (definition, representation) into `parent` at an axis placement, as AP214 writes it."""
    usage = s.entity(f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('','','',{parent[0]},{child[0]},$)")
    shape = s.entity(f"PRODUCT_DEFINITION_SHAPE('','',{usage})")
    transform = s.entity(f"ITEM_DEFINED_TRANSFORMATION('','',{s.axis()},{place})")
    relation = s.entity(
        f"(REPRESENTATION_RELATIONSHIP('','',{child[1]},{parent[1]})"
        f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({transform})SHAPE_REPRESENTATION_RELATIONSHIP())")
    s.entity(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{shape})")


def moved(place, corners):
    origin, z, x = place
    return [plus(origin, (c[0], x), (c[1], cross(z, x)), (c[2], z)) for c in corners]
