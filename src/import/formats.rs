//! The formats, each with how its content is recognised and how it is read.

use super::{Origin, ParseError, bezierview, bpt, step};
use crate::model::Model;

type Reader = fn(&[u8], &Origin) -> Result<Model, ParseError>;

/// One file format.
#[derive(Clone, Copy)]
pub(super) struct Format {
    pub name: &'static str,
    matches: fn(&[u8]) -> bool,
    /// From bytes; `None`: recognised, not read yet.
    pub read: Option<Reader>,
}

/// Asked in this order; the ones that say clearly what they are come first.
const FORMATS: [Format; 11] = [
    Format { name: "STEP", matches: step::matches, read: Some(step::parse) },
    Format { name: "Rhino 3DM", matches: |b| opens_with(b, b"3D Geometry File Format"), read: None },
    Format { name: "T-splines TSM", matches: |b| opens_with(b, b"#TS"), read: None },
    Format { name: "X3D or VRML", matches: |b| opens_with(b, b"#X3D") || opens_with(b, b"#VRML"), read: None },
    Format { name: "XML", matches: |b| opens_with(b, b"<?xml") || opens_with(b, b"<X3D"), read: None },
    Format { name: "Open CASCADE BREP", matches: |b| opens_with(b, b"DBRep_DrawableShape"), read: None },
    Format { name: "IGES", matches: is_iges, read: None },
    Format { name: "Wavefront OBJ", matches: is_obj, read: None },
    Format { name: "STL", matches: |b| opens_with(b, b"solid "), read: None },
    Format { name: ".bpt", matches: bpt::matches, read: Some(|bytes, from| bpt::parse(bytes, &from.name)) },
    Format {
        name: "BezierView .bv",
        matches: bezierview::matches,
        read: Some(|bytes, from| bezierview::parse(bytes, &from.name)),
    },
];

/// The format of a file's content.
pub(super) fn recognize(bytes: &[u8]) -> Option<Format> {
    FORMATS.into_iter().find(|f| (f.matches)(bytes))
}

/// The names of what can be read, for messages.
pub(super) fn readable() -> String {
    let names: Vec<_> = FORMATS.iter().filter(|f| f.read.is_some()).map(|f| f.name).collect();
    names.join(", ")
}

/// White space and a byte order mark may come before.
fn opens_with(bytes: &[u8], magic: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes.trim_ascii_start().starts_with(magic)
}

/// Records of 80 columns: the first has an S (or C, compressed) in column 73, then its number, 1.
fn is_iges(bytes: &[u8]) -> bool {
    let line = bytes.split(|b| matches!(b, b'\n' | b'\r')).next().unwrap_or_default();
    let columns = line.get(72..80.min(line.len())).and_then(|c| std::str::from_utf8(c).ok());
    let number = columns.and_then(|c| c.strip_prefix(['S', 'C']));
    number.is_some_and(|n| n.trim().parse() == Ok(1))
}

/// The first line that is no comment holds one of OBJ's keywords.
fn is_obj(bytes: &[u8]) -> bool {
    const KEYWORDS: [&[u8]; 12] =
        [b"v", b"vn", b"vt", b"vp", b"f", b"o", b"g", b"s", b"mtllib", b"usemtl", b"cstype", b"deg"];
    let lines = bytes.split(|b| matches!(b, b'\n' | b'\r')).map(<[u8]>::trim_ascii);
    let first = lines.take(1000).find(|l| !l.is_empty() && !l.starts_with(b"#"));
    let word = first.and_then(|l| l.split(u8::is_ascii_whitespace).next());
    word.is_some_and(|w| KEYWORDS.contains(&w))
}
