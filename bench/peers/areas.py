#!/usr/bin/env python3
"""Areas of STEP faces by Open CASCADE: `areas.py FILE... [-o FOLDER]`, in square millimetres, as JSON.

Run with target/peers/venv/bin/python (setup.sh makes it). Each face is named by the entity number of its ADVANCED_FACE,
through the map that the transfer leaves behind, and counted once an instance.

Three areas a face:
- `area`: BRepGProp::SurfaceProperties with a tolerance (`--eps`), the adaptive integral on the exact surface inside the
  face's pcurves. No mesh. This one is meant when two readers are compared: circular and elliptic trims come out right
  to nine digits.
- `gauss`: the same without a tolerance: a fixed number of points a span, off by up to 1e-4 at circular trims.
- `mesh` (with `--mesh`): two triangulations of the face, extrapolated to zero deflection; slow and good to about 1e-4
  on curved faces, but it shares nothing with the quadrature, so it can say which of two readers is right.
`gap` is how far the face's pcurves are from its edges in space: Open CASCADE integrates inside the pcurves, so where
the gap is not small a reader that follows the edges gets another area and is right.
`doubtful` lists the faces whose first two differ by more than 1e-4 of the face: there the peer disagrees with itself.
"""

import argparse
import json
import re
import sys
import tempfile
from pathlib import Path

from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Curve2d, BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepGProp import BRepGProp
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepTools import BRepTools
from OCP.GProp import GProp_GProps
from OCP.Bnd import Bnd_Box
from OCP.BRepBndLib import BRepBndLib
from OCP.IFSelect import IFSelect_RetDone
from OCP.Message import Message
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS
from OCP.gp import gp_Pnt2d

RECORD = re.compile(rb"(?:^|;)\s*#(\d+)\s*=\s*(\w*)", re.M)
COMMENT = re.compile(rb"/\*.*?\*/", re.S)
REPRESENTATION = re.compile(rb"#(\d+)\s*=\s*(?:ADVANCED_BREP_|MANIFOLD_SURFACE_|FACETED_BREP_)?SHAPE_REPRESENTATION\s*\(")


def faces_of(shape):
    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        yield TopoDS.Face(explorer.Current())
        explorer.Next()


def with_product(text):
    """The same file with a product for its first shape representation, which the reader insists on."""
    found = REPRESENTATION.search(text)
    if found is None:
        return None
    first = 1 + max(int(number) for number, _ in RECORD.findall(text))
    context, product_context, product, formation, definition_context, definition, shape, link = range(first, first + 8)
    records = f"""#{context}=APPLICATION_CONTEXT('');
#{product_context}=PRODUCT_CONTEXT('',#{context},'mechanical');
#{product}=PRODUCT('added','added','',(#{product_context}));
#{formation}=PRODUCT_DEFINITION_FORMATION('','',#{product});
#{definition_context}=PRODUCT_DEFINITION_CONTEXT('part definition',#{context},'design');
#{definition}=PRODUCT_DEFINITION('','',#{formation},#{definition_context});
#{shape}=PRODUCT_DEFINITION_SHAPE('','',#{definition});
#{link}=SHAPE_DEFINITION_REPRESENTATION(#{shape},#{found.group(1).decode()});
"""
    end = text.rindex(b"ENDSEC")
    return text[:end] + records.encode() + text[end:]


class Transferred:
    """A file's shape, and for each of its faces the number of its entity."""

    def __init__(self, path):
        self.text = path.read_bytes()
        self.no_product = False
        self._read(path)
        if self.shape.IsNull() and (patched := with_product(self.text)) is not None:
            self.no_product = True
            self.text = patched
            with tempfile.NamedTemporaryFile(suffix=".stp") as file:
                file.write(patched)
                file.flush()
                self._read(Path(file.name))

    def _read(self, path):
        self.reader = STEPControl_Reader()
        if self.reader.ReadFile(str(path)) != IFSelect_RetDone:
            raise OSError(f"{path}: Open CASCADE does not read it")
        self.reader.TransferRoots()
        self.shape = self.reader.OneShape()
        # The Python binding finds no entity's number (Interface_InterfaceModel::Number gives 0), but entities stand in
        # the order of the text and one entity is always the same Python object.
        model = self.reader.WS().Model()
        self._entities = [model.Value(index) for index in range(1, model.NbEntities() + 1)]
        records = RECORD.findall(COMMENT.sub(b"", self.text.partition(b"DATA")[2]))
        if len(records) != len(self._entities):
            raise ValueError(f"{path}: {len(records)} records in the text, {len(self._entities)} read")
        self._numbers = {id(entity): int(number) for entity, (number, _) in zip(self._entities, records)}
        self.face_entities = {int(number) for number, kind in records if kind in (b"ADVANCED_FACE", b"FACE_SURFACE")}

    def number(self, face):
        entity = self.reader.WS().TransferReader().EntityFromShapeResult(face.Located(TopLoc_Location()), -1)
        return self._numbers.get(id(entity))


