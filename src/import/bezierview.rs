//! BezierView `.bv` (SurfLab, University of Florida): segments that open with their kind, and `group N NAME` lines that
//! colour what follows.

use super::ParseError;
use super::bpt::{point_count, supported};
use super::patches::Patches;
use super::scan::{Scanner, Stop, whole};
use crate::geometry::triangle_to_tensor;
use crate::model::Model;

const POLYHEDRON: u32 = 1;
const TRIANGLE: u32 = 3;
const TENSOR_ONE_DEGREE: u32 = 4;
const TENSOR: u32 = 5;
const RATIONAL_TENSOR: u32 = 8;
const PN_TRIANGLE: u32 = 9;
const PN_QUAD: u32 = 10;

/// Kinds that are passed over, with a name for the warning.
const NOT_DRAWN: [(u32, &str); 3] = [
    (POLYHEDRON, "polyhedra (kind 1) are left out: they have no curved surface"),
    (PN_TRIANGLE, "triangles with normals of their own (kind 9) are left out: not read yet"),
    (PN_QUAD, "quads with normals of their own (kind 10) are left out: not read yet"),
];

/// Colours of the groups, linear RGB: hues that stay apart, of much the same lightness.
const PALETTE: [[f32; 3]; 10] = [
    [0.55, 0.38, 0.08],
    [0.10, 0.31, 0.60],
    [0.15, 0.45, 0.17],
    [0.58, 0.15, 0.12],
    [0.34, 0.20, 0.55],
    [0.06, 0.45, 0.45],
    [0.60, 0.23, 0.38],
    [0.40, 0.42, 0.07],
    [0.30, 0.30, 0.33],
    [0.62, 0.27, 0.05],
];

/// True for the numbers that open a segment.
pub(super) fn is_kind(number: u32) -> bool {
    matches!(number, TRIANGLE | TENSOR_ONE_DEGREE | TENSOR | RATIONAL_TENSOR)
        || NOT_DRAWN.iter().any(|&(kind, _)| kind == number)
}

/// True for kinds whose segments open as `.bpt` files do: a number, then a line of two, then points of three.
pub(super) fn opens_like_bpt(kind: u32) -> bool {
    matches!(kind, POLYHEDRON | TENSOR | PN_TRIANGLE)
}

/// True for files that open like this format.
pub(super) fn matches(bytes: &[u8]) -> bool {
    let mut scanner = Scanner::new(bytes);
    match scanner.peek() {
        Some(word) if word.eq_ignore_ascii_case(b"group") => true,
        Some(word) if whole(word).is_some_and(is_kind) => {
            let _ = scanner.word();
            scanner.peek().is_none_or(|w| whole(w).is_some())
        }
        _ => false,
    }
}

/// Reads a whole file. One that ends early gives the segments that are complete, and a warning.
pub(super) fn parse(bytes: &[u8], name: &str) -> Result<Model, ParseError> {
    let mut reader = Reader { scanner: Scanner::new(bytes), ..Reader::default() };
    while reader.scanner.peek().is_some() {
        if let Err(stop) = reader.segment() {
            reader.patches.stopped(stop)?;
            break;
        }
    }
    for ((_, what), (count, line)) in NOT_DRAWN.iter().zip(reader.not_drawn) {
        if count > 0 {
            reader.patches.warn(line, format!("{what} ({count} in the file, this is the first)"));
        }
    }
    reader.patches.into_model(name, reader.scanner.line())
}

#[derive(Default)]
struct Reader<'a> {
    scanner: Scanner<'a>,
    patches: Patches,
    group: String,
    color: Option<[f32; 3]>,
    /// For each of `NOT_DRAWN`: how many, and the line of the first.
    not_drawn: [(u64, usize); NOT_DRAWN.len()],
}

impl Reader<'_> {
    fn segment(&mut self) -> Result<(), Stop> {
        let scanner = &mut self.scanner;
        if scanner.peek().is_some_and(|w| w.eq_ignore_ascii_case(b"group")) {
            return self.group_line();
        }
        let line = scanner.line();
        let kind = scanner.count("a segment's kind or \"group\"")?;
        match kind {
            TRIANGLE => self.triangle(line),
            TENSOR_ONE_DEGREE => {
                let degree = scanner.count("a degree")?;
                self.tensor(line, [degree; 2], false)
            }
            TENSOR | RATIONAL_TENSOR => {
                let degree = [scanner.count("a degree")?, scanner.count("a degree")?];
                self.tensor(line, degree, kind == RATIONAL_TENSOR)
            }
            _ => self.pass_over(line, kind),
        }
    }

    fn group_line(&mut self) -> Result<(), Stop> {
        self.scanner.word()?;
        let number = self.scanner.count("a group's number")?;
        self.group = String::from_utf8_lossy(self.scanner.rest_of_line()).into_owned();
        self.color = Some(PALETTE[number as usize % PALETTE.len()]);
        Ok(())
    }

    fn tensor(&mut self, line: usize, degree: [u32; 2], rational: bool) -> Result<(), Stop> {
        let count = point_count(degree);
        let points = if supported(degree) {
            self.scanner.points(count, rational)?
        } else {
            self.scanner.skip_numbers(count * if rational { 4 } else { 3 })?;
            Vec::new()
        };
        self.patches.add(line, degree.map(|d| d as usize), points, &self.group, self.color);
        Ok(())
    }

    fn triangle(&mut self, line: usize) -> Result<(), Stop> {
        let degree = self.scanner.count("a degree")?;
        let count = triangle_count(degree);
        let points = if supported([degree; 2]) {
            triangle_to_tensor(degree as usize, &self.scanner.points(count, false)?)
        } else {
            self.scanner.skip_numbers(3 * count)?;
            Vec::new()
        };
        self.patches.add(line, [degree as usize; 2], points, &self.group, self.color);
        Ok(())
    }

    /// Reads past a segment that is not drawn, and counts it.
    fn pass_over(&mut self, line: usize, kind: u32) -> Result<(), Stop> {
        let Some(index) = NOT_DRAWN.iter().position(|&(k, _)| k == kind) else {
            return Err(Stop::Bad { line, what: format!("there is no kind {kind} of segment") });
        };
        let scanner = &mut self.scanner;
        match kind {
            POLYHEDRON => {
                let [vertices, faces] = [scanner.count("a number of vertices")?, scanner.count("a number of faces")?];
                scanner.skip_numbers(3 * u64::from(vertices))?;
                for _ in 0..faces {
                    let corners = scanner.count("a number of corners")?;
                    scanner.skip_numbers(u64::from(corners))?;
                }
            }
            PN_TRIANGLE => {
                let [points, normals] = [scanner.count("a degree")?, scanner.count("a degree")?].map(triangle_count);
                scanner.skip_numbers(3 * (points + normals))?;
            }
            _ => {
                let mut degree = || scanner.count("a degree");
                let [points, normals] = [[degree()?, degree()?], [degree()?, degree()?]].map(point_count);
                scanner.skip_numbers(3 * (points + normals))?;
            }
        }
        let (count, first) = &mut self.not_drawn[index];
        if *count == 0 {
            *first = line;
        }
        *count += 1;
        Ok(())
    }
}

/// Control points of a triangular patch, or 2^60, as for `point_count`.
fn triangle_count(degree: u32) -> u64 {
    let d = u64::from(degree);
    ((d + 1).saturating_mul(d + 2) / 2).min(1 << 60)
}
