//! Tensor-core tiles: register layouts against a plain matrix product, arithmetic against the published model.

use crate::numbers::half;
use crate::support::Random;
use halfpixel::emulated::{Device, Schedule, Shape, TensorCores};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tile {
    F16K8,
    F16K16,
    Tf32K8,
}

pub const TILES: [Tile; 3] = [Tile::F16K8, Tile::F16K16, Tile::Tf32K8];

impl Tile {
    pub fn k(self) -> usize {
        if self == Self::F16K16 { 16 } else { 8 }
    }

    fn kernel(self) -> &'static str {
        match self {
            Self::F16K8 => "selftest_mma_m16n8k8_f16",
            Self::F16K16 => "selftest_mma_m16n8k16_f16",
            Self::Tf32K8 => "selftest_mma_m16n8k8_tf32",
        }
    }

    /// Bits of an operand that is a multiple of 2^-24 below 2^16 with at most 11 bits.
    pub fn operand(self, x: f32) -> u32 {
        if self == Self::Tf32K8 {
            return x.to_bits();
        }
        let found = (0..0x7c00_u16).collect::<Vec<_>>();
        let bits = found.binary_search_by(|&h| half(h).total_cmp(&f64::from(x.abs()))).expect("a half");
        bits as u32 | if x.is_sign_negative() { 0x8000 } else { 0 }
    }

    fn value(self, bits: u32) -> f64 {
        if self == Self::Tf32K8 { f64::from(f32::from_bits(bits & 0xffff_e000)) } else { half(bits as u16) }
    }

    /// As the hardware sees it: of subnormals, that of the smallest normal number.
    fn exponent(self, bits: u32) -> i32 {
        if self == Self::Tf32K8 { (bits >> 23 & 255).max(1) as i32 - 127 } else { (bits >> 10 & 31).max(1) as i32 - 15 }
    }
}

/// D = A B + C for matrices of operand bits, row after row.
pub struct Product {
    pub tile: Tile,
    pub a: Vec<u32>,
    pub b: Vec<u32>,
    pub c: Vec<f32>,
}

impl Product {
    pub fn new(tile: Tile) -> Self {
        Self { tile, a: vec![0; 16 * tile.k()], b: vec![0; tile.k() * 8], c: vec![0.0; 128] }
    }

    fn a(&self, row: usize, k: usize) -> u32 {
        self.a[row * self.tile.k() + k]
    }

    fn b(&self, k: usize, column: usize) -> u32 {
        self.b[k * 8 + column]
    }

    /// The registers of all lanes, as the PTX manual draws them.
    fn registers(&self) -> (Vec<u32>, Vec<u32>) {
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for lane in 0..32 {
            let (g, t) = (lane / 4, lane % 4);
            if self.tile == Tile::Tf32K8 {
                a.extend([self.a(g, t), self.a(g + 8, t), self.a(g, t + 4), self.a(g + 8, t + 4)]);
                b.extend([self.b(t, g), self.b(t + 4, g)]);
                continue;
            }
            for k in (0..self.tile.k()).step_by(8).map(|k| k + 2 * t) {
                a.extend([g, g + 8].map(|row| self.a(row, k) | self.a(row, k + 1) << 16));
                b.push(self.b(k, g) | self.b(k + 1, g) << 16);
            }
        }
        (a, b)
    }

    pub fn run(&self, tensor_cores: TensorCores) -> Vec<f32> {
        self.run_under(Schedule { tensor_cores, ..Schedule::default() })
    }

    fn run_under(&self, schedule: Schedule) -> Vec<f32> {
        let mut device = Device::new(schedule, 1);
        let (a, b) = self.registers();
        let at = |lane: usize, r: usize| (lane / 4 + 8 * (r / 2)) * 8 + 2 * (lane % 4) + r % 2;
        let c: Vec<f32> = (0..128).map(|i| self.c[at(i / 4, i % 4)]).collect();
        let (a, b, c, d) = (device.upload(&a), device.upload(&b), device.upload(&c), device.allocate::<f32>(128));
        let arguments = [&a.pointer() as _, &b.pointer() as _, &c.pointer() as _, &d.pointer() as _];
        device.launch(self.tile.kernel(), Shape::row(1, 32), &arguments).unwrap();
        let mut result = vec![0.0; 128];
        device.download(&d).unwrap().into_iter().enumerate().for_each(|(i, x)| result[at(i / 4, i % 4)] = x);
        result
    }

