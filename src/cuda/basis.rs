//! Bernstein values of a frame's grids, made on the device: `kernels/basis.cu`.

use super::count::Count;
use super::scan::scan;
use super::session::Session;
use super::{Buffer, Gpu, GpuError, Shape, abi};

/// The tables of all degrees and grid sizes that occur, in this order; patches learn where theirs are. With how many leaves there
/// are, if there is room for their tables.
pub(crate) fn tables<G: Gpu>(
    session: &mut Session<G>,
    patches: &Buffer<abi::Patch>,
    leaves: Count,
    most_degree: usize,
) -> Result<(Buffer<f32>, Count), GpuError> {
    let keys = (most_degree + 1) * abi::BASIS_SIDES as usize;
    let sizes = session.zeroed::<u32>(keys)?;
    session.for_all("basis_sizes", leaves, &[&leaves, &patches.pointer(), &sizes.pointer()])?;
    let (places, total) = scan(session, &sizes, Count::known(keys as u32))?;
    let all = session.count_of(total, "Bernstein values")?;
    let (rows, tables) = (session.allocate::<f64>(all.room())?, session.allocate::<f32>(all.room())?);
    if all.room() > 0 {
        session.launch(
            "basis_tables",
            Shape::row(keys as u32, 32),
            &[&sizes.pointer(), &places.pointer(), &all, &rows.pointer(), &tables.pointer()],
        )?;
    }
    session.for_all("basis_places", leaves, &[&leaves, &patches.pointer(), &places.pointer()])?;
    Ok((tables, session.both(leaves, all)?))
}
