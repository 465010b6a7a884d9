//! A model in figures: how many faces and patches, of what degree and kind (ETER's table 2, and what else is asked).

use super::{Model, SurfaceKind, Warning, measure::Areas};
use serde::{Serialize, Serializer};
use std::collections::{BTreeMap, HashMap, HashSet};

/// What `info` says of a model; the names are those of its JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Faces that are drawn: every instance counts.
    pub faces: usize,
    /// Faces that are stored.
    pub unique_faces: usize,
    /// Faces that could not be converted.
    pub lost_faces: usize,
    /// Surfaces that are stored.
    pub surfaces: usize,
    /// Stored faces by what the file calls their surface.
    pub surface_types: BTreeMap<&'static str, usize>,
    /// Rational Bézier patches that are stored.
    pub bezier_patches: usize,
    /// Patches of each degree; in JSON by "UxV".
    #[serde(serialize_with = "by_name")]
    pub degrees: BTreeMap<[usize; 2], usize>,
    /// Patches whose weights differ.
    pub rational: usize,
    /// Faces that have trim loops.
    pub trims: usize,
    pub loops: usize,
    /// Rational Bézier curves of all loops.
    pub trim_curves: usize,
    /// Edges of parts that trim curves stand for, each counted once.
    pub edges: usize,
    /// Largest distance between a trim curve and its edge, in units.
    pub largest_gap: f64,
    /// Stored faces with trim curves that follow their edges' images but are not these; such curves; and the largest
    /// distance from the image in space that was found, in units.
    pub approximated_faces: usize,
    pub approximated_curves: usize,
    pub largest_approximation: f64,
    /// Faces that the file hides, and curves that bound no face: neither is drawn.
    pub hidden_faces: usize,
    pub lone_curves: usize,
    /// Of all faces that are drawn, in squared units.
    pub area: f64,
    /// What the area may still be off by, as a fraction of it; an estimate.
    pub area_relative_error: f64,
    /// Box of all control points in the world: lowest and highest corner.
    pub bounds: Option<[[f64; 3]; 2]>,
    /// The file's unit of length, where it names one.
    pub unit: Option<String>,
    pub parts: usize,
    pub instances: usize,
    /// What was mended, approximated or left out, one line each.
    pub warnings: Vec<String>,
    /// The faces that could not be converted.
    pub lost: Vec<Warning>,
}

/// One stored face; the names are those of the JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaceFigures {
    /// The file's own number, or a running one.
    pub entity: u32,
    pub name: String,
    pub part: String,
    pub surface: &'static str,
    pub bezier_patches: usize,
    pub loops: usize,
    /// Trim curves that follow their edges' images but are not these, and how near, in the part's units.
    pub approximated_curves: u32,
    pub approximation: f64,
    /// In the part's own squared units.
    pub area: f64,
    /// What the area may still be off by, as a fraction of it; an estimate.
    pub area_relative_error: f64,
    pub warnings: Vec<String>,
}

fn by_name<S: Serializer>(degrees: &BTreeMap<[usize; 2], usize>, to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(degrees.iter().map(|([u, v], count)| (format!("{u}x{v}"), count)))
}

impl Model {
    /// Counts; `areas` come from [`Model::measure`].
    pub fn figures(&self, areas: &Areas) -> Figures {
        let faces = || self.parts.iter().flat_map(|p| &p.faces);
        let patches = || faces().flat_map(|f| &f.surface.patches);
        let curves = || faces().flat_map(|f| f.loops.iter()).flat_map(|l| &l.curves);
        let mut degrees = BTreeMap::new();
        for patch in patches() {
            *degrees.entry(patch.patch.degree()).or_insert(0) += 1;
        }
        let mut surface_types = BTreeMap::new();
        for face in faces() {
            *surface_types.entry(face.kind.name()).or_insert(0) += 1;
        }
        Figures {
            faces: self.instances.iter().map(|i| self.parts[i.part].faces.len()).sum(),
            unique_faces: faces().count(),
            lost_faces: self.lost.len(),
            surfaces: faces().count(),
            surface_types,
            bezier_patches: patches().count(),
            degrees,
            rational: patches().filter(|p| p.patch.net().is_rational()).count(),
            trims: faces().filter(|f| !f.loops.is_empty()).count(),
            loops: faces().map(|f| f.loops.len()).sum(),
            trim_curves: curves().count(),
            edges: self.edges(),
            largest_gap: curves().map(|c| c.gap).fold(0.0, f64::max),
            approximated_faces: faces().filter(|f| f.approximation.curves > 0).count(),
            approximated_curves: faces().map(|f| f.approximation.curves as usize).sum(),
            largest_approximation: faces().map(|f| f.approximation.error).fold(0.0, f64::max),
            hidden_faces: self.unshown.hidden_faces,
            lone_curves: self.unshown.lone_curves,
            area: areas.total.value,
            area_relative_error: areas.total.relative_error(),
            bounds: self.bounds().map(|b| b.map(Into::into)),
            unit: self.unit.clone(),
            parts: self.parts.len(),
            instances: self.instances.len(),
            warnings: self.warnings.iter().map(|w| w.message.clone()).collect(),
            lost: self.lost.clone(),
        }
    }

    /// Every stored face, in the order of the parts.
    pub fn list_faces(&self, areas: &Areas) -> Vec<FaceFigures> {
        let mut warnings = HashMap::<u32, Vec<String>>::new();
        for Warning { entity, message } in &self.warnings {
            entity.map(|entity| warnings.entry(entity).or_default().push(message.clone()));
        }
        let faces = self.parts.iter().flat_map(|part| part.faces.iter().map(move |face| (part, face)));
        faces
            .zip(&areas.faces)
            .map(|((part, face), area)| FaceFigures {
                entity: face.id,
                name: face.name.to_string(),
                part: part.name.clone(),
                surface: face.kind.name(),
                bezier_patches: face.surface.patches.len(),
                loops: face.loops.len(),
                approximated_curves: face.approximation.curves,
                approximation: face.approximation.error,
                area: area.value,
                area_relative_error: area.relative_error(),
                warnings: warnings.get(&face.id).cloned().unwrap_or_default(),
            })
            .collect()
    }

    fn edges(&self) -> usize {
        let of_part = |part: &super::Part| {
            let curves = part.faces.iter().flat_map(|f| f.loops.iter()).flat_map(|l| &l.curves);
            curves.filter_map(|c| c.edge).collect::<HashSet<_>>().len()
        };
        self.parts.iter().map(of_part).sum()
    }
}

impl SurfaceKind {
    /// As tables and JSON call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plane => "plane",
            Self::Cylinder => "cylinder",
            Self::Cone => "cone",
            Self::Sphere => "sphere",
            Self::Torus => "torus",
            Self::Extrusion => "extrusion",
            Self::Revolution => "revolution",
            Self::Offset => "offset",
            Self::BSpline => "b-spline",
            Self::Bezier => "bezier",
        }
    }
}
