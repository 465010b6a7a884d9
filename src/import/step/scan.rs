//! The statements of a Part 21 file (ISO 10303-21:2016, clause 5): where each entity stands, its number and its keyword.
//!
//! One pass checks the syntax and keeps 16 bytes an entity, and the numbers of points and directions, which make up most
//! of a file and are asked for several times. Other parameters are read from the text when they are asked for.
//! The text is cut at guessed statement ends and the pieces are scanned in parallel. A guess inside a string or a comment
//! shows when the piece before doesn't end there, and is then scanned again from the right place.

use super::cursor::Cursor;
use super::kinds::Kind;
use glam::DVec3;
use rayon::prelude::*;

/// Pieces smaller than this are not worth a thread.
const SMALLEST_PIECE: usize = 1 << 17;
/// After an error further than this into a statement, reading goes on behind the error, not inside the statement: else
/// an unclosed comment after every `#` would cost the square of the file's size.
const RETRY_WITHIN: usize = 4096;
/// Errors beyond these are counted only.
const ERRORS_KEPT: usize = 20;

/// Where an entity stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record {
    pub id: u32,
    /// Offset of its keyword, or of the parenthesis of a complex entity.
    pub at: u32,
    /// From there to the opening parenthesis; 0 where that is too far.
    pub open: u16,
    pub kind: Kind,
    /// One more than the place of its numbers among the triples; 0: none.
    pub triple: u32,
}

/// What the text says that it shouldn't.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SyntaxError {
    pub at: usize,
    pub what: &'static str,
}

#[derive(Default)]
pub(super) struct Scanned {
    /// In the file's order.
    pub records: Vec<Record>,
    /// What points and directions hold, where it is written as usual.
    pub triples: Vec<DVec3>,
    pub errors: Vec<SyntaxError>,
    /// All errors, those that are not kept too.
    pub error_count: usize,
    /// Numbers that stand for entities of other files (the REFERENCE section).
    pub elsewhere: usize,
    /// `END-ISO-10303-21` was met.
    pub ended: bool,
}

impl Scanned {
    fn error(&mut self, error: SyntaxError) {
        self.error_count += 1;
        if self.errors.len() < ERRORS_KEPT {
            self.errors.push(error);
        }
    }

    fn append(&mut self, mut other: Self) {
        let before = self.triples.len() as u32;
        other.records.iter_mut().filter(|r| r.triple > 0).for_each(|r| r.triple += before);
        self.records.append(&mut other.records);
        self.triples.append(&mut other.triples);
        self.error_count += other.error_count;
        self.elsewhere += other.elsewhere;
        let room = ERRORS_KEPT.saturating_sub(self.errors.len());
        self.errors.extend(other.errors.into_iter().take(room));
        self.ended |= other.ended;
    }
}

/// Scans a whole file.
pub(super) fn scan(text: &[u8]) -> Scanned {
    let pieces = (text.len() / SMALLEST_PIECE).clamp(1, 4 * rayon::current_num_threads());
    let mut cuts: Vec<usize> = (1..pieces).filter_map(|k| guess_start(text, text.len() / pieces * k)).collect();
    cuts.dedup();
    cuts.insert(0, 0);
    cuts.push(text.len());
    let ranges: Vec<[usize; 2]> = cuts.windows(2).map(|w| [w[0], w[1]]).collect();
    let scanned: Vec<(Scanned, usize)> = ranges.par_iter().map(|&range| scan_piece(text, range)).collect();
    let mut whole = Scanned::default();
    let mut at = 0;
    for ([start, end], (mut piece, mut stop)) in ranges.into_iter().zip(scanned) {
        if at > start {
            (piece, stop) = if at < end { scan_piece(text, [at, end]) } else { (Scanned::default(), at) };
        }
        whole.append(piece);
        at = stop;
    }
    whole
}

/// A place from `from` on that looks like the start of a statement: after a semicolon and white space, at a `#`.
fn guess_start(text: &[u8], from: usize) -> Option<usize> {
    let mut at = from;
    loop {
        at += text.get(at..)?.iter().position(|&b| b == b';')? + 1;
        let blank = text[at..].iter().take_while(|b| b.is_ascii_whitespace()).count();
        if text.get(at + blank) == Some(&b'#') {
            return Some(at + blank);
        }
    }
}

