"""STEP texts of few entities, for the hard cases in cases.py."""

import json
import math
from pathlib import Path

MILLIMETRE = "(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))"
RADIAN = "(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))"
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
ORIGIN = (0.0, 0.0, 0.0)


def real(x):
    text = repr(float(x)).upper()
    mantissa, exponent, power = text.partition("E")
    return mantissa + ("" if "." in mantissa else ".") + exponent + power


def reals(values):
    return "(" + ",".join(real(v) for v in values) + ")"


def grid(rows):
    return "(" + ",".join("(" + ",".join(row) + ")" for row in rows) + ")"


def names(items):
    return "(" + ",".join(items) + ")"


def quoted(text):
    return text.replace("'", "''")


def flag(b):
    return ".T." if b else ".F."


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def plus(a, *terms):
    """a + s b + t c ..., terms given as (s, b)."""
    return tuple(a[i] + sum(s * b[i] for s, b in terms) for i in range(3))


class Step:
    """Entities in the order in which they are asked for; each call gives a name like `#12`."""

    def __init__(self, name, note):
        self.name, self.note = name, note
        self.records = []
        self.areas = {}
        self.known = {}
        self.instances = 1
        self.bounds = None
        self.tolerance = 1e-5
        # Words that each warning holds, in their order; without them there is none.
        self.warnings = []
        # Faces that are hidden, and curves that no face has.
        self.hidden, self.lone_curves = 0, 0
        # No trim curve is an approximation.
        self.exact = False

    def entity(self, text):
        self.records.append(text)
        return f"#{len(self.records)}"

    def once(self, text):
        if text not in self.known:
            self.known[text] = self.entity(text)
        return self.known[text]

    # Geometry
    def point(self, p):
        return self.once(f"CARTESIAN_POINT('',{reals(p)})")

    def direction(self, d):
        return self.once(f"DIRECTION('',{reals(d)})")

    def axis(self, origin=ORIGIN, z=Z, x=X):
        return self.once(f"AXIS2_PLACEMENT_3D('',{self.point(origin)},{self.direction(z)},{self.direction(x)})")

    def vertex(self, p):
        return self.once(f"VERTEX_POINT('',{self.point(p)})")

    def line(self, a, b):
        vector = self.entity(f"VECTOR('',{self.direction(plus(b, (-1.0, a)))},1.)")
        return self.entity(f"LINE('',{self.point(a)},{vector})")

    def circle(self, center, z, x, radius):
        return self.entity(f"CIRCLE('',{self.axis(center, z, x)},{real(radius)})")

    def plane(self, origin=ORIGIN, z=Z, x=X):
        return self.entity(f"PLANE('',{self.axis(origin, z, x)})")

    def elementary(self, kind, *values, origin=ORIGIN, z=Z, x=X):
        return self.entity(f"{kind}('',{self.axis(origin, z, x)},{','.join(map(real, values))})")

    def bspline_curve(self, degree, points, multiplicities, knots, closed=False):
        body = f"{degree},{names(map(self.point, points))},.UNSPECIFIED.,{flag(closed)},.F."
        counts = names(map(str, multiplicities))
        return self.entity(f"B_SPLINE_CURVE_WITH_KNOTS('',{body},{counts},{reals(knots)},.UNSPECIFIED.)")

    def points(self, net):
        return grid([[self.point(p) for p in row] for row in net])

    def bspline_surface(self, degrees, net, counts, knots, closed=(False, False)):
        body = f"{degrees[0]},{degrees[1]},{self.points(net)},.UNSPECIFIED.,{flag(closed[0])},{flag(closed[1])},.F."
        counts = ",".join(names(map(str, c)) for c in counts)
        knots = ",".join(reals(k) for k in knots)
        return self.entity(f"B_SPLINE_SURFACE_WITH_KNOTS('',{body},{counts},{knots},.UNSPECIFIED.)")

    # Topology
    def edge(self, a, b, curve, same=True):
        """From point a to point b."""
        return self.entity(f"EDGE_CURVE('',{self.vertex(a)},{self.vertex(b)},{curve},{flag(same)})")

    def line_edge(self, a, b):
        return self.edge(a, b, self.line(a, b))

    def arc_edge(self, center, z, x, radius, start=0.0, end=2 * math.pi):
        """Counter-clockwise about z, angles from x."""
        y = cross(z, x)
        at = lambda t: plus(center, (radius * math.cos(t), x), (radius * math.sin(t), y))
        a = at(start)
        b = a if abs(end - start - 2 * math.pi) < 1e-12 else at(end)
        return self.edge(a, b, self.circle(center, z, x, radius))

    def loop(self, *edges):
        """Edges by name; `-#12` is edge #12 against its direction."""
        oriented = [self.entity(f"ORIENTED_EDGE('',*,*,{e.lstrip('-')},{flag(not e.startswith('-'))})") for e in edges]
        return self.entity(f"EDGE_LOOP('',{names(oriented)})")

    def bound(self, loop, outer=False, same=True):
        kind = "FACE_OUTER_BOUND" if outer else "FACE_BOUND"
        return self.entity(f"{kind}('',{loop},{flag(same)})")

    def polygon(self, corners):
        return self.loop(*(self.line_edge(a, b) for a, b in zip(corners, corners[1:] + corners[:1])))

    def face(self, surface, bounds, area, same=True, kind="ADVANCED_FACE"):
        """`bounds`: loops, the first one the outer bound; or FACE_BOUNDs made before."""
        made = []
        for index, bound in enumerate(bounds):
            is_bound = "BOUND(" in self.records[int(bound[1:]) - 1]
            made.append(bound if is_bound else self.bound(bound, outer=index == 0))
        face = self.entity(f"{kind}('',{names(made)},{surface},{flag(same)})")
        self.areas[int(face[1:])] = area
        return face

    def bare(self, surface, area):
        """A surface that stands for itself in a geometric set."""
        self.areas[int(surface[1:])] = area
        return surface

    # What it belongs to
    def context(self, length=MILLIMETRE, angle=RADIAN):
        units = [self.once(length), self.once(angle), self.once("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")]
        accuracy = self.once(f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-5),{units[0]},'','')")
        return self.once(
            f"(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({accuracy}))"
            f"GLOBAL_UNIT_ASSIGNED_CONTEXT({names(units)})REPRESENTATION_CONTEXT('',''))")

    def product(self, name, representation):
        application = self.once("APPLICATION_CONTEXT('automotive design')")
        context = self.once(f"PRODUCT_CONTEXT('',{application},'mechanical')")
        product = self.entity(f"PRODUCT('{name}','{name}','',({context}))")
        formation = self.entity(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
        view = self.once(f"PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')")
        definition = self.entity(f"PRODUCT_DEFINITION('','',{formation},{view})")
        shape = self.entity(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
        self.entity(f"SHAPE_DEFINITION_REPRESENTATION({shape},{representation})")
        return definition

    def shells(self, faces, context=None):
        """Faces as an open shell of a surface model."""
        shell = self.entity(f"OPEN_SHELL('',{names(faces)})")
        model = self.entity(f"SHELL_BASED_SURFACE_MODEL('',({shell}))")
        return self.represent("MANIFOLD_SURFACE_SHAPE_REPRESENTATION", [model], context)

    def solid(self, faces, context=None):
        shell = self.entity(f"CLOSED_SHELL('',{names(faces)})")
        brep = self.entity(f"MANIFOLD_SOLID_BREP('',{shell})")
        return self.represent("ADVANCED_BREP_SHAPE_REPRESENTATION", [brep], context)

    def represent(self, kind, items, context=None):
        items = names([self.axis(), *items])
        return self.entity(f"{kind}('',{items},{context or self.context()})")

    def set_of(self, surfaces):
        items = self.entity(f"GEOMETRIC_SET('',{names(surfaces)})")
        return self.represent("GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION", [items])

    def text(self):
        lines = "".join(f"#{number}={record};\n" for number, record in enumerate(self.records, 1))
        return (
            "ISO-10303-21;\nHEADER;\n"
            f"FILE_DESCRIPTION(('{quoted(self.note)}'),'2;1');\nFILE_NAME('{self.name}','',(''),(''),'','halfpixel tests','');\n"
            "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\n"
            f"DATA;\n{lines}ENDSEC;\nEND-ISO-10303-21;\n")

    def expected(self):
        unique = len(self.areas)
        # In units of the file's own text, all instances; `scale` turns both into millimetres.
        scale = getattr(self, "scale", 1.0) ** 2
        areas = {str(number): area * scale for number, area in self.areas.items()}
        factor = getattr(self, "area_factor", self.instances)
        return {
            "note": self.note, "faces": unique * self.instances, "unique_faces": unique,
            "area": factor * sum(areas.values()), "relative_tolerance": self.tolerance,
            "areas": areas, "bounds": self.bounds, "warnings": self.warnings, "hidden": self.hidden,
            "lone_curves": self.lone_curves, "exact": self.exact,
        }


def write(cases, folder: Path):
    expected = {}
    for case in cases:
        (folder / case.name).write_text(case.text())
        expected[case.name] = case.expected()
    (folder / "expected.json").write_text(json.dumps(expected, indent=1) + "\n")
