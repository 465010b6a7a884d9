//! Exclusive prefix sums on a device: `kernels/scan.cu`.

use super::count::Count;
use super::session::Session;
use super::{Buffer, Gpu, GpuError, Pointer, Shape};

/// Threads a block, and numbers a block sums.
const THREADS: u32 = 256;
const TILE: usize = 2048;

/// What comes before each number of a list, modulo 2^32, and where the sum of all is counted.
pub(crate) fn scan<G: Gpu>(
    session: &mut Session<G>,
    numbers: &Buffer<u32>,
    count: Count,
) -> Result<(Buffer<u32>, Pointer<u64>), GpuError> {
    let before = session.allocate::<u32>(count.room())?;
    let total = session.counters(1)?;
    let tiles = count.room().div_ceil(TILE);
    if tiles > 0 {
        let (out, sums) = (before.pointer(), session.allocate::<u64>(tiles)?.pointer());
        session.group("scan", |session| {
            let numbers = numbers.pointer();
            session.launch("scan_tiles", Shape::row(tiles as u32, THREADS), &[&numbers, &out, &sums, &count])?;
            session.launch("scan_sums", Shape::row(1, THREADS), &[&sums, &(tiles as u32), &total])?;
            session.launch("scan_add", Shape::of(count.room(), THREADS), &[&out, &sums, &count])
        })?;
    }
    Ok((before, total))
}
