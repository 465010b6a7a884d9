//! Clocks of a multiprocessor that evaluating a meshlet takes, by arithmetic and device: computed from the machine code, not
//! measured. `HALFPIXEL_UPDATE=1 cargo test --test kernel_resources` writes this, with bench/results/evaluate-costs.md.

use super::selection::Clocks;

pub(super) const CLOCKS: [Clocks; 5] = [
    Clocks { target: 80, f32: [65.2, 73.0, 84.0, 121.0, 139.0, 157.0, 175.0], f16: 76.2, f16_recovered: 92.0, tf32: 75.2, tf32_recovered: 100.8 },
    Clocks { target: 86, f32: [65.2, 73.0, 84.0, 121.0, 139.0, 157.0, 175.0], f16: 76.2, f16_recovered: 91.2, tf32: 75.5, tf32_recovered: 112.0 },
    Clocks { target: 89, f32: [65.2, 73.0, 84.0, 121.0, 139.0, 157.0, 175.0], f16: 76.2, f16_recovered: 91.2, tf32: 75.5, tf32_recovered: 112.0 },
    Clocks { target: 90, f32: [70.2, 78.0, 87.8, 121.0, 139.0, 157.0, 175.0], f16: 80.0, f16_recovered: 94.5, tf32: 78.8, tf32_recovered: 104.8 },
    Clocks { target: 120, f32: [69.8, 77.0, 83.0, 121.0, 139.0, 157.0, 175.0], f16: 72.5, f16_recovered: 88.5, tf32: 75.2, tf32_recovered: 112.0 },
];