/// Scans the statements that start in `range`; also says where the last one ends, white space and comments behind it
/// included.
fn scan_piece(text: &[u8], [start, end]: [usize; 2]) -> (Scanned, usize) {
    let mut found = Scanned::default();
    let mut cursor = Cursor { text, at: start };
    if let Err(error) = cursor.blank() {
        found.error(error);
    }
    while cursor.at < end {
        let statement = cursor.at;
        let result = cursor.statement(&mut found).and_then(|()| cursor.blank());
        if let Err(error) = result {
            // An error behind a statement that was complete must not lose the reader's place.
            let from = if error.at > statement + RETRY_WITHIN { error.at } else { statement + 1 };
            cursor.at = next_statement(text, from.max(statement + 1));
            found.error(error);
        }
    }
    (found, cursor.at)
}

/// The next `#digits =` or section end from `from` on that opens a line or follows a semicolon.
fn next_statement(text: &[u8], from: usize) -> usize {
    let mut at = from;
    while let Some(step) = text.get(at..).and_then(|t| t.iter().position(|&b| matches!(b, b';' | b'\n' | b'\r'))) {
        at += step + 1;
        let rest = text[at..].trim_ascii_start();
        if opens_entity(rest) || rest.starts_with(b"ENDSEC") || rest.starts_with(b"END-ISO") {
            return text.len() - rest.len();
        }
        // White space was looked at; nothing in it opens a statement.
        at = at.max(text.len() - rest.len());
    }
    text.len()
}

fn opens_entity(text: &[u8]) -> bool {
    let Some(rest) = text.strip_prefix(b"#") else { return false };
    let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    digits > 0 && rest[digits..].trim_ascii_start().first() == Some(&b'=')
}

impl Cursor<'_> {
    /// Passes a statement, its semicolon included; notes the entity.
    fn statement(&mut self, found: &mut Scanned) -> Result<(), SyntaxError> {
        if self.peek() == Some(b'#') {
            let record = self.entity(&mut found.triples)?;
            found.elsewhere += usize::from(record.is_none());
            // The parameters are complete, whatever follows them.
            found.records.extend(record);
            self.blank()?;
        } else {
            found.ended |= self.text[self.at..].starts_with(b"END-ISO-10303-21");
            self.header_statement()?;
        }
        if self.peek() != Some(b';') {
            return self.error("expected a semicolon");
        }
        self.at += 1;
        Ok(())
    }

    /// Section keywords, entities of the header, anchors: all that ends with a semicolon.
    fn header_statement(&mut self) -> Result<(), SyntaxError> {
        let anchor = self.peek() == Some(b'<');
        if !anchor && !self.peek().is_some_and(|b| b.is_ascii_alphabetic()) {
            return self.error("expected an entity (#number = ...) or the end of the section");
        }
        while let Some(b) = self.peek() {
            match b {
                b';' => return Ok(()),
                b'\'' => self.string()?,
                b'/' => {
                    let before = self.at;
                    self.blank()?;
                    self.at += usize::from(self.at == before);
                }
                b'#' if !anchor => return self.error("expected a semicolon"),
                _ => self.at += 1,
            }
        }
        self.error("the file ends inside a statement")
    }

    /// `#12 = KEYWORD(...)` or `#12 = (A(...) B(...))`; nothing for a reference to another file.
    fn entity(&mut self, triples: &mut Vec<DVec3>) -> Result<Option<Record>, SyntaxError> {
        let start = self.at;
        let id = self.reference()?;
        self.blank()?;
        if self.peek() != Some(b'=') {
            return self.error("expected =");
        }
        self.at += 1;
        self.blank()?;
        let at = self.at;
        let kind = match self.peek() {
            Some(b'(') => Kind::Complex,
            Some(b'<') => {
                self.at += self.text[self.at..].iter().take_while(|&&b| b != b'>' && b != b';').count();
                self.at += usize::from(self.peek() == Some(b'>'));
                return Ok(None);
            }
            _ => Kind::of(self.keyword()?),
        };
        self.blank()?;
        let open = u16::try_from(self.at - at).unwrap_or(0);
        let mut triple = 0;
        match kind {
            Kind::Complex => self.complex()?,
            Kind::CartesianPoint | Kind::Direction => match self.triple() {
                Some(numbers) => {
                    triples.push(numbers);
                    triple = triples.len() as u32;
                }
                None => self.parameters()?,
            },
            _ => self.parameters()?,
        }
        let (Some(id), Ok(at)) = (id, u32::try_from(at)) else {
            return Err(SyntaxError { at: start, what: "an entity number above 4294967295" });
        };
        Ok(Some(Record { id, at, open, kind, triple }))
    }
}
