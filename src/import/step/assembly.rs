//! Representations and how they are placed in each other: products of assemblies, mapped items.
//!
//! Representations that a plain relationship joins (a product's shape and the B-rep of it) share one frame and are one
//! node. Nodes place others: by `CONTEXT_DEPENDENT_SHAPE_REPRESENTATION` of an assembly usage with a transformation
//! (ISO 10303-43, representation relationship; 10303-44), or by `MAPPED_ITEM`.

use super::error::StepError;
use super::file::{Entity, File};
use super::items::{Contents, Walker};
use super::kinds::Kind;
use super::place::{Log, Shapes};
use super::products::{Products, Usage};
use super::styles::Styles;
use super::units::Units;
use crate::model::Warning;
use foldhash::{HashMap, HashMapExt, HashSet, HashSetExt};
use glam::DAffine3;

/// A representation with its items.
pub(super) struct Representation {
    pub id: u32,
    pub items: Vec<u32>,
    pub units: Units,
}

/// Representations in one frame.
#[derive(Default)]
pub(super) struct Node {
    /// Of the product definition, 0 without one.
    pub id: u32,
    pub name: String,
    /// What each of its representations holds.
    pub groups: Vec<NodePart>,
    pub children: Vec<Child>,
}

/// One representation of a node.
pub(super) struct NodePart {
    /// Of the representation, 0 without one.
    pub id: u32,
    pub units: Units,
    pub contents: Contents,
}

/// A node in another's frame.
pub(super) struct Child {
    pub node: usize,
    pub transform: DAffine3,
    pub name: String,
    pub color: Option<[f32; 3]>,
    /// Of single faces of its parts, as in [`crate::model::Instance::face_colors`].
    pub face_colors: Vec<(usize, [f32; 3])>,
    /// The numbers by which a style may name this place.
    pub contexts: Vec<u32>,
    /// Of the component usage or the mapped item, 0 without one.
    pub id: u32,
    pub hidden: bool,
}

impl Child {
    /// A component; without a usage, what a transformation alone places.
    fn of_usage(node: usize, transform: DAffine3, name: String, usage: Option<&Usage>) -> Self {
        let contexts = usage.map_or(Vec::new(), |u| vec![u.id, u.place, u.dependent]);
        let id = usage.map_or(0, |u| u.id);
        Self { node, transform, name, color: None, face_colors: Vec::new(), contexts, id, hidden: false }
    }
}

/// All nodes of a file.
pub(super) struct Assembly {
    pub nodes: Vec<Node>,
    pub warnings: Vec<Warning>,
    pub lost: Vec<Warning>,
    /// Other numbers of product definitions: of their products, and of the products' versions.
    pub aliases: Vec<[u32; 2]>,
    /// Nodes whose shape stands in another file.
    pub externals: Vec<External>,
}

/// A node's shape that stands in another file.
pub(super) struct External {
    pub node: usize,
    pub definition: u32,
    pub file: String,
}

/// What the assembly is built from.
struct Builder<'f, 'a> {
    file: &'f File<'a>,
    styles: &'f Styles,
    representations: Vec<Representation>,
    by_id: HashMap<u32, usize>,
    /// The parent in the forest of joined representations.
    joined: Vec<usize>,
    units: HashMap<u32, Units>,
    log: Log,
}

/// Reads the whole structure.
pub(super) fn assemble(file: &File, styles: &Styles) -> Assembly {
    let mut builder = Builder {
        file,
        styles,
        representations: Vec::new(),
        by_id: HashMap::new(),
        joined: Vec::new(),
        units: HashMap::new(),
        log: Log::default(),
    };
    builder.find_representations();
    builder.join_plain_relationships();
    builder.build()
}

impl<'f, 'a> Builder<'f, 'a> {
    fn warn(&self, entity: u32, error: impl std::fmt::Display) {
        let message = error.to_string();
        // Messages of errors name their entity, not always this one.
        let message = if message.starts_with('#') { message } else { format!("#{entity}: {message}") };
        self.log.notes.borrow_mut().push(Warning { entity: Some(entity), message });
    }

