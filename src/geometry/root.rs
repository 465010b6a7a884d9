//! Roots of any degree, the same on every device: powers of the C library are not.

/// The n-th root of a number that is at least 1, to a few units in the last place; infinity for infinity. Newton's method
/// from above falls until rounding stops it. Twin: kernels/lens.cuh.
pub fn root(a: f64, n: usize) -> f64 {
    if !(a > 1.0 && a < f64::INFINITY) {
        return if a > 1.0 { a } else { 1.0 };
    }
    let degree = n as f64;
    // a < 2^exponent, and 2^f <= 1 + f for f in [0, 1].
    let exponent = (a.to_bits() >> 52) as usize - 1022;
    let mut power = 1.0;
    (0..exponent / n).for_each(|_| power *= 2.0);
    let mut root = power * (1.0 + (exponent % n) as f64 / degree);
    loop {
        let mut power = 1.0;
        (1..n).for_each(|_| power *= root);
        let next = root - (root - a / power) / degree;
        // Also where the power left the range of numbers.
        if next >= root || next.is_nan() {
            return root;
        }
        root = next;
    }
}

#[cfg(test)]
mod tests {
    use super::root;

    #[test]
    fn roots_are_those_of_the_library() {
        for n in [1, 2, 3, 6, 14, 50, 126] {
            for a in [1.0, 1.0 + 1e-15, 1.5, 2.0, 7.3, 1e3, 1e16, 1e90, 1e300] {
                let (found, expected) = (root(a, n), a.powf(1.0 / n as f64));
                assert!((found / expected - 1.0).abs() < 1e-13, "{a} {n}: {found} {expected}");
            }
        }
        assert_eq!(root(f64::INFINITY, 3), f64::INFINITY);
        assert_eq!(root(f64::NAN, 3), 1.0);
    }
}
