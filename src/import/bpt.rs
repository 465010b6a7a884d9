//! `.bpt`: the number of patches, then for each a line with its two degrees and its control points, one a line, u
//! outermost.

use super::patches::Patches;
use super::scan::{Scanner, Stop, whole};
use super::{ParseError, bezierview};
use crate::geometry::MAX_DEGREE;
use crate::model::Model;

/// True for files that open like this format.
pub(super) fn matches(bytes: &[u8]) -> bool {
    opening(Scanner::new(bytes)).unwrap_or(false)
}

/// A BezierView file may open with the same numbers. What follows the first patch tells them apart: here a line of two
/// whole numbers, or the end if one patch was declared.
fn opening(mut scanner: Scanner) -> Option<bool> {
    let count = scanner.peek().and_then(whole)?;
    scanner.word().ok()?;
    if !bezierview::is_kind(count) {
        return Some(scanner.peek().is_none_or(|w| whole(w).is_some()));
    }
    let degree = [scanner.count("").ok()?, scanner.count("").ok()?];
    scanner.skip_numbers(3 * point_count(degree)).ok()?;
    if !scanner.rest_of_line().is_empty() {
        return Some(false);
    }
    if scanner.peek().is_none() {
        return Some(count == 1);
    }
    let line = scanner.rest_of_line();
    let words: Vec<_> = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).collect();
    Some(words.len() == 2 && words.into_iter().all(|w| whole(w).is_some()))
}

/// Reads a whole file. One that ends early gives the patches that are complete, and a warning.
pub(super) fn parse(bytes: &[u8], name: &str) -> Result<Model, ParseError> {
    let mut scanner = Scanner::new(bytes);
    let declared = scanner.count("the number of patches").map_err(ParseError::from)?;
    let mut patches = Patches::default();
    while patches.met() < declared {
        if let Err(stop) = patch(&mut scanner, &mut patches, declared) {
            patches.stopped(stop)?;
            break;
        }
    }
    if patches.met() == declared && scanner.peek().is_some() {
        let line = scanner.line();
        patches.warn(line, format!("more data follows the {declared} patches that were declared; it is not read"));
    }
    patches.into_model(name, scanner.line())
}

fn patch(scanner: &mut Scanner, patches: &mut Patches, declared: u32) -> Result<(), Stop> {
    scanner.peek();
    let line = scanner.line();
    let degree = [scanner.count("a patch's degree")?, scanner.count("a patch's degree")?];
    let count = point_count(degree);
    let points = if supported(degree) {
        scanner.points(count, false)?
    } else {
        scanner.skip_numbers(3 * count)?;
        Vec::new()
    };
    // The last number of a file that was cut may have lost digits.
    if scanner.ended_in_word() && patches.met() + 1 < declared {
        return Err(Stop::End { line: scanner.line() });
    }
    patches.add(line, degree.map(|d| d as usize), points, "", None);
    Ok(())
}

/// True for degrees that patches can have here; the points of others are passed over, not kept.
pub(super) fn supported(degree: [u32; 2]) -> bool {
    degree.iter().all(|&d| (1..=MAX_DEGREE as u32).contains(&d))
}

/// Control points of a tensor-product patch; stays far from overflow, three times over too, because no file holds more
/// than 2^60 bytes: the count saturates there.
pub(super) fn point_count(degree: [u32; 2]) -> u64 {
    ((u64::from(degree[0]) + 1) * (u64::from(degree[1]) + 1)).min(1 << 60)
}