    fn find_representations(&mut self) {
        for entity in self.file.entities() {
            if is_shape(entity.kind) {
                self.add(&entity);
            } else if entity.kind == Kind::RepresentationMap {
                let mapped = entity.args().ok().and_then(|a| a.skip(1).optional_reference());
                if let Some(mapped) = mapped.and_then(|id| self.file.get(id).ok()) {
                    self.add(&mapped);
                }
            } else if entity.kind == Kind::Complex && entity.part(Kind::ShapeRepresentation).is_some() {
                self.add(&entity);
            }
        }
    }

    fn add(&mut self, entity: &Entity) {
        if self.by_id.contains_key(&entity.id) {
            return;
        }
        let args = match entity.kind {
            Kind::Complex => entity.part(Kind::Representation),
            _ => entity.args().ok(),
        };
        let Some(mut args) = args.map(|a| a.skip(1)) else { return };
        let Ok(items) = args.references() else { return };
        let units = args.optional_reference().map_or_else(Units::default, |context| self.context_units(context));
        self.by_id.insert(entity.id, self.representations.len());
        self.joined.push(self.representations.len());
        self.representations.push(Representation { id: entity.id, items, units });
    }

    fn context_units(&mut self, context: u32) -> Units {
        if let Some(units) = self.units.get(&context) {
            return *units;
        }
        let (units, errors) = Units::of_context(self.file, context);
        for error in errors {
            self.warn(context, error);
        }
        self.units.insert(context, units);
        units
    }

    /// The representation that stands for the joined ones.
    fn root(&self, mut k: usize) -> usize {
        while self.joined[k] != k {
            k = self.joined[k];
        }
        k
    }

    fn node_of(&self, representation: u32) -> Option<usize> {
        self.by_id.get(&representation).map(|&k| self.root(k))
    }

    fn join_plain_relationships(&mut self) {
        for entity in self.file.entities() {
            if !matches!(entity.kind, Kind::ShapeRepresentationRelationship | Kind::RepresentationRelationship) {
                continue;
            }
            let Ok(args) = entity.args() else { continue };
            let mut args = args.skip(2);
            let pair = args.optional_reference().zip(args.optional_reference());
            let Some((a, b)) = pair.and_then(|(a, b)| self.node_of(a).zip(self.node_of(b))) else { continue };
            let (low, high) = (a.min(b), a.max(b));
            self.joined[high] = low;
        }
    }

    fn shapes(&self, units: Units) -> Shapes<'_, 'a> {
        Shapes { file: self.file, units, log: &self.log }
    }

    fn build(self) -> Assembly {
        let products = Products::new(self.file);
        let budget = 1000 + 16 * self.file.len();
        let mut nodes: Vec<Node> = self.representations.iter().map(|_| Node::default()).collect();
        let (met, told) = (HashSet::new(), HashSet::new());
        let mut walker = Walker { file: self.file, styles: self.styles, met, told, budget };
        let mut lost = Vec::new();
        // An item of two joined representations is there once.
        let mut seen: HashSet<(usize, u32)> = HashSet::new();
        for (k, representation) in self.representations.iter().enumerate() {
            let node = self.root(k);
            let (color, hidden) = (self.styles.item(representation.id), self.styles.is_hidden(representation.id));
            let mut contents = Contents::default();
            for &item in representation.items.iter().filter(|&&item| seen.insert((node, item))) {
                walker.item_of(item, color, hidden, &mut contents);
            }
            lost.append(&mut contents.lost);
            self.log.notes.borrow_mut().append(&mut contents.warnings);
            for mapped in std::mem::take(&mut contents.mapped) {
                match self.mapped(&mapped, representation) {
                    Ok(child) => nodes[node].children.push(child),
                    Err(error) => self.warn(mapped.item, error),
                }
            }
            let Representation { id, units, .. } = *representation;
            nodes[node].groups.push(NodePart { id, units, contents });
            if let Some(name) = products.name(representation.id) {
                nodes[node].name = name.to_owned();
            }
            if let Some(id) = products.number(representation.id) {
                nodes[node].id = id;
            }
        }
        self.place_usages(&products, &mut nodes);
        let externals = self.externals(&products, &nodes);
        let orphans = self.orphans(&mut walker, &mut lost);
        nodes.extend(orphans);
        Assembly { nodes, warnings: self.log.notes.take(), lost, aliases: products.aliases(), externals }
    }

