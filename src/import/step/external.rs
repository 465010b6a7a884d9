//! Parts whose shapes stand in other files: these are read too where they lie beside this one.

use super::assembly::{Assembly, Child, External, Node};
use crate::import::Origin;
use crate::model::{Model, Warning};
use std::collections::BTreeMap;

/// Reads the files that nodes refer to and puts their parts in place, in millimetres as everything is.
pub(super) fn attach(assembly: &mut Assembly, parts: &mut Vec<Vec<usize>>, model: &mut Model, origin: &Origin) {
    let mut by_file: BTreeMap<String, Vec<External>> = BTreeMap::new();
    for external in std::mem::take(&mut assembly.externals) {
        by_file.entry(external.file.clone()).or_default().push(external);
    }
    for (file, uses) in by_file {
        match origin.read_beside(&file) {
            Ok(other) => add(assembly, parts, model, other, &file, &uses),
            Err(why) => {
                let [first, ..] = &uses[..] else { continue };
                let name = &assembly.nodes[first.node].name;
                let more = if uses.len() > 1 { format!(" and {} more", uses.len() - 1) } else { String::new() };
                let message = format!("#{}: the shape of \"{name}\"{more} is in another file: {why}", first.definition);
                model.warnings.push(Warning { entity: Some(first.definition), message });
            }
        }
    }
}

/// Each part of the other file as a node of its own, under every node that refers to the file.
fn add(
    assembly: &mut Assembly,
    parts: &mut Vec<Vec<usize>>,
    model: &mut Model,
    other: Model,
    file: &str,
    uses: &[External],
) {
    let Model { parts: other_parts, instances, unit, warnings, lost, unshown, aliases, .. } = other;
    if unit.as_deref() != Some("mm") {
        let message = format!("{file}: names no millimetres: its numbers are taken for these");
        model.warnings.push(Warning { entity: None, message });
    }
    let named = |w: Warning| Warning { message: format!("{file}: {}", w.message), ..w };
    model.warnings.extend(warnings.into_iter().map(named));
    model.lost.extend(lost.into_iter().map(named));
    model.unshown.hidden_faces += unshown.hidden_faces;
    model.unshown.lone_curves += unshown.lone_curves;
    model.aliases.extend(aliases);
    let first = assembly.nodes.len();
    for part in other_parts {
        assembly.nodes.push(Node { id: part.id, name: part.name.clone(), ..Node::default() });
        parts.push(vec![model.parts.len()]);
        model.parts.push(part);
    }
    for external in uses {
        for instance in &instances {
            assembly.nodes[external.node].children.push(Child {
                node: first + instance.part,
                transform: instance.transform,
                name: instance.name.clone(),
                color: instance.color,
                face_colors: instance.face_colors.clone(),
                contexts: Vec::new(),
                id: 0,
                hidden: false,
            });
        }
    }
}
