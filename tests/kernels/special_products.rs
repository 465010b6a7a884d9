//! Cases of tensor-core arithmetic that were worked out by hand: what is cut off, what is infinite, what is no number.

use crate::products::{Product, TILES, Tile};
use halfpixel::emulated::TensorCores::{self, Sm80, Sm90};

/// Element (0, 0) of a product with these factors in row and column 0.
fn element(tile: Tile, cores: TensorCores, c: f32, factors: &[(f32, f32)]) -> f32 {
    let mut product = Product::new(tile);
    for (k, &(a, b)) in factors.iter().enumerate() {
        product.a[k] = tile.operand(a);
        product.b[k * 8] = tile.operand(b);
    }
    product.c[0] = c;
    product.run(cores)[0]
}

fn power(e: i32) -> f32 {
    2_f64.powi(e) as f32
}

/// 1 - 2^-k: one more bit below the point survives alignment on sm_80, two on sm_90; rounding to nearest would differ.
#[test]
fn alignment_keeps_one_or_two_bits() {
    for tile in TILES {
        let minus = |cores, k: i32| element(tile, cores, -power(-k), &[(1.0, 1.0)]);
        for cores in [Sm80, Sm90] {
            assert_eq!(minus(cores, 24), 1.0 - power(-24), "{tile:?} {cores:?}");
            assert_eq!(minus(cores, 26), 1.0, "{tile:?} {cores:?}: cut off before the sum");
        }
        assert_eq!(minus(Sm80, 25), 1.0, "{tile:?}");
        assert_eq!(minus(Sm90, 25), 1.0 - power(-24), "{tile:?}: 1 - 2^-25, then cut off");
    }
}

/// Results are cut off: 1 + 1.5 ulp and -1 - 1.5 ulp lose the half, neither goes to even nor away.
#[test]
fn results_are_cut_off() {
    for tile in TILES {
        for sign in [1.0, -1.0] {
            let one_and_a_half = [(sign, 1.0), (sign * power(-12), power(-11)), (sign * power(-12), power(-12))];
            for cores in [Sm80, Sm90] {
                assert_eq!(element(tile, cores, 0.0, &one_and_a_half), sign * (1.0 + power(-23)), "{tile:?} {cores:?}");
            }
        }
    }
}

/// Products are exact, and a carry of the sum moves the cut, not the alignment: 1.9990234375^2 * 8 + 2^-20.
#[test]
fn products_are_exact() {
    let near_two = 2.0 - power(-10);
    for tile in TILES {
        let eight = element(tile, Sm80, power(-18), &[(near_two, near_two); 8]);
        let exact = 8.0 * f64::from(near_two).powi(2) + 2_f64.powi(-18);
        let unit = 2_f64.powi(4 - 23);
        // On tf32 two groups of four follow each other; both sums are representable here.
        assert_eq!(f64::from(eight), (exact / unit).trunc() * unit, "{tile:?}");
    }
}

/// Two groups of K: a term that the first group cuts off is lost, the same term beside its partner is not.
#[test]
fn groups_follow_each_other() {
    let tiny = (power(-13), power(-12));
    let mut factors = [(0.0, 1.0); 8];
    (factors[0], factors[1], factors[4]) = ((1.0, 1.0), tiny, (-1.0, 1.0));
    assert_eq!(element(Tile::Tf32K8, Sm80, 0.0, &factors), 0.0, "2^-25 is lost beside 1 in the first group of 4");
    assert_eq!(element(Tile::Tf32K8, Sm90, 0.0, &factors), power(-25), "one group of 8 keeps 25 bits");
    let mut factors = [(0.0, 1.0); 16];
    (factors[0], factors[8], factors[9]) = ((1.0, 1.0), (-1.0, 1.0), tiny);
    assert_eq!(element(Tile::F16K16, Sm80, 0.0, &factors), 0.0, "first 1, then -1 + 2^-25 beside the sum 1");
    assert_eq!(element(Tile::F16K16, Sm90, 0.0, &factors), power(-25), "one group of 16");
}

/// Below f32's normal numbers results are cut off at 2^-149, not rounded.
#[test]
fn subnormal_results_are_cut_off() {
    let tile = Tile::Tf32K8;
    for (sign, cores) in [(1.0, Sm80), (-1.0, Sm80), (1.0, Sm90), (-1.0, Sm90)] {
        let product = |bits: f32| element(tile, cores, 0.0, &[(sign * bits * power(-75), power(-74))]);
        assert_eq!(product(1.0), sign * power(-149));
        assert_eq!(product(1.75), sign * power(-149), "rounding to nearest gives 2^-148");
        assert_eq!(product(3.5), sign * 3.0 * power(-149));
        assert_eq!(product(0.75), 0.0);
    }
    let least = f32::from_bits(1);
    assert_eq!(element(tile, Sm80, least, &[]), least, "a subnormal accumulator stays");
    assert_eq!(element(Tile::F16K8, Sm80, 0.0, &[(power(-24), power(-24))]), power(-48), "subnormal halves");
}

#[test]
fn overflow_is_infinite() {
    let most = f32::MAX;
    assert_eq!(element(Tile::Tf32K8, Sm80, most, &[(power(100), power(4))]), f32::INFINITY);
    assert_eq!(element(Tile::Tf32K8, Sm80, most, &[(power(100), power(3))]), most, "cut off, it fits");
    assert_eq!(element(Tile::Tf32K8, Sm90, -most, &[(-power(100), power(27))]), f32::NEG_INFINITY);
    let sum =
        element(Tile::Tf32K8, Sm80, 0.0, &[(power(100), power(28)), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (-1.0, 1.0)]);
    assert_eq!(sum, f32::INFINITY, "a first group that overflowed stays so");
}

/// An operand that is Inf or NaN touches its row or column only, an accumulator its element only.
#[test]
fn infinities_touch_only_what_they_meet() {
    for tile in TILES {
        let (infinity, nan) = if tile == Tile::Tf32K8 { (0x7f80_0000, 0x7fc0_0000) } else { (0x7c00, 0x7e00) };
        let mut product = Product::new(tile);
        product.a.fill(tile.operand(1.0));
        product.b.fill(tile.operand(2.0));
        product.a[2 * tile.k() + 3] = infinity;
        product.a[5 * tile.k()] = nan;
        product.b[7 * 8 + 4] = nan;
        product.b[3 * 8 + 6] = tile.operand(0.0);
        product.c[9 * 8 + 1] = f32::NEG_INFINITY;
        product.c[2 * 8 + 7] = f32::NEG_INFINITY;
        for cores in [Sm80, Sm90] {
            for (i, x) in product.run(cores).into_iter().enumerate() {
                let plain = 2.0 * tile.k() as f32 - if i % 8 == 6 { 2.0 } else { 0.0 };
                let expected = match (i / 8, i % 8) {
                    (5, _) | (_, 4) => f32::NAN,
                    (2, 6) => f32::NAN, // infinity times zero
                    (2, 7) => f32::NAN, // infinity minus infinity
                    (2, _) => f32::INFINITY,
                    (9, 1) => f32::NEG_INFINITY,
                    _ => plain,
                };
                assert!(x == expected || x.to_bits() == 0x7fff_ffff && expected.is_nan(), "{tile:?} {i}: {x}");
            }
        }
    }
}
