//! One part of a model: by the number that the file has for it, or by its name.

use super::{Face, Group, Model, Part, Solidity};
use std::collections::BTreeMap;
use thiserror::Error;

/// Why a part could not be selected.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum PartError {
    #[error("there is no part, solid, shell, set, component or face #{id}; {near}")]
    NoEntity { id: String, near: String },
    #[error("there is no part, component, solid or face named {name:?}; {near}")]
    NoName { name: String, near: String },
}

/// What an error lists.
const LISTED: usize = 12;

/// Names that differ more are not near (1 is the same; Jaro and Winkler).
const NEAR: f64 = 0.7;

impl Model {
    /// Keeps one part. `#ID` is the file's number of a part (its product, version or definition), of a component (its use
    /// in an assembly, or a mapped item: with all that is in it), of a solid, shell, set or representation, or of a single
    /// face. Anything else is a name: of a part or a component, whole or between slashes, or of a solid or a face; if need
    /// be without regard to case.
    ///
    /// # Errors
    /// Where there is no such thing: with what is there, the nearest first.
    pub fn select(self, part: &str) -> Result<Model, PartError> {
        let Some(id) = part.strip_prefix('#') else { return self.select_named(part) };
        let missing =
            |model: &Model, number| PartError::NoEntity { id: id.to_owned(), near: model.near_number(number) };
        match id.parse::<u32>() {
            Ok(number) if number != 0 => self.select_number(number).map_err(|model| missing(&model, number)),
            // No file numbers anything so; the built-in models number their faces from 0.
            Ok(number) => self.keep_faces(&|_| None, &|face| face.id == number).map_err(|m| missing(&m, number)),
            Err(_) => Err(missing(&self, 0)),
        }
    }

    fn select_number(self, number: u32) -> Result<Model, Model> {
        let alias = self.aliases.iter().find(|alias| alias[0] == number).map_or(number, |alias| alias[1]);
        if self.instances.iter().any(|i| self.parts[i.part].id == alias || i.path.contains(&alias)) {
            return Ok(self.keep(|part, _, path| part.id == alias || path.contains(&alias)));
        }
        let chosen = |group: &Group| group.id == number;
        self.keep_faces(&|part| whole_group(part, &chosen), &|face| face.id == number)
    }

    fn select_named(self, name: &str) -> Result<Model, PartError> {
        let exact = |other: &str| other == name;
        let lower = name.to_lowercase();
        let any_case = |other: &str| other.to_lowercase() == lower;
        let mut model = self;
        for same in [&exact as &dyn Fn(&str) -> bool, &any_case] {
            let is_it =
                |part: &Part, instance: &str| same(&part.name) || same(instance) || instance.split('/').any(same);
            if model.instances.iter().any(|i| is_it(&model.parts[i.part], &i.name)) {
                return Ok(model.keep(|part, instance, _| is_it(part, instance)));
            }
            let chosen = |group: &Group| same(&group.name);
            match model.keep_faces(&|part| whole_group(part, &chosen), &|face| same(&face.name)) {
                Ok(found) => return Ok(found),
                Err(rest) => model = rest,
            }
        }
        Err(PartError::NoName { name: name.to_owned(), near: model.near_names(name) })
    }

    /// The groups of parts that `groups` chooses, else the faces that `is_it`; the model itself where there are none.
    fn keep_faces(
        self,
        groups: &dyn Fn(&Part) -> Option<Chosen>,
        is_it: &dyn Fn(&Face) -> bool,
    ) -> Result<Model, Model> {
        let chosen: Vec<Option<Chosen>> = self.parts.iter().map(groups).collect();
        let by_face = chosen.iter().all(Option::is_none);
        let wanted = |(part, chosen): (&Part, Option<Chosen>)| match chosen {
            Some(chosen) => Some(chosen),
            None if by_face => {
                let faces: Vec<bool> = part.faces.iter().map(is_it).collect();
                // A single face bounds no solid.
                faces.contains(&true).then_some(Chosen { faces, is_solid: false })
            }
            None => None,
        };
        let chosen: Vec<Option<Chosen>> = self.parts.iter().zip(chosen).map(wanted).collect();
        if chosen.iter().all(Option::is_none) {
            return Err(self);
        }
        let mut model = self;
        for (part, chosen) in model.parts.iter_mut().zip(&chosen) {
            let Some(Chosen { faces, is_solid }) = chosen else { continue };
            if !is_solid && faces.contains(&false) {
                part.solidity = Solidity::Open;
            }
            let mut kept = faces.iter();
            part.faces.retain(|_| kept.next() == Some(&true));
            part.groups.clear();
        }
        model.keep_parts(|k| chosen[k].is_some());
        Ok(model)
    }

