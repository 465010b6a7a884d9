//! The entities of a file by their numbers.

use super::args::Args;
use super::cursor::Cursor;
use super::error::StepError;
use super::kinds::Kind;
use super::scan::{Record, Scanned};
use glam::DVec3;

/// A file's text with where its entities stand. (The text is in memory: mapping files needs `unsafe`, and a file that
/// shrinks while it is mapped ends the process.)
pub(super) struct File<'a> {
    text: &'a [u8],
    records: Vec<Record>,
    triples: Vec<DVec3>,
    index: Index,
}

/// Of a keyword, messages show this much.
const LONGEST_KEYWORD: usize = 80;

/// From entity numbers to records.
enum Index {
    /// One more than the record, by number; 0: none.
    Dense(Vec<u32>),
    /// Numbers and records, sorted.
    Sparse(Vec<(u32, u32)>),
}

/// One entity.
#[derive(Clone, Copy)]
pub(super) struct Entity<'a> {
    pub id: u32,
    pub kind: Kind,
    text: &'a [u8],
    at: usize,
    /// As [`Record::open`].
    open: u16,
}

impl<'a> File<'a> {
    /// Also gives the numbers that are used twice, the later ones being left out.
    pub fn new(text: &'a [u8], Scanned { records, triples, .. }: Scanned) -> (Self, Vec<u32>) {
        let highest = records.iter().map(|r| r.id).max().unwrap_or(0) as usize;
        let mut twice = Vec::new();
        let index = if highest <= 1000 + 8 * records.len() {
            let mut slots = vec![0; highest + 1];
            for (k, record) in records.iter().enumerate() {
                let slot = &mut slots[record.id as usize];
                if *slot == 0 { *slot = k as u32 + 1 } else { twice.push(record.id) }
            }
            Index::Dense(slots)
        } else {
            let mut pairs: Vec<(u32, u32)> = records.iter().enumerate().map(|(k, r)| (r.id, k as u32)).collect();
            pairs.sort_unstable();
            pairs.dedup_by(|later, first| {
                let same = later.0 == first.0;
                twice.extend(same.then_some(later.0));
                same
            });
            Index::Sparse(pairs)
        };
        (Self { text, records, triples, index }, twice)
    }

    /// Number of entities.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    fn entity(&self, record: Record) -> Entity<'a> {
        Entity { id: record.id, kind: record.kind, text: self.text, at: record.at as usize, open: record.open }
    }

    /// All entities in the file's order.
    pub fn entities(&self) -> impl Iterator<Item = Entity<'a>> {
        self.records.iter().map(|&r| self.entity(r))
    }

    pub fn get(&self, id: u32) -> Result<Entity<'a>, StepError> {
        let Some(&record) = self.record(id) else { return Err(StepError::Missing(id)) };
        Ok(self.entity(record))
    }

    /// The numbers of point or direction `id`, where they are written as usual.
    pub fn triple(&self, id: u32, kind: Kind) -> Option<DVec3> {
        let record = self.record(id).filter(|r| r.kind == kind)?;
        self.triples.get((record.triple as usize).checked_sub(1)?).copied()
    }

    fn record(&self, id: u32) -> Option<&Record> {
        match &self.index {
            Index::Dense(slots) => slots.get(id as usize).and_then(|&k| self.records.get(k.checked_sub(1)? as usize)),
            Index::Sparse(pairs) => {
                let found = pairs.binary_search_by_key(&id, |p| p.0).ok();
                found.and_then(|k| self.records.get(pairs[k].1 as usize))
            }
        }
    }

    /// The parameters of entity `id`, which must be of `kind`.
    pub fn args(&self, id: u32, kind: Kind, expected: &'static str) -> Result<Args<'a>, StepError> {
        let entity = self.get(id)?;
        if entity.kind == kind { entity.args() } else { Err(entity.is_not(expected)) }
    }
}

impl<'a> Entity<'a> {
    /// Its keyword; of a complex entity the first.
    pub fn keyword(&self) -> String {
        let mut cursor = Cursor { text: self.text, at: self.at };
        if self.kind == Kind::Complex {
            cursor.at += 1;
            let _ = cursor.blank();
        }
        let keyword = cursor.keyword().unwrap_or_default();
        String::from_utf8_lossy(&keyword[..keyword.len().min(LONGEST_KEYWORD)]).into_owned()
    }

    pub fn is_not(&self, expected: &'static str) -> StepError {
        StepError::Kind { entity: self.id, found: self.keyword(), expected }
    }

    /// The parameters of an entity with one keyword.
    pub fn args(&self) -> Result<Args<'a>, StepError> {
        if self.open > 0 {
            return Ok(Args::inside(self.text, self.at + usize::from(self.open), self.id));
        }
        let mut cursor = Cursor { text: self.text, at: self.at };
        let open = cursor.keyword().ok().and_then(|_| Args::open(self.text, cursor.at, self.id));
        open.ok_or_else(|| self.is_not("an entity with one keyword"))
    }

    /// The parts of a complex entity.
    pub fn parts(&self) -> Vec<(Kind, Args<'a>)> {
        let mut parts = Vec::new();
        if self.kind != Kind::Complex {
            return parts;
        }
        let mut cursor = Cursor { text: self.text, at: self.at + 1 };
        while cursor.blank().is_ok() && cursor.peek() != Some(b')') {
            let Ok(keyword) = cursor.keyword() else { break };
            let Some(args) = Args::open(self.text, cursor.at, self.id) else { break };
            parts.push((Kind::of(keyword), args.clone()));
            cursor.at = args.end();
        }
        parts
    }

    /// The parameters of one part of a complex entity.
    pub fn part(&self, kind: Kind) -> Option<Args<'a>> {
        self.parts().into_iter().find(|(k, _)| *k == kind).map(|(_, args)| args)
    }
}
