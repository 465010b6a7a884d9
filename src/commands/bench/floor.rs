//! The least time each stage could take: bytes that must move over the measured copy bandwidth, or arithmetic over the
//! processor's peak, whichever is longer. The counts ignore everything that a cleverer program might avoid.

use crate::report::{Cell, Counts, Measured, Table};
use crate::scene::{Patch, Scene};
use rayon::prelude::*;
use std::time::Instant;

/// Floating-point operations a second and core: two fused multiply-adds of 8 floats a cycle at 3 GHz.
pub const PEAK_PER_CORE: f64 = 2.0 * 2.0 * 8.0 * 3e9;

/// What a machine can do at best.
#[derive(Clone, Copy, Debug)]
pub struct Peak {
    /// Bytes a second, read and written ones together.
    pub bandwidth: f64,
    /// Floating-point operations a second.
    pub arithmetic: f64,
}

/// What a stage can't avoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    pub stage: &'static str,
    pub bytes: f64,
    pub operations: f64,
}

impl Peak {
    /// Measures the bandwidth of copying between buffers that no cache holds, on all threads; the best of a few tries.
    pub fn measure() -> Self {
        const FLOATS: usize = 16 << 20;
        let from: Vec<f32> = (0..FLOATS).into_par_iter().map(|i| i as f32).collect();
        let mut to = vec![0f32; FLOATS];
        let chunk = FLOATS / rayon::current_num_threads().max(1) / 4;
        let copy = |to: &mut [f32]| {
            let start = Instant::now();
            to.par_chunks_mut(chunk).zip(from.par_chunks(chunk)).for_each(|(to, from)| to.copy_from_slice(from));
            std::hint::black_box(to);
            start.elapsed().as_secs_f64()
        };
        let seconds = (0..7).map(|_| copy(&mut to)).fold(f64::INFINITY, f64::min);
        Self {
            bandwidth: 2.0 * size_of::<f32>() as f64 * FLOATS as f64 / seconds,
            arithmetic: PEAK_PER_CORE * rayon::current_num_threads() as f64,
        }
    }

    pub fn ms(&self, work: &Work) -> f64 {
        (work.bytes / self.bandwidth).max(work.operations / self.arithmetic) * 1e3
    }
}

/// What each stage of a frame can't avoid, from its counts. f32 throughout, nothing read twice.
pub fn work(scene: &Scene, pixels: f64, counts: &Counts, refine: u32) -> Vec<Work> {
    let patches = scene.patches.len().max(1) as f64;
    let mean = |of: fn(&Patch) -> f64| scene.patches.iter().map(of).sum::<f64>() / patches;
    // A control point is 16 bytes; a multiply and an add for each of 4 coordinates.
    let points = mean(|p| p.points.len() as f64);
    let column = mean(|p| (p.degree[1] + 1) as f64);
    let (all, leaves) = (counts.patches as f64, counts.leaves as f64);
    let (quads, meshlets, drawn) = (counts.quads as f64, counts.meshlets as f64, counts.drawn as f64);
    // Rows and columns of a square meshlet with that many quads.
    let side = (quads / meshlets.max(1.0)).sqrt() + 1.0;
    let vertices = meshlets * side * side;
    let stage = |stage, bytes: f64, operations: f64| Work { stage, bytes, operations };
    vec![
        // A box and a cone in (40 bytes), six planes against a box; an index out for what is left.
        stage("cull", all * 40.0 + leaves * 4.0, all * 6.0 * 8.0),
        // Enclosure (21 floats) and net in; nine extents of boxes and their square roots; 16 bytes a meshlet out.
        stage("estimate", leaves * (84.0 + points * 16.0) + meshlets * 16.0, leaves * (9.0 * 8.0 + points * 8.0)),
        // Nets in, vertices kept on chip; each line of a grid reduces the net to a curve, each vertex evaluates that.
        stage("evaluate", leaves * points * 16.0, meshlets * side * points * 8.0 + vertices * column * 8.0),
        // One visibility word a pixel out, background too; set-up of a triangle 30 operations, 8 a covered pixel.
        stage("rasterize", pixels * 8.0, counts.triangles as f64 * 30.0 + drawn * 8.0),
        // A pixel that is filled: its word and its neighbours' in, one out.
        stage("fill", counts.filled as f64 * 88.0, counts.filled as f64 * 8.0),
        // Words in, parameters and colours out; a point with two tangents at every step, then the normal and two lights.
        stage("shade", pixels * 8.0 + drawn * 20.0, drawn * ((f64::from(refine) + 1.0) * points * 3.0 * 8.0 + 100.0)),
    ]
}

/// Measured time beside the floor, a line each stage.
pub fn table(measured: &Measured, work: &[Work], peak: &Peak) -> Table {
    let mut table = Table::new(&[
        "stage",
        "ms",
        "min ms",
        "max ms",
        "floor ms",
        "time / floor",
        "MB moved",
        "Mflop",
        "floor set by",
    ]);
    for stage in &measured.stages {
        let work = work.iter().find(|w| w.stage == stage.stage);
        let floor = work.map(|w| peak.ms(w));
        let by_memory = work.map(|w| w.bytes / peak.bandwidth > w.operations / peak.arithmetic);
        table.push(vec![
            stage.stage.as_str().into(),
            stage.ms.median.into(),
            stage.ms.min.into(),
            stage.ms.max.into(),
            floor.into(),
            floor.filter(|&f| f > 0.0).map(|f| stage.ms.median / f).into(),
            work.map(|w| w.bytes / 1e6).into(),
            work.map(|w| w.operations / 1e6).into(),
            by_memory.map_or(Cell::Missing, |m| if m { "memory" } else { "arithmetic" }.into()),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longer_of_both_is_the_floor() {
        let peak = Peak { bandwidth: 1e9, arithmetic: 2e9 };
        let work = |bytes, operations| Work { stage: "cull", bytes, operations };
        assert_eq!(peak.ms(&work(3e6, 2e6)), 3.0);
        assert_eq!(peak.ms(&work(1e6, 8e6)), 4.0);
    }
}
