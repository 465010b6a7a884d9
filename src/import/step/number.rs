//! Numbers of a Part 21 file (ISO 10303-21:2016, 6.4.1 and 6.4.2).

/// Powers of ten that doubles hold exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];
/// Digits that a u64 holds whatever they are.
const MAX_DIGITS: usize = 19;
/// Doubles hold all whole numbers up to this one.
const MAX_MANTISSA: u64 = 1 << 53;

/// The finite number that is written here, to the nearest double; Fortran's D stands for E in some files.
pub(super) fn real(text: &[u8]) -> Option<f64> {
    short(text).or_else(|| long(text))
}

fn long(text: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(text).ok()?;
    let number = text.parse::<f64>().or_else(|_| text.replace(['D', 'd'], "E").parse()).ok()?;
    number.is_finite().then_some(number)
}

/// Numbers whose digits and power of ten doubles hold exactly, which most are: one operation rounds them to the nearest
/// double (Clinger, "How to read floating point numbers accurately", 1990).
fn short(text: &[u8]) -> Option<f64> {
    let mut at = usize::from(matches!(text.first()?, b'+' | b'-'));
    let mut mantissa = 0u64;
    let mut digits = |at: &mut usize| {
        let start = *at;
        while let Some(b @ b'0'..=b'9') = text.get(*at) {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(b - b'0'));
            *at += 1;
        }
        *at - start
    };
    let mut count = digits(&mut at);
    let mut power = 0;
    if text.get(at) == Some(&b'.') {
        at += 1;
        let fraction = digits(&mut at);
        count += fraction;
        power -= fraction as i32;
    }
    if count == 0 || count > MAX_DIGITS || mantissa > MAX_MANTISSA {
        return None;
    }
    if at < text.len() {
        power += exponent(&text[at..])?;
    }
    let scale = *POWERS.get(power.unsigned_abs() as usize)?;
    let value = if power < 0 { mantissa as f64 / scale } else { mantissa as f64 * scale };
    Some(if text[0] == b'-' { -value } else { value })
}

/// `E-12`, all of it.
fn exponent(text: &[u8]) -> Option<i32> {
    let [b'E' | b'e' | b'D' | b'd', rest @ ..] = text else { return None };
    let (sign, digits) = match rest {
        [b'-', digits @ ..] => (-1, digits),
        [b'+', digits @ ..] => (1, digits),
        digits => (1, digits),
    };
    if !(1..=4).contains(&digits.len()) || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    Some(sign * digits.iter().fold(0, |n, b| 10 * n + i32::from(b - b'0')))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn odd_spellings() {
        for (text, value) in [
            ("1.", Some(1.0)),
            (".5", Some(0.5)),
            ("-0.", Some(-0.0)),
            ("+2.5E+3", Some(2500.0)),
            ("1.5D-2", Some(0.015)),
            ("9007199254740993.", Some(9007199254740992.0)),
            ("123456789012345678901234567890.", Some(1.2345678901234568e29)),
            ("1E400", None),
            ("1E-400", Some(0.0)),
            ("1.E", None),
            ("1.5E2.", None),
            ("1-2", None),
            ("--1", None),
            (".", None),
            ("", None),
            ("-", None),
        ] {
            assert_eq!(real(text.as_bytes()).map(f64::to_bits), value.map(f64::to_bits), "{text}");
        }
    }

    proptest! {
        #[test]
        fn nearest_doubles(whole in "[+-]?[0-9]{1,12}", fraction in "(\\.[0-9]{0,12})?", power in "(E[+-]?[0-9]{1,3})?") {
            let text = whole + &fraction + &power;
            let wanted = text.parse::<f64>().ok().filter(|x| x.is_finite());
            prop_assert_eq!(real(text.as_bytes()).map(f64::to_bits), wanted.map(f64::to_bits));
        }
    }
}
