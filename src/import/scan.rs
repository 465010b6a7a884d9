//! Numbers and words of a text file, with line numbers; one pass over the bytes, no copies.

use glam::DVec4;

/// Why a scanner could not give what was asked for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Stop {
    /// The data ended.
    End { line: usize },
    /// Something else stands there.
    Bad { line: usize, what: String },
}

/// A position in a text. Words are separated by white space; lines end with LF, CR LF or CR and count from 1.
#[derive(Clone, Default)]
pub(super) struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Scanner<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        Self { bytes, at: 0, line: 1 }
    }

    /// Line of the next word, once `word` or `peek` has found one; else of the end.
    pub fn line(&self) -> usize {
        self.line
    }

    /// True where the last word was read and nothing, not even a line break, follows it.
    pub fn ended_in_word(&self) -> bool {
        self.at == self.bytes.len() && self.bytes.last().is_some_and(|b| !b.is_ascii_whitespace())
    }

    /// Largest number of words that can follow.
    fn words_left(&self) -> usize {
        (self.bytes.len() - self.at).div_ceil(2)
    }

    fn skip_white(&mut self) {
        while let Some(&b) = self.bytes.get(self.at) {
            if b == b'\n' || (b == b'\r' && self.bytes.get(self.at + 1) != Some(&b'\n')) {
                self.line += 1;
            } else if !b.is_ascii_whitespace() {
                break;
            }
            self.at += 1;
        }
    }

    /// The next word; the scanner stays before it.
    pub fn peek(&mut self) -> Option<&'a [u8]> {
        self.skip_white();
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        (length > 0).then(|| &rest[..length])
    }

    /// The next word.
    pub fn word(&mut self) -> Result<&'a [u8], Stop> {
        let word = self.peek().ok_or(Stop::End { line: self.line })?;
        self.at += word.len();
        Ok(word)
    }

    /// What is left of the current line, without white space around it; the scanner goes to its end.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        self.at += length;
        rest[..length].trim_ascii()
    }

    /// A finite number.
    pub fn number(&mut self) -> Result<f64, Stop> {
        let word = self.word()?;
        let number = std::str::from_utf8(word).ok().and_then(|w| w.parse::<f64>().ok());
        number.filter(|n| n.is_finite()).ok_or_else(|| self.unexpected("a finite number", word))
    }

    /// A whole number of at most 32 bits.
    pub fn count(&mut self, what: &str) -> Result<u32, Stop> {
        let word = self.word()?;
        whole(word).ok_or_else(|| self.unexpected(what, word))
    }

    /// `count` points of three coordinates, or of four that are homogeneous already. Memory grows with the data that
    /// is there, whatever the count says.
    pub fn points(&mut self, count: u64, homogeneous: bool) -> Result<Vec<DVec4>, Stop> {
        let possible = self.words_left() / if homogeneous { 4 } else { 3 };
        let mut points = Vec::with_capacity(usize::try_from(count).unwrap_or(usize::MAX).min(possible));
        for _ in 0..count {
            let [x, y, z] = [self.number()?, self.number()?, self.number()?];
            let w = if homogeneous { self.number()? } else { 1.0 };
            points.push(DVec4::new(x, y, z, w));
        }
        Ok(points)
    }

    /// Passes over `count` numbers.
    pub fn skip_numbers(&mut self, count: u64) -> Result<(), Stop> {
        for _ in 0..count {
            self.number()?;
        }
        Ok(())
    }

    fn unexpected(&self, expected: &str, word: &[u8]) -> Stop {
        let shown: String = String::from_utf8_lossy(word).chars().take(24).flat_map(char::escape_debug).collect();
        Stop::Bad { line: self.line, what: format!("expected {expected}, found \"{shown}\"") }
    }
}

/// A word that is a whole number of at most 32 bits.
pub(super) fn whole(word: &[u8]) -> Option<u32> {
    std::str::from_utf8(word).ok()?.parse().ok()
}
