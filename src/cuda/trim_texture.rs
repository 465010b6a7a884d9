//! `--trim texture`, host side: the textures of all leaves that loops cut, and the meshlets that look them up. Twin of
//! src/stages/trim_texture.rs.

use super::count::Count;
use super::frame::{Stages, Trimmed};
use super::gpu::pods;
use super::scan::scan;
use super::{Buffer, Gpu, GpuError, abi};
use crate::stages::TrimCounts;

pods!(abi::TrimTexture abi::TextureCounts);

/// Words of all textures: places in the list have 32 bits. Nearly 16 GiB.
const MOST_WORDS: u64 = u32::MAX as u64;

impl<G: Gpu> Stages<'_, '_, G> {
    /// Draws the meshlets that trim curves cross by textures; strokes, and whatever asks for trims from here on, look them up
    /// too.
    pub(super) fn trim_by_textures(&mut self) -> Result<Trimmed, GpuError> {
        let counts = self.session.zeroed::<abi::TextureCounts>(1)?;
        let texture_bytes = self.textures(&counts)?;
        let (near, spare, trims) = (self.near.pointer(), self.spare.pointer(), self.trims);
        self.session.for_meshlets(&self.geometry, "texture_meshlets", &[&trims, &near, &counts.pointer()])?;
        self.session.for_meshlets(&self.geometry, "trim_strokes", &[&trims, &near, &spare])?;
        let counts = self.session.download(&counts)?;
        let abi::TextureCounts { tested, rejected, too_coarse } = counts.first().copied().unwrap_or_default();
        let known =
            TrimCounts { tested, rejected, textures_too_coarse: too_coarse, texture_bytes, ..TrimCounts::default() };
        Ok(Trimmed { known, counted: None })
    }

    /// Makes all textures; returns what they take.
    fn textures(&mut self, counts: &Buffer<abi::TextureCounts>) -> Result<u64, GpuError> {
        let (view, leaves) = (self.geometry.view, self.geometry.patches.len());
        let (patches, described, nets) =
            (self.geometry.patches.pointer(), self.geometry.leaves.pointer(), self.geometry.nets.pointer());
        let textures = self.session.allocate::<abi::TrimTexture>(leaves)?;
        let (rows, words) = (self.session.allocate::<u32>(leaves)?, self.session.allocate::<u32>(leaves)?);
        let (list, row, word, count) = (textures.pointer(), rows.pointer(), words.pointer(), leaves as u32);
        self.session.for_each(
            "texture_sizes",
            leaves,
            &[&view, &count, &patches, &described, &nets, &list, &row, &word, &counts.pointer()],
        )?;
        let known = Count::known(count);
        let (first_words, needed) = scan(self.session, &words, known)?;
        let needed = self.session.value(needed)?;
        if needed > MOST_WORDS {
            let what = "words of 32 texels in trim textures";
            return Err(GpuError::TooMany { what, needed, limit: MOST_WORDS });
        }
        // No more than there are words.
        let (first_rows, all) = scan(self.session, &rows, known)?;
        let all = self.session.value(all)?;
        let texels = self.session.allocate::<u32>(needed as usize)?;
        let (row, word) = (first_rows.pointer(), first_words.pointer());
        self.session.for_each(
            "texture_rows",
            all as usize,
            &[&(all as u32), &count, &self.trims, &described, &list, &row, &word, &texels.pointer()],
        )?;
        self.trims = self.trims.with_textures(&textures, &texels);
        Ok(needed * size_of::<u32>() as u64)
    }
}
