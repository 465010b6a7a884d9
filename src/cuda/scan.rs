//! Exclusive prefix sums on a device: `kernels/scan.cu`.

use super::session::Session;
use super::{Buffer, Gpu, GpuError, Shape};

/// Threads a block, and numbers a block sums.
const THREADS: u32 = 256;
const TILE: usize = 2048;

/// What comes before each number, modulo 2^32, and the sum of all.
pub(crate) fn scan<G: Gpu>(session: &mut Session<G>, numbers: &Buffer<u32>) -> Result<(Buffer<u32>, u64), GpuError> {
    let before = session.allocate::<u32>(numbers.len())?;
    if numbers.is_empty() {
        return Ok((before, 0));
    }
    let (count, tiles) = (numbers.len() as u32, numbers.len().div_ceil(TILE));
    let sums = session.allocate::<u64>(tiles)?;
    let total = session.allocate::<u64>(1)?;
    let (out, sums) = (before.pointer(), sums.pointer());
    let total = session.group("scan", |session| {
        session.launch("scan_tiles", Shape::row(tiles as u32, THREADS), &[&numbers.pointer(), &out, &sums, &count])?;
        session.launch("scan_sums", Shape::row(1, THREADS), &[&sums, &(tiles as u32), &total.pointer()])?;
        session.launch("scan_add", Shape::of(numbers.len(), THREADS), &[&out, &sums, &count])?;
        session.download(&total)
    })?;
    Ok((before, total.first().copied().unwrap_or(0)))
}
