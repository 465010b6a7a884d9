//! Faces with their loops (ISO 10303-42, clause 5), ready for the parameter plane.

use super::args::Args;
use super::curve::{Curve, backward};
use super::error::{StepError, bad};
use super::invert::End;
use super::items::FaceUse;
use super::kinds::Kind;
use super::place::{MAX_DEPTH, Shapes};
use super::surface::Basis;
use crate::geometry::exact::Frame;
use crate::geometry::{CurveForm, CurveSpan, SurfaceForm};
use crate::import::brep::{Bound, EdgeUse, FaceSource};
use crate::model::SurfaceKind;
use glam::DVec3;

/// An edge's curve without what trims it.
pub(super) struct EdgeGeometry {
    pub curve: Curve,
    /// The edge runs along the curve from its start vertex.
    pub forward: bool,
    /// What the file associates with it: pcurves.
    pub associated: Vec<u32>,
    /// What one parameter of the file's is in ours.
    pub scale: f64,
}

impl Shapes<'_, '_> {
    /// A face, or a surface that stands for itself.
    pub fn face(&self, face: &FaceUse) -> Result<FaceSource, StepError> {
        let entity = self.file.get(face.id)?;
        let mut source = match entity.kind {
            Kind::AdvancedFace | Kind::FaceSurface => self.face_surface(entity.args()?.skip(1))?,
            Kind::Subface => {
                let mut args = entity.args()?.skip(1);
                let bounds = args.references()?;
                let parent = self.file.get(args.reference()?)?;
                let mut surface = parent.args()?.skip(2);
                self.bounded_face(surface.reference()?, &bounds, surface.flag()?)?
            }
            Kind::Face => self.flat_face(face.id, entity.args()?.skip(1))?,
            _ => self.bare_surface(face.id)?,
        };
        source.id = face.id;
        source.name = face.name.clone();
        source.color = face.color;
        source.reversed ^= face.flipped;
        Ok(source)
    }

    fn face_surface(&self, mut args: Args) -> Result<FaceSource, StepError> {
        let bounds = args.references()?;
        let surface = args.reference()?;
        self.bounded_face(surface, &bounds, args.flag()?)
    }

    fn bounded_face(&self, surface: u32, bounds: &[u32], same_sense: bool) -> Result<FaceSource, StepError> {
        let basis = self.surface(surface)?;
        let reversed = same_sense == basis.flipped;
        let mut loops = Vec::new();
        for &bound in bounds {
            loops.extend(self.bound(bound, reversed, Some(&basis))?);
        }
        if bounds.is_empty() {
            loops = self.boundaries(&basis)?;
        }
        Ok(self.source(basis, loops, reversed))
    }

    fn source(&self, basis: Basis, bounds: Vec<Bound>, reversed: bool) -> FaceSource {
        FaceSource {
            id: 0,
            name: String::new(),
            color: None,
            kind: basis.kind,
            surface: basis.form,
            domain: basis.domain,
            bounds,
            reversed,
            tolerance: self.units.tolerance,
        }
    }

    fn bare_surface(&self, id: u32) -> Result<FaceSource, StepError> {
        let basis = self.surface(id)?;
        let loops = self.boundaries(&basis)?;
        let reversed = basis.flipped;
        Ok(self.source(basis, loops, reversed))
    }

    /// A face without a surface: a polygon in its own plane.
    fn flat_face(&self, id: u32, mut args: Args) -> Result<FaceSource, StepError> {
        let mut bounds = Vec::new();
        for bound in args.references()? {
            bounds.extend(self.bound(bound, false, None)?);
        }
        let normal = |bound: &Bound| match bound {
            // Newell: twice the polygon's area along its normal.
            Bound::Edges(edges) => edges.iter().map(|e| e.ends[0].cross(e.ends[1])).sum(),
            Bound::Vertex(_) => DVec3::ZERO,
        };
        let normals: Vec<DVec3> =
            bounds.iter().map(|b| center(b).map_or(DVec3::ZERO, |c| normal(&moved(b, c)))).collect();
        let largest = normals.iter().copied().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        let frame = largest.zip(bounds.first().and_then(center)).and_then(|(n, c)| Frame::new(c, n, DVec3::X));
        let Some(frame) = frame else { return bad(id, "a face without surface whose corners lie on a line") };
        let basis = Basis {
            form: SurfaceForm::Plane(frame),
            kind: SurfaceKind::Plane,
            domain: None,
            flipped: false,
            ids: Vec::new(),
            boundaries: None,
            scale: [1.0; 2],
        };
        Ok(self.source(basis, bounds, false))
    }

