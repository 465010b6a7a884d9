//! Scalar arithmetic: half, tf32, conversions, one rounding an operation.

use crate::support::Random;
use halfpixel::emulated::{Device, Shape};

/// Bits of the nearest half to an exact value, ties to even, by search.
fn nearest_half(exact: f64) -> u16 {
    let sign = if exact.is_sign_negative() { 0x8000 } else { 0 };
    let magnitude = exact.abs();
    if magnitude >= 65520.0 {
        return sign | 0x7c00;
    }
    let (mut low, mut high) = (0_u16, 0x7c00_u16);
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if half(middle) <= magnitude { low = middle } else { high = middle }
    }
    let above = if high == 0x7c00 { 65536.0 } else { half(high) };
    let (down, up) = (magnitude - half(low), above - magnitude);
    sign | if down < up || (down == up && low.is_multiple_of(2)) { low } else { high }
}

pub fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 0x3ff));
    match exponent {
        0 => sign * fraction * 2_f64.powi(-24),
        31 if fraction == 0.0 => sign * f64::INFINITY,
        31 => f64::NAN,
        _ => sign * (1.0 + fraction / 1024.0) * 2_f64.powi(exponent - 15),
    }
}

fn triples() -> Vec<f32> {
    let mut random = Random(3);
    let mut all = vec![
        0.0,
        -0.0,
        1.0,
        65504.0,
        65519.996,
        65520.0,
        5.9604645e-8,
        2.9802322e-8,
        2.980233e-8,
        6.1035156e-5,
        6.0e-5,
        -2049.0,
        2.5,
        3.5,
        -2.5,
        4.3e9,
        -4.3e9,
        2147483500.0,
    ];
    while all.len() < 3 * 4000 {
        let exponent = random.below(40) as i32 - 26;
        let sign = if random.below(2) == 0 { 1.0 } else { -1.0 };
        all.push(sign * (1.0 + random.below(1 << 23) as f32 / 8388608.0) * 2_f32.powi(exponent));
        if random.below(4) == 0 {
            // Midways between halves, and one ulp beside.
            let h = half(random.below(0x7bff) as u16) as f32;
            let next = half(nearest_half(f64::from(h)) + 1) as f32;
            let middle = (h + next) / 2.0;
            all.extend([middle, middle.next_up(), middle.next_down()]);
        }
    }
    all.truncate(3 * 4000);
    all
}

#[test]
fn scalars_are_rounded_once() {
    let input = triples();
    let n = input.len() / 3;
    let mut device = Device::default();
    let (inputs, outputs) = (device.upload(&input), device.zeroed::<u32>(16 * n));
    let shape = Shape::row(n.div_ceil(128) as u32, 128);
    let arguments = [&inputs.pointer() as _, &outputs.pointer() as _, &(n as i32) as _];
    device.launch("selftest_numbers", shape, &arguments).unwrap();
    let output = device.download(&outputs).unwrap();
    for (numbers, found) in input.chunks_exact(3).zip(output.chunks_exact(16)) {
        let &[a, b, c] = numbers else { unreachable!() };
        check_halves(numbers, found);
        assert_eq!(f32::from_bits(found[7]).to_bits(), a.mul_add(b, c).to_bits());
        assert_eq!(f32::from_bits(found[8]).to_bits(), (a * b + c).to_bits(), "contraction is off");
        assert_eq!(found[9] as i32, a.round_ties_even() as i32);
        assert_eq!(found[10] as i32, a.floor() as i32);
        assert_eq!(found[11] as i32, a as i32);
        assert_eq!(found[12], a as u32);
        assert_eq!(found[13], a.to_bits().reverse_bits());
        assert_eq!(found[14], ((u64::from(a.to_bits()) * u64::from(b.to_bits())) >> 32) as u32);
    }
}

fn check_halves(numbers: &[f32], found: &[u32]) {
    let [a, b, c] = [0, 1, 2].map(|i| nearest_half(f64::from(numbers[i])));
    let [x, y, z] = [a, b, c].map(half);
    assert_eq!(found[0], u32::from(a), "{numbers:?}");
    assert_eq!(found[15], u32::from(a) | u32::from(b) << 16);
    if !x.is_finite() || !y.is_finite() || !z.is_finite() {
        return;
    }
    assert_eq!(f64::from(f32::from_bits(found[1])), x);
    let toward_zero = half(found[2] as u16);
    let exact = f64::from(numbers[0]);
    assert!(toward_zero.abs() <= exact.abs() && (x == toward_zero || x.abs() > exact.abs()), "{exact}: {toward_zero}");
    let same = |bits: u32, exact: f64, what: &str| {
        let expected = nearest_half(exact);
        assert!(bits as u16 == expected || exact == 0.0 && half(bits as u16) == 0.0, "{what} of {x} {y} {z}");
    };
    same(found[3], x + y, "sum");
    same(found[4], x * y, "product");
    // The exact sum may need more than 53 bits; where it does not, f64 holds it.
    let (product, sum) = (x * y, x * y + z);
    if sum - product == z && sum - z == product {
        same(found[5], sum, "fused product");
    }
    let tf32 = f64::from(f32::from_bits(found[6]));
    let unit = 2_f64.powi(exact.abs().log2().floor().max(-126.0) as i32 - 10);
    assert!((tf32 - exact).abs() <= unit / 2.0 && found[6] & 0x1fff == 0, "tf32 of {exact}");
}
