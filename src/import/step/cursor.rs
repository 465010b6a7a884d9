//! A place in the text of a Part 21 file (ISO 10303-21:2016, clause 6), and the tokens that stand there.

use super::number::real;
use super::scan::SyntaxError;
use glam::DVec3;

/// What a byte may be part of.
const DIGIT: u8 = 1;
const NUMBER: u8 = 2;
const NAME: u8 = 4;

static CLASSES: [u8; 256] = classes();

const fn classes() -> [u8; 256] {
    let mut classes = [0; 256];
    let mut k = 0;
    while k < 256 {
        let b = k as u8;
        if b.is_ascii_digit() {
            classes[k] |= DIGIT;
        }
        if matches!(b, b'0'..=b'9' | b'+' | b'-' | b'.' | b'E' | b'e' | b'D' | b'd') {
            classes[k] |= NUMBER;
        }
        if b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-') {
            classes[k] |= NAME;
        }
        k += 1;
    }
    classes
}

/// How many bytes of one class `text` opens with.
fn run(text: &[u8], class: u8) -> usize {
    text.iter().take_while(|&&b| CLASSES[usize::from(b)] & class != 0).count()
}

/// Length of what is written like a number.
pub(super) fn number_length(text: &[u8]) -> usize {
    run(text, NUMBER)
}

/// A place in the text.
#[derive(Clone, Copy)]
pub(super) struct Cursor<'a> {
    pub text: &'a [u8],
    pub at: usize,
}

impl<'a> Cursor<'a> {
    pub fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    /// What is left of the text.
    fn rest(&self) -> &'a [u8] {
        self.text.get(self.at..).unwrap_or_default()
    }

    pub fn error<T>(&self, what: &'static str) -> Result<T, SyntaxError> {
        Err(SyntaxError { at: self.at, what })
    }

    /// Passes white space and comments. Control characters count as white space, as readers everywhere do.
    #[inline]
    pub fn blank(&mut self) -> Result<(), SyntaxError> {
        match self.peek() {
            Some(b) if b <= b' ' || b == b'/' => self.some_blank(),
            _ => Ok(()),
        }
    }

    fn some_blank(&mut self) -> Result<(), SyntaxError> {
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

    /// `#12`; `None` where the number does not fit.
    pub fn reference(&mut self) -> Result<Option<u32>, SyntaxError> {
        self.at += 1;
        let start = self.at;
        let mut value = 0u64;
        while let Some(b @ b'0'..=b'9') = self.peek() {
            // Too large stays too large.
            value = (value * 10 + u64::from(b - b'0')).min(1 << 32);
            self.at += 1;
        }
        if self.at == start { self.error("expected an entity number") } else { Ok(u32::try_from(value).ok()) }
    }

    pub fn keyword(&mut self) -> Result<&'a [u8], SyntaxError> {
        let start = self.at;
        self.at += usize::from(self.peek() == Some(b'!'));
        self.at += run(self.rest(), NAME);
        if self.text[start..self.at].first().is_none_or(u8::is_ascii_digit) {
            return self.error("expected a keyword");
        }
        Ok(&self.text[start..self.at])
    }

    /// `(A(...) B(...))`
    pub fn complex(&mut self) -> Result<(), SyntaxError> {
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
    pub fn parameters(&mut self) -> Result<(), SyntaxError> {
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
        let length = number_length(self.rest());
        if !self.rest()[..length].iter().any(u8::is_ascii_digit) {
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

    /// `('name', (x, y, z))` with one to three finite numbers, the rest being 0: how points and directions are written as
    /// a rule. The cursor is behind it then; `None`, and the cursor where it was, for anything else.
    pub fn triple(&mut self) -> Option<DVec3> {
        let mut ahead = *self;
        ahead.take(b'(')?;
        ahead.blank().ok()?;
        match ahead.peek()? {
            b'\'' => ahead.string().ok()?,
            b'$' | b'*' => ahead.at += 1,
            _ => return None,
        }
        ahead.take(b',')?;
        ahead.take(b'(')?;
        let mut triple = [0.0; 3];
        for value in &mut triple {
            ahead.blank().ok()?;
            let length = number_length(ahead.rest());
            *value = real(&ahead.rest()[..length])?;
            ahead.at += length;
            if ahead.take(b',').is_none() {
                break;
            }
        }
        ahead.take(b')')?;
        ahead.take(b')')?;
        *self = ahead;
        Some(triple.into())
    }

    /// Passes a symbol, where it comes next.
    fn take(&mut self, symbol: u8) -> Option<()> {
        self.blank().ok()?;
        (self.peek() == Some(symbol)).then(|| self.at += 1)
    }
}
