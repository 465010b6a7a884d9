//! What kernels of evaluate can't do without, and how fast a device does that alone (kernels/floor.cu).

use super::{Bench, Candidate, Output};
use crate::cuda::precision::Arithmetic;
use crate::cuda::{Gpu, GpuError, Shape};
use crate::report::Table;

/// As in kernels/floor.cu.
const THREADS: u32 = 256;
const CHAINS: u32 = 8;
const WARP: u32 = 32;
/// Blocks a multiprocessor: more than fit, so that none waits long for the last ones.
const BLOCKS: u32 = 16;

/// Rates that were measured.
#[derive(Clone, Copy, Debug)]
pub struct Floors {
    /// Bytes a millisecond.
    pub stores: f64,
    /// Multiply-adds of f32 a millisecond.
    pub multiply_adds: f64,
    /// Products m16n8k8 of f16, m16n8k16 of sparse f16, and m16n8k8 of tf32 a millisecond.
    pub products: [f64; 3],
}

/// What a meshlet of 8 x 8 vertices takes at least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arithmetics {
    MultiplyAdds(f64),
    /// By index into `Floors::products`.
    Products(usize, f64),
}

impl<G: Gpu> Bench<'_, G> {
    /// Measures stores of so many bytes, and arithmetic in loops of so many rounds.
    pub fn floors(&mut self, bytes: usize, rounds: u32) -> Result<Floors, GpuError> {
        let blocks = BLOCKS * self.multiprocessors;
        let shape = Shape::row(blocks, THREADS);
        let vectors = bytes / 16;
        let out = self.gpu.allocate::<[f32; 4]>(vectors)?;
        let (to, count) = (out.pointer(), vectors as u64);
        let ms = self.timed(|bench| bench.gpu.launch("floor_store", shape, &[&to, &count]))?.median;
        self.gpu.free(out)?;
        let stores = (16 * vectors) as f64 / ms;
        let out = self.gpu.allocate::<f32>(1)?;
        let to = out.pointer();
        let mut rate = |kernel: &str, threads_an_operation: u32| {
            let ms = self.timed(|bench| bench.gpu.launch(kernel, shape, &[&to, &rounds, &0.5f32]))?.median;
            let chains = f64::from(blocks) * f64::from(THREADS / threads_an_operation) * f64::from(CHAINS);
            Ok::<f64, GpuError>(chains * f64::from(rounds) / ms)
        };
        let multiply_adds = rate("floor_multiply_add", 1)?;
        let products = [
            rate("floor_products_f16", WARP)?,
            rate("floor_products_f16_sparse", WARP)?,
            rate("floor_products_tf32", WARP)?,
        ];
        self.gpu.free(out)?;
        Ok(Floors { stores, multiply_adds, products })
    }
}

impl Floors {
    /// Milliseconds that storing takes at least.
    pub fn store_ms(&self, bytes: f64) -> f64 {
        bytes / self.stores
    }

    /// Milliseconds that the arithmetic of so many meshlets takes at least.
    pub fn arithmetic_ms(&self, candidate: &Candidate, degree: u8, meshlets: f64) -> f64 {
        meshlets
            * match least(candidate, degree) {
                Arithmetics::MultiplyAdds(count) => count / self.multiply_adds,
                Arithmetics::Products(kind, count) => count / self.products[kind],
            }
    }

    pub fn table(&self, measured: bool) -> Table {
        let mut table = Table::new(&["what", if measured { "rate" } else { "emulator's rate" }, "unit"]);
        let mut line = |what: &str, rate: f64, unit: &str| table.push(vec![what.into(), rate.into(), unit.into()]);
        line("stores of 16 bytes", self.stores * 1e-6, "GB/s");
        line("multiply-adds of f32", self.multiply_adds * 1e-9, "T/s");
        line("products m16n8k8 of f16", self.products[0] * 1e-6, "G/s");
        line("products m16n8k16 of sparse f16", self.products[1] * 1e-6, "G/s");
        line("products m16n8k8 of tf32", self.products[2] * 1e-6, "G/s");
        table
    }
}

/// Sums over u for the lines of a meshlet, then sums over v for its vertices: of values, and with normals of derivatives too.
/// Quotients, normals and addresses are left out. Products: kernels/evaluate_mma.cu and evaluate_normals_mma.cu.
fn least(candidate: &Candidate, degree: u8) -> Arithmetics {
    let points = f64::from(degree) + 1.0;
    let positions = candidate.output == Output::Vertex;
    let (plain, recovered) = if positions { (6.0, 14.0) } else { (10.0, 30.0) };
    match candidate.arithmetic {
        Arithmetic::F32 => {
            let (over_u, over_v) = if positions { (4.0, 4.0) } else { (8.0, 12.0) };
            Arithmetics::MultiplyAdds(8.0 * points * points * over_u + 64.0 * points * over_v)
        }
        Arithmetic::F16 => Arithmetics::Products(0, plain),
        Arithmetic::F16Recovered => Arithmetics::Products(0, recovered),
        Arithmetic::F16Sparse => Arithmetics::Products(1, plain),
        Arithmetic::Tf32 => Arithmetics::Products(2, plain),
        Arithmetic::Tf32Recovered => Arithmetics::Products(2, recovered),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bicubic_work() {
        let candidate = |arithmetic, output| Candidate { kernel: String::new(), arithmetic, output };
        let least = |arithmetic, output| least(&candidate(arithmetic, output), 3);
        assert_eq!(least(Arithmetic::F32, Output::Vertex), Arithmetics::MultiplyAdds(512.0 + 1024.0));
        assert_eq!(least(Arithmetic::F32, Output::Point), Arithmetics::MultiplyAdds(1024.0 + 3072.0));
        assert_eq!(least(Arithmetic::Tf32Recovered, Output::Vertex), Arithmetics::Products(2, 14.0));
    }
}