    /// Drops the other instances, and the parts that none is left of.
    fn keep(mut self, wanted: impl Fn(&Part, &str, &[u32]) -> bool) -> Model {
        let parts = &self.parts;
        self.instances.retain(|i| wanted(&parts[i.part], &i.name, &i.path));
        self.keep_parts(|_| true);
        self
    }

    /// Drops the instances of other parts, and the parts that none is left of.
    fn keep_parts(&mut self, wanted: impl Fn(usize) -> bool) {
        self.instances.retain(|i| wanted(i.part));
        let mut numbers = vec![None; self.parts.len()];
        self.instances.iter().for_each(|i| numbers[i.part] = Some(0));
        for (next, number) in numbers.iter_mut().flatten().enumerate() {
            *number = next;
        }
        self.instances.iter_mut().for_each(|i| i.part = numbers[i.part].unwrap_or_default());
        let mut kept = numbers.iter();
        self.parts.retain(|_| kept.next().is_some_and(Option::is_some));
    }

    /// What there is with a name, the most alike first.
    fn near_names(&self, name: &str) -> String {
        let mut names: Vec<&str> = self.instances.iter().flat_map(|i| i.name.split('/')).collect();
        for part in &self.parts {
            names.push(&part.name);
            names.extend(part.groups.iter().map(|group| group.name.as_str()));
            names.extend(part.faces.iter().map(|face| &*face.name));
        }
        names.retain(|n| !n.trim().is_empty());
        names.sort_unstable();
        names.dedup();
        let lower = name.to_lowercase();
        let likeness = |other: &&str| {
            let other = other.to_lowercase();
            let within = other.contains(&lower) || lower.contains(&other);
            if within { 1.0 } else { strsim::jaro_winkler(&lower, &other) }
        };
        let mut alike: Vec<(f64, &str)> = names.iter().map(|n| (likeness(n), *n)).filter(|n| n.0 >= NEAR).collect();
        alike.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
        let (what, mut listed) = match alike.is_empty() {
            true => ("there are", names.clone()),
            false => ("near it are", alike.into_iter().map(|n| n.1).collect()),
        };
        listed.truncate(LISTED);
        match (listed.is_empty(), names.len() - listed.len()) {
            (true, _) => "nothing has a name".to_owned(),
            (_, 0) => format!("{what}: {}", listed.join(", ")),
            (_, more) => format!("{what}: {} and {more} more", listed.join(", ")),
        }
    }

    /// What there is with a number, the nearest numbers first; faces only where nothing else is.
    fn near_number(&self, number: u32) -> String {
        let mut known: BTreeMap<u32, &str> = BTreeMap::new();
        for part in &self.parts {
            known.entry(part.id).or_insert(&part.name);
            for group in &part.groups {
                known.entry(group.id).or_insert(&group.name);
            }
        }
        for &id in self.instances.iter().flat_map(|i| &i.path) {
            known.entry(id).or_insert("");
        }
        known.remove(&0);
        if known.is_empty() {
            let faces = self.parts.iter().flat_map(|part| &part.faces);
            known.extend(faces.map(|face| (face.id, &*face.name)));
        }
        let mut listed: Vec<(u32, &str)> = known.into_iter().collect();
        listed.sort_by_key(|(id, _)| (id.abs_diff(number), *id));
        let more = listed.len().saturating_sub(LISTED);
        listed.truncate(LISTED);
        let named =
            |(id, name): &(u32, &str)| if name.is_empty() { format!("#{id}") } else { format!("#{id} ({name})") };
        let listed: Vec<String> = listed.iter().map(named).collect();
        match (listed.is_empty(), more) {
            (true, _) => "nothing has a number".to_owned(),
            (_, 0) => format!("near it are: {}", listed.join(", ")),
            _ => format!("near it are: {} and {more} more", listed.join(", ")),
        }
    }
}

/// Which faces of a part are kept, and whether they bound a solid.
struct Chosen {
    faces: Vec<bool>,
    is_solid: bool,
}

/// The faces of all groups that are meant; `None` without any.
fn whole_group(part: &Part, is_it: &dyn Fn(&Group) -> bool) -> Option<Chosen> {
    let mut chosen = Chosen { faces: vec![false; part.faces.len()], is_solid: true };
    let mut found = false;
    for group in part.groups.iter().filter(|group| is_it(group)) {
        chosen.faces.get_mut(group.faces.clone())?.fill(true);
        chosen.is_solid &= group.is_solid;
        found = true;
    }
    found.then_some(chosen)
}