    fn mapped(&self, mapped: &super::items::Mapped, parent: &Representation) -> Result<Child, StepError> {
        let mut map = self.file.args(mapped.map, Kind::RepresentationMap, "a representation map")?;
        let (origin, source) = (map.reference()?, map.reference()?);
        let index = *self.by_id.get(&source).ok_or(StepError::Missing(source))?;
        let origin = self.shapes(self.representations[index].units).map(origin)?;
        let target = self.shapes(parent.units).map(mapped.target)?;
        let color = self.styles.item(mapped.item);
        let transform = target * origin.inverse();
        let (node, name) = (self.root(index), mapped.name.clone());
        let (id, hidden) = (mapped.item, mapped.hidden);
        Ok(Child { node, transform, name, color, face_colors: Vec::new(), contexts: vec![id], id, hidden })
    }

    /// Children by transformations between representations, and usages that have none.
    fn place_usages(&self, products: &Products, nodes: &mut [Node]) {
        let mut placed: HashSet<u32> = HashSet::new();
        for entity in self.file.entities().filter(|e| e.kind == Kind::Complex) {
            let parts = entity.parts();
            let of = |kind| parts.iter().find(|(k, _)| *k == kind).map(|(_, args)| args.clone());
            let Some(mut with) = of(Kind::RepresentationRelationshipWithTransformation) else { continue };
            let Some(relation) = of(Kind::RepresentationRelationship) else { continue };
            let mut relation = relation.skip(2);
            let both = relation.optional_reference().zip(relation.optional_reference());
            let (Some(both), Some(operator)) = (both, with.optional_reference()) else { continue };
            let usages = products.usages_of(entity.id);
            let usage = usages.first().copied();
            placed.extend(usages.iter().map(|u| u.id));
            match self.placed(entity.id, both, operator, usage, products) {
                Ok(Some((parent, child))) => nodes[parent].children.push(child),
                Ok(None) => {}
                Err(error) => self.warn(entity.id, error),
            }
        }
        for usage in products.usages().filter(|u| !placed.contains(&u.id)) {
            let ends = [usage.parent, usage.child].map(|p| products.shape(p).and_then(|id| self.node_of(id)));
            let [Some(parent), Some(node)] = ends else { continue };
            if parent != node {
                self.warn(usage.id, "nothing says where this component is placed: it stays where it is");
                let (name, transform) = (usage.name.clone(), DAffine3::IDENTITY);
                nodes[parent].children.push(Child::of_usage(node, transform, name, Some(usage)));
            }
        }
    }

    /// The nodes without shapes of their own that name a file which has them.
    fn externals(&self, products: &Products, nodes: &[Node]) -> Vec<External> {
        let has_shapes = |node: usize| {
            let parts = &nodes[node].groups;
            let faces = parts.iter().any(|p| !p.contents.solid.is_empty() || !p.contents.open.is_empty());
            faces || !nodes[node].children.is_empty()
        };
        let mut externals = Vec::new();
        for (&definition, files) in products.files() {
            let node = products.shape(definition).and_then(|shape| self.node_of(shape));
            let Some(file) = files.first().filter(|_| node.is_none_or(|node| !has_shapes(node))) else { continue };
            match node {
                Some(node) => externals.push(External { node, definition, file: file.clone() }),
                None => self.warn(definition, format!("its shape is in {file}, and nothing says where that stands")),
            }
        }
        externals
    }

