//! Clocks of a multiprocessor that evaluating a meshlet takes, by arithmetic and device: computed from the machine code, not
//! measured. `HALFPIXEL_UPDATE=1 cargo test --test kernel_resources` writes this, with bench/results/evaluate-costs.md.

use super::selection::Clocks;

pub(super) const CLOCKS: [Clocks; 5] = [
    Clocks { target: 80, f32: [63.0, 70.8, 81.8, 119.0, 137.0, 155.0, 173.0], f16: 74.0, f16_recovered: 89.8, tf32: 73.0, tf32_recovered: 98.5 },
    Clocks { target: 86, f32: [63.0, 70.8, 81.8, 119.0, 137.0, 155.0, 173.0], f16: 74.0, f16_recovered: 89.0, tf32: 73.2, tf32_recovered: 112.0 },
    Clocks { target: 89, f32: [63.0, 70.8, 81.8, 119.0, 137.0, 155.0, 173.0], f16: 74.0, f16_recovered: 89.0, tf32: 73.2, tf32_recovered: 112.0 },
    Clocks { target: 90, f32: [68.0, 75.8, 85.5, 119.0, 137.0, 155.0, 173.0], f16: 77.8, f16_recovered: 92.2, tf32: 76.5, tf32_recovered: 102.5 },
    Clocks { target: 120, f32: [68.0, 75.2, 81.2, 119.0, 137.0, 155.0, 173.0], f16: 70.8, f16_recovered: 86.8, tf32: 73.5, tf32_recovered: 112.0 },
];