def integral(face, eps=None):
    properties = GProp_GProps()
    if eps is None:
        BRepGProp.SurfaceProperties_s(face, properties)
    else:
        BRepGProp.SurfaceProperties_s(face, properties, eps)
    return abs(properties.Mass())


def gap(face, samples=8):
    """Largest distance in mm between the face's pcurves and its edges in space, at the same parameters."""
    surface, point, largest = BRepAdaptor_Surface(face, False), gp_Pnt2d(), 0.0
    explorer = TopExp_Explorer(face, TopAbs_EDGE)
    while explorer.More():
        edge = TopoDS.Edge(explorer.Current())
        explorer.Next()
        if BRep_Tool.Degenerated_s(edge):
            continue
        space, plane = BRepAdaptor_Curve(edge), BRepAdaptor_Curve2d(edge, face)
        first, last = plane.FirstParameter(), plane.LastParameter()
        for index in range(samples + 1):
            parameter = first + (last - first) * index / samples
            plane.D0(parameter, point)
            largest = max(largest, space.Value(parameter).Distance(surface.Value(point.X(), point.Y())))
    return largest


def meshed(face, deflection):
    copy = TopoDS.Face(BRepBuilderAPI_Copy(face).Shape())
    BRepTools.Clean_s(copy)
    BRepMesh_IncrementalMesh(copy, max(deflection, 1e-7), False, 0.05, False)
    location = TopLoc_Location()
    triangulation = BRep_Tool.Triangulation_s(copy, location)
    if triangulation is None:
        return None
    total = 0.0
    for index in range(1, triangulation.NbTriangles() + 1):
        a, b, c = (triangulation.Node(n) for n in triangulation.Triangle(index).Get())
        total += 0.5 * (b.XYZ() - a.XYZ()).Crossed(c.XYZ() - a.XYZ()).Modulus()
    return total


def extrapolated(face):
    box = Bnd_Box()
    BRepBndLib.Add_s(face, box, False)
    size = 0.0 if box.IsVoid() or box.IsOpen() else box.SquareExtent() ** 0.5
    if not 0.0 < size < 1e9:
        return None
    coarse, fine = meshed(face, 4e-4 * size), meshed(face, 1e-4 * size)
    # The error of a triangulation's area falls in proportion to its deflection.
    return None if coarse is None or fine is None else fine + (fine - coarse) / 3.0


def measure(path, eps, mesh):
    transferred = Transferred(path)
    rows = {}
    bare_faces = {}
    for face in faces_of(transferred.shape):
        bare = face.Located(TopLoc_Location())
        known = next((key for shape, key in bare_faces.get(hash(bare), []) if shape.IsSame(bare)), None)
        if known is not None:
            rows[known]["instances"] += 1
            continue
        number = transferred.number(face)
        # One entity can have several faces: the reader splits some.
        key = (number, len(rows))
        bare_faces.setdefault(hash(bare), []).append((bare, key))
        row = {"id": number, "instances": 1, "area": integral(face, eps), "gauss": integral(face), "gap": gap(face)}
        if mesh:
            row["mesh"] = extrapolated(face)
        rows[key] = row
    rows = list(rows.values())
    doubtful = [r["id"] for r in rows if abs(r["area"] - r["gauss"]) > 1e-4 * max(r["area"], r["gauss"])]
    return {
        "file": path.name,
        "unit": "mm",
        "no_product": transferred.no_product,
        "face_entities": len(transferred.face_entities),
        "not_transferred": sorted(transferred.face_entities - {r["id"] for r in rows}),
        "faces": sum(r["instances"] for r in rows),
        "unique_faces": len(rows),
        "area": sum(r["area"] * r["instances"] for r in rows),
        "gauss": sum(r["gauss"] * r["instances"] for r in rows),
        "doubtful": doubtful,
        "faces_list": rows,
    }


def main():
    parser = argparse.ArgumentParser(description="Areas of STEP faces by Open CASCADE")
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("-o", "--output", type=Path, help="a folder: one NAME.json a file; else standard output")
    parser.add_argument("--eps", type=float, default=1e-8, help="relative error asked of the adaptive integral")
    parser.add_argument("--mesh", action="store_true", help="also by extrapolated triangulation")
    args = parser.parse_args()
    for name in Message.DefaultMessenger_s().Printers():
        Message.DefaultMessenger_s().RemovePrinter(name)
    for path in args.files:
        try:
            result = measure(path, args.eps, args.mesh)
        except (OSError, ValueError) as error:
            result = {"file": path.name, "error": str(error)}
        text = json.dumps(result, indent=1)
        if args.output is None:
            print(text)
            continue
        args.output.mkdir(parents=True, exist_ok=True)
        (args.output / f"{path.name}.json").write_text(text + "\n")
        summary = {k: v for k, v in result.items() if k not in ("faces_list", "not_transferred", "doubtful")}
        summary["doubtful"] = len(result.get("doubtful", []))
        summary["not_transferred"] = len(result.get("not_transferred", []))
        print(json.dumps(summary), file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