    /// The parent's node and the child of one transformation.
    fn placed(
        &self,
        id: u32,
        (first, second): (u32, u32),
        operator: u32,
        usage: Option<&Usage>,
        products: &Products,
    ) -> Result<Option<(usize, Child)>, StepError> {
        let index = |id: u32| self.by_id.get(&id).copied().ok_or(StepError::Missing(id));
        let [one, two] = [index(first)?, index(second)?];
        let nodes = [self.root(one), self.root(two)];
        if nodes[0] == nodes[1] {
            return Ok(None);
        }
        // The second is the parent, unless the usage says that it is the component.
        let node_of_product = |product: u32| products.shape(product).and_then(|shape| self.node_of(shape));
        let swapped = usage
            .is_some_and(|u| node_of_product(u.parent) == Some(nodes[0]) && node_of_product(u.child) != Some(nodes[0]));
        let forward = self.transformation(operator, &self.representations[one], &self.representations[two])?;
        let (parent, node, transform) =
            if swapped { (nodes[0], nodes[1], forward.inverse()) } else { (nodes[1], nodes[0], forward) };
        if !transform.is_finite() {
            return Err(StepError::Bad { entity: id, what: "a transformation that can't be inverted".into() });
        }
        let name = usage.map(|u| u.name.clone()).unwrap_or_default();
        let mut child = Child::of_usage(node, transform, name, usage);
        child.contexts.push(id);
        Ok(Some((parent, child)))
    }

    /// From the first representation's frame to the second's.
    fn transformation(&self, id: u32, one: &Representation, two: &Representation) -> Result<DAffine3, StepError> {
        let entity = self.file.get(id)?;
        if entity.kind != Kind::ItemDefinedTransformation {
            return self.shapes(two.units).map(id);
        }
        let mut args = entity.args()?.skip(2);
        let [mut from, mut to] = [args.reference()?, args.reference()?];
        let crossed = !one.items.contains(&from) && two.items.contains(&from) && one.items.contains(&to);
        if crossed {
            (from, to) = (to, from);
        }
        let [from, to] = [self.shapes(one.units).map(from)?, self.shapes(two.units).map(to)?];
        Ok(to * from.inverse())
    }

    /// Solids, shells and faces that no representation leads to: files without representations, or cut ones.
    fn orphans(&self, walker: &mut Walker, lost: &mut Vec<Warning>) -> Option<Node> {
        let solid = |k| matches!(k, Kind::ManifoldSolidBrep | Kind::FacetedBrep | Kind::BrepWithVoids);
        let model = |k| matches!(k, Kind::ShellBasedSurfaceModel | Kind::FaceBasedSurfaceModel);
        let shell = |k| matches!(k, Kind::ClosedShell | Kind::OpenShell | Kind::ConnectedFaceSet);
        let face = |k| matches!(k, Kind::AdvancedFace | Kind::FaceSurface);
        let units = self.representations.first().map(|r| r.units);
        let units = units.or_else(|| self.any_units()).unwrap_or_default();
        let mut contents = Contents::default();
        let mut count = 0;
        for wanted in [&solid as &dyn Fn(Kind) -> bool, &model, &shell, &face] {
            for entity in self.file.entities().filter(|e| wanted(e.kind)) {
                if !walker.met.contains(&entity.id) {
                    count += 1;
                    walker.item(entity.id, None, &mut contents);
                }
            }
        }
        lost.append(&mut contents.lost);
        if count == 0 {
            return None;
        }
        let first = contents.solid.first().or(contents.open.first()).map(|f| f.id);
        let message = format!("{count} shapes belong to no representation; they are shown where they are");
        self.log.notes.borrow_mut().push(Warning { entity: first, message });
        Some(Node { groups: vec![NodePart { id: 0, units, contents }], ..Node::default() })
    }

    /// Of a file without representations.
    fn any_units(&self) -> Option<Units> {
        let contexts = self.file.entities().filter(|e| e.kind == Kind::Complex);
        let mut contexts = contexts.filter(|e| e.part(Kind::GlobalUnitAssignedContext).is_some());
        contexts.next().map(|context| Units::of_context(self.file, context.id).0)
    }
}

fn is_shape(kind: Kind) -> bool {
    matches!(
        kind,
        Kind::ShapeRepresentation
            | Kind::AdvancedBrepShapeRepresentation
            | Kind::FacetedBrepShapeRepresentation
            | Kind::ManifoldSurfaceShapeRepresentation
            | Kind::NonManifoldSurfaceShapeRepresentation
            | Kind::GeometricallyBoundedSurfaceShapeRepresentation
            | Kind::CsgShapeRepresentation
            | Kind::TessellatedShapeRepresentation
            | Kind::ShapeRepresentationWithParameters
    )
}