    /// A bound in the direction that the surface's own normal asks for; nothing for one of no length.
    fn bound(&self, id: u32, reversed: bool, basis: Option<&Basis>) -> Result<Option<Bound>, StepError> {
        let entity = self.file.get(id)?;
        if !matches!(entity.kind, Kind::FaceBound | Kind::FaceOuterBound) {
            return Err(entity.is_not("a bound of a face"));
        }
        let mut args = entity.args()?.skip(1);
        let path = self.file.get(args.reference()?)?;
        let forward = args.flag()? != reversed;
        let mut edges = match path.kind {
            Kind::EdgeLoop => {
                let mut edges = Vec::new();
                for edge in path.args()?.skip(1).references()? {
                    edges.extend(self.oriented_edge(edge, basis)?);
                }
                self.turn_strays(&mut edges);
                edges
            }
            Kind::PolyLoop => self.poly_loop(path.args()?.skip(1).references()?)?,
            Kind::VertexLoop => return Ok(Some(Bound::Vertex(self.vertex(path.args()?.skip(1).reference()?)?))),
            _ => return Err(path.is_not("a loop")),
        };
        if !forward {
            edges = edges.into_iter().rev().map(turned).collect();
        }
        if edges.is_empty() {
            self.note(id, "a bound of no length is left out");
            return Ok(None);
        }
        Ok(Some(Bound::Edges(edges)))
    }

    /// Turns edges that run against their loop: which way an edge goes is told by vertices that it shares.
    fn turn_strays(&self, edges: &mut [EdgeUse]) {
        let count = edges.len();
        for k in 0..count {
            let (before, next) = (edges[(k + count - 1) % count].ends[1], edges[(k + 1) % count].ends);
            let [start, end] = edges[k].ends;
            if count > 1 && start != before && end == before && next.contains(&start) {
                self.note(edges[k].edge, "the edge runs against its loop; it is turned");
                self.log.doubtful.set(true);
                edges[k] = turned(edges[k].clone());
            }
        }
    }

    fn poly_loop(&self, ids: Vec<u32>) -> Result<Vec<EdgeUse>, StepError> {
        let points = self.points(&ids)?;
        let mut edges = Vec::new();
        for (k, &start) in points.iter().enumerate() {
            let next = (k + 1) % points.len();
            let end = points[next];
            if start != end {
                let curve = CurveForm::Line { origin: start, direction: end - start };
                let spans = vec![CurveSpan { curve, range: [0.0, 1.0] }];
                let edge = edge_number(ids[k], ids[next]);
                edges.push(EdgeUse { edge, spans, pcurves: Vec::new(), ends: [start, end] });
            }
        }
        Ok(edges)
    }

    /// An edge in its loop's direction; nothing for one of no length.
    fn oriented_edge(&self, id: u32, basis: Option<&Basis>) -> Result<Option<EdgeUse>, StepError> {
        let entity = self.file.get(id)?;
        let (edge, forward) = match entity.kind {
            Kind::OrientedEdge => {
                let mut args = entity.args()?.skip(3);
                (args.reference()?, args.flag()?)
            }
            _ => (id, true),
        };
        let edge = self.edge(edge, basis)?;
        Ok(if forward { edge } else { edge.map(turned) })
    }

