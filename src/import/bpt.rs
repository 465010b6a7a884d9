//! `.bpt`: the number of patches, then for each a line with its two degrees and its control points, one a line, u
//! outermost.

use super::patches::Patches;
use super::scan::{Scanner, Stop, whole};
use super::{ParseError, bezierview};
use crate::geometry::MAX_DEGREE;
use crate::model::Model;

/// True for files that open like this format.
pub(super) fn matches(bytes: &[u8]) -> bool {
    let mut scanner = Scanner::new(bytes);
    let Some(count) = scanner.peek().and_then(whole) else { return false };
    if !bezierview::is_kind(count) {
        return scanner.word().is_ok() && scanner.peek().is_none_or(|w| whole(w).is_some());
    }
    // A BezierView file may open with the same numbers; most of its kinds put other counts of them on a line.
    let widths = [1, 2, 3].map(|width| (line_of_words(&mut scanner).len(), width));
    let alike = widths.iter().all(|(found, width)| found == width);
    alike && (!bezierview::opens_like_bpt(count) || first_patch_fits(Scanner::new(bytes), count).unwrap_or(false))
}

/// What follows the first patch tells the rest apart: here a line of two whole numbers, or the end if one patch was
/// declared.
fn first_patch_fits(mut scanner: Scanner, count: u32) -> Result<bool, Stop> {
    scanner.word()?;
    let degree = [scanner.count("")?, scanner.count("")?];
    scanner.skip_numbers(3 * point_count(degree))?;
    if !scanner.rest_of_line().is_empty() {
        return Ok(false);
    }
    if scanner.peek().is_none() {
        return Ok(count == 1);
    }
    let words = line_of_words(&mut scanner);
    Ok(words.len() == 2 && words.into_iter().all(|w| whole(w).is_some()))
}

/// The words of the next line that is not blank.
fn line_of_words<'a>(scanner: &mut Scanner<'a>) -> Vec<&'a [u8]> {
    scanner.peek();
    scanner.rest_of_line().split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).collect()
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

/// Control points of a tensor-product patch, or 2^60, more than any file holds, where the degrees ask for more still:
/// a few times that does not overflow.
pub(super) fn point_count(degree: [u32; 2]) -> u64 {
    let [u, v] = degree.map(|d| u64::from(d) + 1);
    u.saturating_mul(v).min(1 << 60)
}
