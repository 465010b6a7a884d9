//! Parameters of an entity, read from the text one after the other. The text was checked by the scanner; what still
//! doesn't fit is an error, never a panic.

use super::cursor::{Cursor, number_length};
use super::error::StepError;
use super::number::real;

/// A list of parameters, from the first that has not been taken.
#[derive(Clone)]
pub(super) struct Args<'a> {
    text: &'a [u8],
    /// Behind the opening parenthesis or a comma.
    at: usize,
    /// Number of the next parameter, from 1, and the entity: for messages.
    index: usize,
    entity: u32,
}

/// One parameter.
pub(super) enum Value<'a> {
    /// `$` or `*`
    Absent,
    Reference(u32),
    Number(&'a [u8]),
    /// Without its dots.
    Enumeration(&'a [u8]),
    /// Without its quotes, as the file has it.
    Text(&'a [u8]),
    List(Args<'a>),
    /// `KEYWORD(...)`
    Typed(Args<'a>),
    Binary,
}

impl<'a> Args<'a> {
    /// The list whose parenthesis is at `at`.
    pub fn inside(text: &'a [u8], at: usize, entity: u32) -> Self {
        Self { text, at: at + 1, index: 1, entity }
    }

    /// The list that opens at or behind `at` with a parenthesis.
    pub fn open(text: &'a [u8], at: usize, entity: u32) -> Option<Self> {
        let mut cursor = Cursor { text, at };
        cursor.blank().ok()?;
        (cursor.peek() == Some(b'(')).then(|| Self::inside(text, cursor.at, entity))
    }

    /// Offset behind this list, of which nothing has been taken.
    pub fn end(&self) -> usize {
        list_end(self.text, self.at - 1).unwrap_or(self.text.len())
    }

    fn bad<T>(&self, expected: &'static str) -> Result<T, StepError> {
        Err(StepError::Parameter { entity: self.entity, index: self.index.saturating_sub(1), expected })
    }

    pub fn skip(mut self, count: usize) -> Self {
        for _ in 0..count {
            self.next();
        }
        self
    }

    pub fn number(&mut self) -> Result<f64, StepError> {
        let number = self.next().and_then(number_of);
        number.map_or_else(|| self.bad("a finite number"), Ok)
    }

    /// `None` for `$` and where the list has ended.
    pub fn optional_number(&mut self) -> Result<Option<f64>, StepError> {
        match self.next() {
            None | Some(Value::Absent) => Ok(None),
            Some(value) => number_of(value).map_or_else(|| self.bad("a finite number"), |number| Ok(Some(number))),
        }
    }

    /// A whole number from 0 on.
    pub fn whole(&mut self) -> Result<usize, StepError> {
        let number = self.number()?;
        if number >= 0.0 && number.fract() == 0.0 && number < 1e9 {
            Ok(number as usize)
        } else {
            self.bad("a whole number")
        }
    }

    pub fn reference(&mut self) -> Result<u32, StepError> {
        match self.next() {
            Some(Value::Reference(id)) => Ok(id),
            _ => self.bad("a reference"),
        }
    }

    /// `None` for anything else.
    pub fn optional_reference(&mut self) -> Option<u32> {
        match self.next() {
            Some(Value::Reference(id)) => Some(id),
            _ => None,
        }
    }

    pub fn list(&mut self) -> Result<Args<'a>, StepError> {
        match self.next() {
            Some(Value::List(list)) => Ok(list),
            _ => self.bad("a list"),
        }
    }

    pub fn references(&mut self) -> Result<Vec<u32>, StepError> {
        let reference = |value| if let Value::Reference(id) = value { Some(id) } else { None };
        self.listed(reference)?.map_or_else(|| self.bad("a list of references"), Ok)
    }

    pub fn numbers(&mut self) -> Result<Vec<f64>, StepError> {
        self.listed(number_of)?.map_or_else(|| self.bad("a finite number"), Ok)
    }

    /// What `take` makes of all values of the list that comes next; `None` where it makes nothing of one. Unlike
    /// [`Args::list`] it passes over the list's text only once.
    fn listed<T>(&mut self, take: impl Fn(Value<'a>) -> Option<T>) -> Result<Option<Vec<T>>, StepError> {
        let mut cursor = Cursor { text: self.text, at: self.at };
        let is_list = cursor.blank().is_ok() && cursor.peek() == Some(b'(');
        let mut list = Self::inside(self.text, cursor.at, self.entity);
        let mut values = Vec::new();
        let complete = is_list
            && loop {
                match list.next().map(&take) {
                    Some(Some(value)) => values.push(value),
                    Some(None) => break false,
                    None => break self.text.get(list.at) == Some(&b')'),
                }
            };
        if !complete {
            self.next();
            return if is_list { Ok(None) } else { self.bad("a list") };
        }
        self.index += 1;
        self.at = list.at + 1;
        self.pass_comma();
        Ok(Some(values))
    }

    fn pass_comma(&mut self) -> Option<()> {
        let mut cursor = Cursor { text: self.text, at: self.at };
        cursor.blank().ok()?;
        // A comma leads to the next value; the closing parenthesis stays for the next call.
        self.at = cursor.at + usize::from(cursor.peek() == Some(b','));
        Some(())
    }

    /// `.T.` or `.F.`
    pub fn flag(&mut self) -> Result<bool, StepError> {
        match self.next() {
            Some(Value::Enumeration(b"T" | b"t" | b"TRUE")) => Ok(true),
            Some(Value::Enumeration(b"F" | b"f" | b"FALSE")) => Ok(false),
            _ => self.bad(".T. or .F."),
        }
    }

    /// An enumeration's name; empty where there is none.
    pub fn enumeration(&mut self) -> &'a [u8] {
        match self.next() {
            Some(Value::Enumeration(name)) => name,
            _ => b"",
        }
    }

    /// A decoded string; empty where there is none.
    pub fn text(&mut self) -> String {
        match self.next() {
            Some(Value::Text(raw)) => super::text::decode(raw),
            _ => String::new(),
        }
    }
}

impl<'a> Iterator for Args<'a> {
    type Item = Value<'a>;

    fn next(&mut self) -> Option<Value<'a>> {
        let mut cursor = Cursor { text: self.text, at: self.at };
        cursor.blank().ok()?;
        self.index += 1;
        let start = cursor.at;
        let inner = |at| Args { text: self.text, at, index: 1, entity: self.entity };
        let value = match cursor.peek()? {
            b')' => {
                self.at = start;
                return None;
            }
            b'$' | b'*' => {
                cursor.at += 1;
                Value::Absent
            }
            b'#' => Value::Reference(cursor.reference().ok()??),
            b'\'' => {
                cursor.string().ok()?;
                Value::Text(self.text.get(start + 1..cursor.at - 1)?)
            }
            b'(' => {
                cursor.at = list_end(self.text, start)?;
                Value::List(inner(start + 1))
            }
            b'.' if !self.text.get(start + 1)?.is_ascii_digit() => {
                let length = self.text[start + 1..].iter().position(|&b| b == b'.')?;
                cursor.at = start + length + 2;
                Value::Enumeration(&self.text[start + 1..start + 1 + length])
            }
            b'"' => {
                cursor.at = start + 2 + self.text[start + 1..].iter().position(|&b| b == b'"')?;
                Value::Binary
            }
            b'0'..=b'9' | b'+' | b'-' | b'.' => {
                cursor.at += number_length(&self.text[start..]);
                Value::Number(&self.text[start..cursor.at])
            }
            _ => {
                cursor.keyword().ok()?;
                cursor.blank().ok()?;
                let open = cursor.at;
                cursor.at = list_end(self.text, open)?;
                Value::Typed(inner(open + 1))
            }
        };
        self.at = cursor.at;
        self.pass_comma()?;
        Some(value)
    }
}

/// Offset behind the list that opens at `open`.
fn list_end(text: &[u8], open: usize) -> Option<usize> {
    let mut cursor = Cursor { text, at: open };
    let mut depth = 0usize;
    loop {
        match cursor.peek()? {
            b'(' => depth += 1,
            b')' if depth <= 1 => return Some(cursor.at + 1),
            b')' => depth -= 1,
            b'\'' => {
                cursor.string().ok()?;
                continue;
            }
            b'/' => {
                cursor.blank().ok()?;
                continue;
            }
            _ => {}
        }
        cursor.at += 1;
    }
}

/// A finite number, bare or as a typed value such as `LENGTH_MEASURE(25.4)`.
fn number_of(value: Value) -> Option<f64> {
    match value {
        Value::Number(text) => real(text),
        Value::Typed(mut inner) => match inner.next()? {
            Value::Number(text) => real(text),
            _ => None,
        },
        _ => None,
    }
}
