//! Bernstein values of a frame's grids, made on the device: `kernels/basis.cu`.

use super::scan::scan;
use super::session::Session;
use super::{Buffer, Gpu, GpuError, Shape, abi};

/// The tables of all degrees and grid sizes that occur, in this order; patches learn where theirs are.
pub(crate) fn tables<G: Gpu>(
    session: &mut Session<G>,
    patches: &Buffer<abi::Patch>,
    most_degree: usize,
) -> Result<Buffer<f32>, GpuError> {
    let keys = (most_degree + 1) * abi::BASIS_SIDES as usize;
    let sizes = session.zeroed::<u32>(keys)?;
    let count = patches.len() as u32;
    session.for_each("basis_sizes", patches.len(), &[&count, &patches.pointer(), &sizes.pointer()])?;
    let (places, total) = scan(session, &sizes)?;
    let (rows, tables) = (session.allocate::<f64>(total as usize)?, session.allocate::<f32>(total as usize)?);
    if total > 0 {
        session.launch(
            "basis_tables",
            Shape::row(keys as u32, 32),
            &[&sizes.pointer(), &places.pointer(), &rows.pointer(), &tables.pointer()],
        )?;
    }
    session.for_each("basis_places", patches.len(), &[&count, &patches.pointer(), &places.pointer()])?;
    Ok(tables)
}
