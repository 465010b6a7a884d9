//! evaluate on the CPU by the GPU's kernels.

use super::{Device, LaunchError};
use crate::cuda::Shape;
use crate::cuda::abi;
use crate::cuda::evaluate::{Staged, WARPS};

impl Device {
    /// The vertices of all meshlets.
    pub fn evaluate(&mut self, staged: &Staged) -> Result<Vec<abi::Vertex>, LaunchError> {
        let (patches, nets) = (self.upload(&staged.patches), self.upload(&staged.nets));
        let (basis, vertices) = (self.upload(&staged.basis), self.allocate::<abi::Vertex>(staged.vertices));
        for (kernel, meshlets) in staged.bins() {
            let count = meshlets.len() as u32;
            let meshlets = self.upload(&meshlets);
            self.launch(
                &kernel,
                Shape::row(count.div_ceil(WARPS), WARPS * 32),
                &[
                    &staged.view,
                    &patches.pointer(),
                    &meshlets.pointer(),
                    &nets.pointer(),
                    &basis.pointer(),
                    &vertices.pointer(),
                    &count,
                ],
            )?;
            self.free(&meshlets)?;
        }
        let found = self.download(&vertices)?;
        self.free(&vertices)?;
        self.free(&basis)?;
        self.free(&nets)?;
        self.free(&patches)?;
        Ok(found)
    }
}
