//! Nested nodes as instances in the world.

use super::assembly::Assembly;
use super::recolor::Recolor;
use crate::model::{Instance, Part, Warning};
use glam::DAffine3;

/// Assemblies nest no deeper.
const MAX_DEPTH: usize = 200;
/// More ways through the assembly are left out: a few lines of text can ask for 2^60.
const MAX_STEPS: usize = 1 << 19;

/// A way from the top through an assembly.
struct Walk<'a> {
    assembly: &'a Assembly,
    /// Parts of each node.
    parts: &'a [Vec<usize>],
    all: &'a [Part],
    recolor: &'a Recolor<'a>,
    /// Nodes with parts in them, or below them.
    holds: Vec<bool>,
    on_path: Vec<bool>,
    reached: Vec<bool>,
    steps: usize,
    flat: Flat,
}

/// Where a walk stands.
struct Place<'a> {
    node: usize,
    transform: DAffine3,
    name: String,
    color: Option<[f32; 3]>,
    /// Of single faces of this node's own parts.
    face_colors: &'a [(usize, [f32; 3])],
    depth: usize,
    /// Numbers by which a style may name this place, from the top.
    contexts: Vec<u32>,
    /// Numbers of the product definitions and usages from the top to here.
    path: Vec<u32>,
    hidden: bool,
}

/// The instances of all parts that are to be seen.
#[derive(Default)]
pub(super) struct Flat {
    pub instances: Vec<Instance>,
    /// Parts whose instances are hidden, once for each.
    pub hidden: Vec<usize>,
    pub warnings: Vec<Warning>,
}

/// Walks through the whole; `parts` has those of each node among `all`.
pub(super) fn flatten(assembly: &Assembly, parts: &[Vec<usize>], all: &[Part], recolor: &Recolor) -> Flat {
    let count = assembly.nodes.len();
    let mut is_child = vec![false; count];
    for child in assembly.nodes.iter().flat_map(|n| &n.children) {
        is_child[child.node] = true;
    }
    let mut walk = Walk {
        assembly,
        parts,
        all,
        recolor,
        holds: holders(assembly, parts),
        on_path: vec![false; count],
        reached: vec![false; count],
        steps: 0,
        flat: Flat::default(),
    };
    let tops = (0..count).filter(|&n| !is_child[n]);
    // What only reaches itself has no top: it is entered somewhere.
    for node in tops.chain(0..count) {
        if !walk.reached[node] {
            let name = assembly.nodes[node].name.clone();
            let (transform, contexts, path) = (DAffine3::IDENTITY, Vec::new(), Vec::new());
            let (color, face_colors) = (None, &[][..]);
            walk.enter(Place { node, transform, name, color, face_colors, depth: 0, contexts, path, hidden: false });
        }
    }
    if walk.steps >= MAX_STEPS {
        walk.warn(format!("the assembly asks for more than {MAX_STEPS} components; the rest is left out"));
    }
    walk.flat
}

/// The nodes that have parts in them, or below them.
fn holders(assembly: &Assembly, parts: &[Vec<usize>]) -> Vec<bool> {
    let mut parents = vec![Vec::new(); assembly.nodes.len()];
    for (parent, node) in assembly.nodes.iter().enumerate() {
        node.children.iter().for_each(|child| parents[child.node].push(parent));
    }
    let mut holds: Vec<bool> = parts.iter().map(|own| !own.is_empty()).collect();
    let mut todo: Vec<usize> = (0..holds.len()).filter(|&node| holds[node]).collect();
    while let Some(node) = todo.pop() {
        for &parent in &parents[node] {
            if !std::mem::replace(&mut holds[parent], true) {
                todo.push(parent);
            }
        }
    }
    holds
}

impl<'a> Walk<'a> {
    fn warn(&mut self, message: String) {
        // One of a kind is enough.
        if !self.flat.warnings.iter().any(|w| w.message == message) {
            self.flat.warnings.push(Warning { entity: None, message });
        }
    }

    fn enter(&mut self, mut place: Place<'a>) {
        self.steps += 1;
        if self.steps > MAX_STEPS {
            return;
        }
        if self.on_path[place.node] || place.depth > MAX_DEPTH {
            let name = &self.assembly.nodes[place.node].name;
            return self.warn(format!("the assembly \"{name}\" contains itself, or nests deeper than {MAX_DEPTH}"));
        }
        self.on_path[place.node] = true;
        self.reached[place.node] = true;
        let assembly = self.assembly;
        place.path.extend(Some(assembly.nodes[place.node].id).filter(|&id| id != 0));
        place.contexts.extend(assembly.nodes[place.node].groups.iter().map(|group| group.id).filter(|&id| id != 0));
        for &part in &self.parts[place.node] {
            if place.hidden {
                self.flat.hidden.push(part);
                continue;
            }
            let inherited = (place.color, place.face_colors.to_vec());
            let count = self.all[part].faces.len();
            let (color, face_colors) = self.recolor.of(part, count, &place.contexts, inherited);
            let Place { transform, ref name, ref path, .. } = place;
            let (name, path) = (name.clone(), path.clone());
            self.flat.instances.push(Instance { part, transform, name, color, face_colors, path });
        }
        for child in &assembly.nodes[place.node].children {
            if !self.holds[child.node] {
                continue;
            }
            let transform = place.transform * child.transform;
            let own = if child.name.is_empty() { &assembly.nodes[child.node].name } else { &child.name };
            let name = if place.name.is_empty() { own.clone() } else { format!("{}/{own}", place.name) };
            // A style of the whole is meant for all of it.
            let color = place.color.or(child.color);
            let mut path = place.path.clone();
            path.extend(Some(child.id).filter(|&id| id != 0));
            let mut contexts = place.contexts.clone();
            contexts.extend(child.contexts.iter().filter(|&&id| id != 0));
            let hidden = place.hidden || child.hidden;
            let (node, face_colors, depth) = (child.node, &child.face_colors[..], place.depth + 1);
            self.enter(Place { node, transform, name, color, face_colors, depth, contexts, path, hidden });
        }
        self.on_path[place.node] = false;
    }
}
