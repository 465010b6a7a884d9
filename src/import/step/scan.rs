//! The statements of a Part 21 file (ISO 10303-21:2016, clause 5): where each entity stands, its number and its keyword.
//!
//! One pass checks the syntax and keeps 12 bytes an entity; parameters are read from the text when they are asked for.
//! The text is cut at guessed statement ends and the pieces are scanned in parallel. A guess inside a string or a comment
//! shows when the piece before doesn't end there, and is then scanned again from the right place.

use super::kinds::Kind;
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
    pub kind: Kind,
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
        self.records.append(&mut other.records);
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

/// A place in the text.
pub(super) struct Cursor<'a> {
    pub text: &'a [u8],
    pub at: usize,
}

impl<'a> Cursor<'a> {
    pub fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    fn error<T>(&self, what: &'static str) -> Result<T, SyntaxError> {
        Err(SyntaxError { at: self.at, what })
    }

    /// Passes white space and comments. Control characters count as white space, as readers everywhere do.
    pub fn blank(&mut self) -> Result<(), SyntaxError> {
        while let Some(b) = self.peek() {
            if b <= b' ' {
                self.at += 1;
            } else if b == b'/' && self.text.get(self.at + 1) == Some(&b'*') {
                let start = self.at;
                let inside = &self.text[start + 2..];
                let Some(length) = inside.windows(2).position(|w| w == b"*/") else {
                    return Err(SyntaxError { at: start, what: "a comment that is not closed" });
                };
                self.at = start + length + 4;
            } else {
                break;
            }
        }
        Ok(())
    }

    /// Passes a statement, its semicolon included; notes the entity.
    fn statement(&mut self, found: &mut Scanned) -> Result<(), SyntaxError> {
        if self.peek() == Some(b'#') {
            let record = self.entity()?;
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
    fn entity(&mut self) -> Result<Option<Record>, SyntaxError> {
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
        if kind == Kind::Complex {
            self.complex()?
        } else {
            self.parameters()?
        }
        let (Some(id), Ok(at)) = (id, u32::try_from(at)) else {
            return Err(SyntaxError { at: start, what: "an entity number above 4294967295" });
        };
        Ok(Some(Record { id, at, kind }))
    }

    /// `#12`; `None` where the number does not fit.
    pub fn reference(&mut self) -> Result<Option<u32>, SyntaxError> {
        self.at += 1;
        let digits = self.text[self.at..].iter().take_while(|b| b.is_ascii_digit()).count();
        if digits == 0 {
            return self.error("expected an entity number");
        }
        let value = self.text[self.at..self.at + digits]
            .iter()
            .try_fold(0u32, |n, &b| n.checked_mul(10)?.checked_add(u32::from(b - b'0')));
        self.at += digits;
        Ok(value)
    }

    pub fn keyword(&mut self) -> Result<&'a [u8], SyntaxError> {
        let start = self.at;
        self.at += usize::from(self.peek() == Some(b'!'));
        let name = |b: &&u8| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-');
        self.at += self.text[self.at..].iter().take_while(name).count();
        if self.text[start..self.at].first().is_none_or(u8::is_ascii_digit) {
            return self.error("expected a keyword");
        }
        Ok(&self.text[start..self.at])
    }

    /// `(A(...) B(...))`
    fn complex(&mut self) -> Result<(), SyntaxError> {
        self.at += 1;
        loop {
            self.blank()?;
            if self.peek() == Some(b')') {
                self.at += 1;
                return Ok(());
            }
            self.keyword()?;
            self.blank()?;
            self.parameters()?;
        }
    }

    /// A parameter list with all that is nested in it, without recursion.
    fn parameters(&mut self) -> Result<(), SyntaxError> {
        if self.peek() != Some(b'(') {
            return self.error("expected a parenthesis");
        }
        self.at += 1;
        let mut depth = 1usize;
        let mut first = true;
        loop {
            self.blank()?;
            if !(first && self.peek() == Some(b')')) && self.value()? {
                depth += 1;
                first = true;
                continue;
            }
            first = false;
            // Behind a value: lists end here, or the next value comes.
            loop {
                self.blank()?;
                match self.peek() {
                    Some(b')') => {
                        self.at += 1;
                        depth -= 1;
                        if depth == 0 {
                            return Ok(());
                        }
                    }
                    Some(b',') => {
                        self.at += 1;
                        break;
                    }
                    None => return self.error("the file ends inside an entity"),
                    _ => return self.error("expected a comma or a closing parenthesis"),
                }
            }
        }
    }

    /// Passes one value; true where it opens a list, and the cursor is then inside.
    fn value(&mut self) -> Result<bool, SyntaxError> {
        match self.peek() {
            Some(b'#') => self.reference().map(|_| false),
            Some(b'\'') => self.string().map(|()| false),
            Some(b'$' | b'*') => self.pass(1),
            Some(b'(') => {
                self.at += 1;
                Ok(true)
            }
            Some(b'0'..=b'9' | b'+' | b'-') => self.number(),
            Some(b'.') if self.text.get(self.at + 1).is_some_and(u8::is_ascii_digit) => self.number(),
            Some(b'.') => {
                let name = self.text[self.at + 1..].iter().take_while(|b| b.is_ascii_alphanumeric() || **b == b'_');
                let length = name.count();
                if length == 0 || self.text.get(self.at + 1 + length) != Some(&b'.') {
                    return self.error("expected an enumeration value");
                }
                self.pass(length + 2)
            }
            Some(b'"') => {
                let length = self.text[self.at + 1..].iter().take_while(|b| b.is_ascii_hexdigit()).count();
                if self.text.get(self.at + 1 + length) != Some(&b'"') {
                    return self.error("a binary value that is not closed");
                }
                self.pass(length + 2)
            }
            Some(b'A'..=b'Z' | b'a'..=b'z' | b'!' | b'_') => {
                self.keyword()?;
                self.blank()?;
                if self.peek() != Some(b'(') {
                    return self.error("expected a parenthesis");
                }
                self.at += 1;
                Ok(true)
            }
            None => self.error("the file ends inside an entity"),
            _ => self.error("expected a value"),
        }
    }

    fn pass(&mut self, length: usize) -> Result<bool, SyntaxError> {
        self.at += length;
        Ok(false)
    }

    fn number(&mut self) -> Result<bool, SyntaxError> {
        let length = number_length(&self.text[self.at..]);
        if !self.text[self.at..self.at + length].iter().any(u8::is_ascii_digit) {
            return self.error("expected a number");
        }
        self.pass(length)
    }

    /// `'...'`, where `''` stands for a quote.
    pub fn string(&mut self) -> Result<(), SyntaxError> {
        let start = self.at;
        let mut at = start + 1;
        while let Some(length) = self.text.get(at..).and_then(|t| t.iter().position(|&b| b == b'\'')) {
            at += length + 1;
            if self.text.get(at) != Some(&b'\'') {
                self.at = at;
                return Ok(());
            }
            at += 1;
        }
        Err(SyntaxError { at: start, what: "a string that is not closed" })
    }
}

/// Length of what is written like a number.
pub(super) fn number_length(text: &[u8]) -> usize {
    let part = |b: &&u8| matches!(b, b'0'..=b'9' | b'+' | b'-' | b'.' | b'E' | b'e' | b'D' | b'd');
    text.iter().take_while(part).count()
}
