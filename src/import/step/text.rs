//! Strings (ISO 10303-21:2016, 6.4.3): `''`, `\\`, `\S\c`, `\Pc\`, `\X\hh`, `\X2\hhhh...\X0\` and `\X4\hhhhhhhh...\X0\`.

/// A string as it was meant, from the text between its quotes. Directives that are damaged stay as they are; line breaks
/// inside are no part of the string.
pub(super) fn decode(raw: &[u8]) -> String {
    let mut out = String::with_capacity(raw.len());
    let mut rest = raw;
    while let Some(&b) = rest.first() {
        let used = match b {
            b'\'' => {
                out.push('\'');
                1 + usize::from(rest.get(1) == Some(&b'\''))
            }
            b'\n' | b'\r' => 1,
            b'\\' => directive(rest, &mut out).unwrap_or_else(|| {
                out.push('\\');
                1
            }),
            // Newer files are UTF-8, and some write Latin-1 without saying so.
            0x80.. => {
                let (symbol, length) = utf8(rest).unwrap_or((char::from(b), 1));
                out.push(symbol);
                length
            }
            _ => {
                out.push(char::from(b));
                1
            }
        };
        rest = &rest[used..];
    }
    out
}

/// The directive that `rest` opens with; its length.
fn directive(rest: &[u8], out: &mut String) -> Option<usize> {
    match rest.get(1)? {
        b'\\' => {
            out.push('\\');
            Some(2)
        }
        b'S' if rest.get(2) == Some(&b'\\') => {
            out.push(char::from(rest.get(3)? | 0x80));
            Some(4)
        }
        // Which part of ISO 8859 \S\ means: the first is taken, as all writers do.
        b'P' if rest.get(3) == Some(&b'\\') => Some(4),
        b'X' => match rest.get(2)? {
            b'\\' => {
                out.push(char::from(u8::try_from(hex(rest.get(3..5)?)?).ok()?));
                Some(5)
            }
            b'2' => wide(rest, 4, out),
            b'4' => wide(rest, 8, out),
            _ => None,
        },
        _ => None,
    }
}

/// `\X2\...\X0\` (UTF-16) or `\X4\...\X0\` (UTF-32).
fn wide(rest: &[u8], digits: usize, out: &mut String) -> Option<usize> {
    let body = rest.get(4..).filter(|_| rest[3] == b'\\')?;
    let length = body.windows(4).position(|w| w == b"\\X0\\")?;
    // Files are wrapped at 80 columns, here too.
    let codes: Vec<u8> = body[..length].iter().copied().filter(|b| !b.is_ascii_whitespace()).collect();
    let codes: Option<Vec<u32>> = codes.chunks(digits).map(hex).collect();
    let codes = codes?;
    if digits == 4 {
        let units = codes.iter().map(|&c| c as u16);
        out.extend(char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)));
    } else {
        out.extend(codes.iter().map(|&c| char::from_u32(c).unwrap_or(char::REPLACEMENT_CHARACTER)));
    }
    Some(4 + length + 4)
}

fn hex(digits: &[u8]) -> Option<u32> {
    digits.iter().try_fold(0u32, |n, &b| n.checked_mul(16)?.checked_add(char::from(b).to_digit(16)?))
}

/// The UTF-8 symbol that `rest` opens with, and its length.
fn utf8(rest: &[u8]) -> Option<(char, usize)> {
    (2..=4).find_map(|n| {
        let symbol = std::str::from_utf8(rest.get(..n)?).ok()?.chars().next()?;
        Some((symbol, n))
    })
}
