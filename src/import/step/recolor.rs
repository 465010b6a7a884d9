//! Colours that items have in one place of the assembly only, for the faces of its instances.

use super::assembly::Assembly;
use super::styles::Override;
use crate::model::Part;
use foldhash::{HashMap, HashSet};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// What an instance overrides: the colour of all of it, and those of single faces, ascending.
type Colors = (Option<[f32; 3]>, Vec<(usize, [f32; 3])>);

/// All overrides of a file, by what they apply to.
pub(super) struct Recolor<'a> {
    overrides: &'a [Override],
    /// Overrides by each of their contexts.
    by_context: HashMap<u32, Vec<usize>>,
    /// The faces of an item in a part.
    faces: HashMap<(usize, u32), Vec<usize>>,
    /// Items that are some part's faces, or a place on the way to some.
    parts_items: HashSet<u32>,
    places: HashSet<u32>,
}

impl<'a> Recolor<'a> {
    pub fn new(overrides: &'a [Override], assembly: &Assembly, parts: &[Part]) -> Self {
        let mut by_context: HashMap<u32, Vec<usize>> = HashMap::default();
        for (k, style) in overrides.iter().enumerate() {
            style.contexts.iter().for_each(|&context| by_context.entry(context).or_default().push(k));
        }
        let items: HashSet<u32> = overrides.iter().map(|style| style.item).collect();
        let mut faces: HashMap<(usize, u32), Vec<usize>> = HashMap::default();
        let mut places = HashSet::default();
        if !items.is_empty() {
            for (number, part) in parts.iter().enumerate() {
                let single = part.faces.iter().enumerate().map(|(k, face)| (face.id, k..k + 1));
                let groups = part.groups.iter().map(|group| (group.id, group.faces.clone()));
                for (item, range) in single.chain(groups).filter(|(item, _)| items.contains(item)) {
                    faces.entry((number, item)).or_default().extend(range);
                }
            }
            let children = assembly.nodes.iter().flat_map(|node| &node.children);
            places.extend(children.flat_map(|child| &child.contexts).filter(|id| items.contains(id)));
        }
        let parts_items = faces.keys().map(|&(_, item)| item).collect();
        Self { overrides, by_context, faces, parts_items, places }
    }

    /// The colours of a part below `contexts`, the outermost first: outer places override inner ones, and smaller items
    /// larger ones.
    pub fn of(&self, part: usize, count: usize, contexts: &[u32], inherited: Colors) -> Colors {
        let mut found: Vec<(usize, Vec<usize>, [f32; 3])> = Vec::new();
        if !self.overrides.is_empty() {
            for (depth, context) in contexts.iter().enumerate() {
                for &k in self.by_context.get(context).map_or(&[][..], Vec::as_slice) {
                    let style = &self.overrides[k];
                    let first = style.contexts.iter().all(|c| !contexts[..depth].contains(c));
                    let whole = style.contexts.iter().all(|c| contexts.contains(c));
                    if first
                        && whole
                        && let Some(faces) = self.reached(style, part, count, contexts)
                    {
                        found.push((depth, faces, style.color));
                    }
                }
            }
        }
        // Stable: what the file says last wins.
        found.sort_by_key(|(depth, faces, _)| Reverse((*depth, faces.len())));
        let (mut all, single) = inherited;
        let mut single: BTreeMap<usize, [f32; 3]> = single.into_iter().collect();
        for (_, faces, color) in found {
            if faces.len() == count {
                all = Some(color);
                single.clear();
            } else {
                single.extend(faces.into_iter().map(|face| (face, color)));
            }
        }
        (all, single.into_iter().collect())
    }

    /// The faces of a part that an override colours; none where it speaks of others.
    fn reached(&self, style: &Override, part: usize, count: usize, contexts: &[u32]) -> Option<Vec<usize>> {
        if let Some(faces) = self.faces.get(&(part, style.item)) {
            return Some(faces.clone());
        }
        // What is no face, no solid and no place stands for all that is there.
        let elsewhere = self.parts_items.contains(&style.item);
        let passed = !self.places.contains(&style.item) || contexts.contains(&style.item);
        (!elsewhere && passed).then(|| (0..count).collect())
    }
}