    fn edge(&self, id: u32, basis: Option<&Basis>) -> Result<Option<EdgeUse>, StepError> {
        let entity = self.file.get(id)?;
        let mut args = match entity.kind {
            Kind::EdgeCurve | Kind::Edge | Kind::SubEdge => entity.args()?.skip(1),
            _ => return Err(entity.is_not("an edge")),
        };
        let vertices = [args.reference()?, args.reference()?];
        let ends = [self.vertex(vertices[0])?, self.vertex(vertices[1])?];
        if entity.kind == Kind::Edge {
            let curve = CurveForm::Line { origin: ends[0], direction: ends[1] - ends[0] };
            let spans = vec![CurveSpan { curve, range: [0.0, 1.0] }];
            return Ok((ends[0] != ends[1]).then_some(EdgeUse { edge: id, spans, pcurves: Vec::new(), ends }));
        }
        if entity.kind == Kind::SubEdge {
            let parent = self.file.get(args.reference()?)?;
            args = parent.args()?.skip(3);
        }
        let (curve, same_sense) = (args.reference()?, args.flag()?);
        if ends[0] == ends[1] && self.is_point(curve) {
            return Ok(None);
        }
        let geometry = self.edge_geometry(curve, same_sense)?;
        let tolerance = self.units.tolerance;
        let spans = geometry.curve.between(End::Point(ends[0]), End::Point(ends[1]), geometry.forward, tolerance);
        if spans.iter().all(|s| s.range[0] == s.range[1]) {
            self.note(id, "an edge of no length is left out");
            return Ok(None);
        }
        let pcurves = basis.map_or(Vec::new(), |basis| self.pcurves(&geometry, &spans, basis));
        Ok(Some(EdgeUse { edge: id, spans, pcurves, ends }))
    }

    /// Whether a curve says itself that it is only a point in space: an edge along a pole.
    fn is_point(&self, curve: u32) -> bool {
        let kind = self.file.get(curve).map(|entity| entity.kind);
        matches!(kind, Ok(Kind::DegeneratePcurve | Kind::EvaluatedDegeneratePcurve))
    }

    /// Vertices trim an edge; what trims its curve besides is passed over.
    pub fn edge_geometry(&self, id: u32, same_sense: bool) -> Result<EdgeGeometry, StepError> {
        let (mut id, mut forward) = (id, same_sense);
        let mut associated = Vec::new();
        for _ in 0..MAX_DEPTH {
            let entity = self.file.get(id)?;
            match entity.kind {
                Kind::SurfaceCurve | Kind::SeamCurve | Kind::IntersectionCurve | Kind::BoundedSurfaceCurve => {
                    let mut args = entity.args()?.skip(1);
                    id = args.reference()?;
                    associated = args.references().unwrap_or_default();
                }
                Kind::TrimmedCurve => {
                    let mut args = entity.args()?.skip(1);
                    id = args.reference()?;
                    forward ^= !args.skip(2).flag()?;
                }
                _ => {
                    let curve = self.curve(id)?;
                    let scale = match &curve {
                        Curve::Whole(form) => self.parameter_scale(form),
                        Curve::Pieces(_) => 1.0,
                    };
                    return Ok(EdgeGeometry { curve, forward, associated, scale });
                }
            }
        }
        Err(StepError::Depth(id))
    }
}

/// The same edge from its end to its start.
fn turned(edge: EdgeUse) -> EdgeUse {
    EdgeUse {
        edge: edge.edge,
        spans: backward(edge.spans),
        pcurves: edge.pcurves.into_iter().map(backward).collect(),
        ends: [edge.ends[1], edge.ends[0]],
    }
}

/// The mean of a bound's vertices.
fn center(bound: &Bound) -> Option<DVec3> {
    let Bound::Edges(edges) = bound else { return None };
    (!edges.is_empty()).then(|| edges.iter().map(|e| e.ends[0]).sum::<DVec3>() / edges.len() as f64)
}

/// A bound's vertices about `center`, where cross products lose no digits.
fn moved(bound: &Bound, center: DVec3) -> Bound {
    match bound {
        Bound::Edges(edges) => {
            Bound::Edges(edges.iter().map(|e| EdgeUse { ends: e.ends.map(|p| p - center), ..e.clone() }).collect())
        }
        Bound::Vertex(point) => Bound::Vertex(*point - center),
    }
}

/// A number for the edge between two corners of polygons, which has no entity of its own: the same from both sides, and
/// above all that files use.
fn edge_number(a: u32, b: u32) -> u32 {
    let pair = (u64::from(a.min(b)) << 32) | u64::from(a.max(b));
    0x8000_0000 | (pair.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 33) as u32
}