    /// The element by the model, in integers of 128 bits.
    fn model(&self, row: usize, column: usize, cores: TensorCores) -> f32 {
        let (group, extra) = match (cores, self.tile) {
            (TensorCores::Sm80, Tile::Tf32K8) => (4, 1),
            (TensorCores::Sm80, _) => (8, 1),
            (TensorCores::Sm90, _) => (self.tile.k(), 2),
        };
        let mut sum = self.c[row * 8 + column];
        for first in (0..self.tile.k()).step_by(group) {
            let operands = (first..first + group).map(|k| (self.a(row, k), self.b(k, column)));
            let (value, exponent) = (|x| self.tile.value(x), |x| self.tile.exponent(x));
            let mut terms: Vec<(f64, i32)> =
                operands.map(|(a, b)| (value(a) * value(b), exponent(a) + exponent(b))).collect();
            terms.push((f64::from(sum), (sum.to_bits() >> 23 & 255).max(1) as i32 - 127));
            sum = add_up(&terms, extra);
        }
        sum
    }
}

/// Aligns to the largest exponent, cuts off, adds, cuts off.
fn add_up(terms: &[(f64, i32)], extra: i32) -> f32 {
    let Some(top) = terms.iter().filter(|t| t.0 != 0.0).map(|t| t.1).max() else { return 0.0 };
    let unit = 2_f64.powi(top - 23 - extra);
    let sum: i128 = terms.iter().map(|t| (t.0 / unit).trunc() as i128).sum();
    let exact = sum as f64 * unit;
    if exact == 0.0 {
        return 0.0;
    }
    let bits = (exact.abs().log2().floor() as i32 - 23).max(-149);
    ((exact / 2_f64.powi(bits)).trunc() * 2_f64.powi(bits)) as f32
}

/// Integers so small that every sum is exact: only a wrong layout can show.
#[test]
fn layouts_are_those_of_the_manual() {
    let mut random = Random(9);
    for (round, tile) in TILES.into_iter().cycle().take(30).enumerate() {
        let mut draw = |n: usize| (0..n).map(|_| random.below(31) as i32 - 15).collect::<Vec<_>>();
        let (a, b, c) = (draw(16 * tile.k()), draw(tile.k() * 8), draw(128));
        let operands = |m: &[i32]| m.iter().map(|&x| tile.operand(x as f32)).collect();
        let product = Product { tile, a: operands(&a), b: operands(&b), c: c.iter().map(|&x| x as f32).collect() };
        let schedule = Schedule::adversarial()[round % 9];
        let found = product.run_under(schedule);
        for (i, &x) in found.iter().enumerate() {
            let (row, column) = (i / 8, i % 8);
            let sum: i32 = (0..tile.k()).map(|k| a[row * tile.k() + k] * b[k * 8 + column]).sum();
            assert_eq!(x, (sum + c[i]) as f32, "{tile:?} ({row}, {column})");
        }
    }
}

#[test]
fn arithmetic_is_the_published_model() {
    let mut random = Random(77);
    for round in 0..240 {
        let tile = TILES[round % 3];
        let mut operand = |spread: u64| match tile {
            Tile::Tf32K8 => {
                (random.next() as u32 & 0x807f_e000) | ((127 - spread / 2 + random.below(spread)) as u32) << 23
            }
            _ if round % 4 == 0 => random.next() as u32 & 0x83ff | (random.below(31) as u32) << 10,
            _ => random.next() as u32 & 0x83ff | (10 + random.below(9) as u32) << 10,
        };
        let spread = [4, 12, 30][round / 3 % 3];
        let mut product = Product::new(tile);
        product.a.fill_with(|| operand(spread));
        product.b.fill_with(|| operand(spread));
        product
            .c
            .fill_with(|| f32::from_bits(random.next() as u32 & 0x807f_ffff | (117 + random.below(20) as u32) << 23));
        for cores in [TensorCores::Sm80, TensorCores::Sm90] {
            for (i, x) in product.run(cores).into_iter().enumerate() {
                let expected = product.model(i / 8, i % 8, cores);
                assert_eq!(x, expected, "{tile:?} {cores:?} element {i}, round {round}");
            }
        }
    }
}
