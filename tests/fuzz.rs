//! Damaged files: whatever the bytes, a model or an error, never a panic, and memory in proportion to the file.

#[path = "step/compose.rs"]
mod compose;
mod support;

use halfpixel::import::{ImportError, read};
use halfpixel::model::Model;
use std::path::Path;
use support::random::Random;
use support::{bpt_text, bv_text};

/// Enough to be thousands of cases and a few seconds.
const CASES: usize = 6000;
/// STEP files are longer and mean more.
const STEP_CASES: usize = 1000;

fn parse(bytes: &[u8]) -> Result<Model, ImportError> {
    read(bytes, Path::new("fuzz"))
}

/// Checks what holds for every model that a reader gives: finite points, positive weights, memory the file paid for.
fn check(bytes: &[u8], what: &str) {
    match parse(bytes) {
        Ok(model) => {
            let faces = model.parts.iter().flat_map(|p| &p.faces);
            let points: Vec<_> = faces.flat_map(|f| &f.surface.patches).flat_map(|p| p.patch.points()).collect();
            assert!(!points.is_empty(), "{what}: a model without points");
            assert!(points.iter().all(|p| p.is_finite() && p.w > 0.0), "{what}: a point that is no point");
            // A triangle of degree 63 takes twice the points it has; a point takes five bytes or more.
            assert!(points.len() <= bytes.len(), "{what}: {} points from {} bytes", points.len(), bytes.len());
            assert!(model.warnings.len() <= bytes.len(), "{what}: more warnings than bytes");
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.starts_with("fuzz: ") && message.len() < 500, "{what}: {message:?}");
            assert!(!message.contains(['\n', '\r']), "{what}: more than one line: {message:?}");
        }
    }
}

/// The same for STEP, where a formula of a few bytes makes many points.
fn check_step(bytes: &[u8], what: &str) {
    match parse(bytes) {
        Ok(model) => {
            let faces = model.parts.iter().flat_map(|p| &p.faces);
            let points: Vec<_> = faces.flat_map(|f| &f.surface.patches).flat_map(|p| p.patch.points()).collect();
            assert!(points.iter().all(|p| p.is_finite() && p.w > 0.0), "{what}: a point that is no point");
            assert!(points.len() <= 64 * bytes.len(), "{what}: {} points from {} bytes", points.len(), bytes.len());
            assert!(model.warnings.len() + model.lost.len() <= bytes.len(), "{what}: more warnings than bytes");
            let instances = model.instances.iter();
            assert!(instances.clone().all(|i| i.transform.is_finite() && i.part < model.parts.len()), "{what}");
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.starts_with("fuzz: ") && message.len() < 600, "{what}: {message:?}");
            assert!(!message.contains(['\n', '\r']), "{what}: more than one line: {message:?}");
        }
    }
}

/// Words that number readers get wrong.
const WORDS: [&str; 20] = [
    "",
    "-",
    "+",
    ".",
    "e",
    "nan",
    "inf",
    "-inf",
    "1e999",
    "-1e-999",
    "0x10",
    "1_000",
    "4294967295",
    "4294967296",
    "18446744073709551616",
    "-1",
    "1e308",
    "1,5",
    "group",
    "\u{fffd}",
];

fn mutate(random: &mut Random, bytes: &mut Vec<u8>) {
    let at = random.below(bytes.len());
    match random.below(6) {
        0 => {
            if let Some(byte) = bytes.get_mut(at) {
                *byte ^= 1 << random.below(8);
            }
        }
        1 => bytes.truncate(at),
        2 => replace_word(random, bytes, at),
        3 => {
            let end = (at + random.below(200)).min(bytes.len());
            bytes.drain(at..end);
        }
        4 => {
            let end = (at + random.below(200)).min(bytes.len());
            let copy = bytes[at..end].to_vec();
            let to = random.below(bytes.len());
            bytes.splice(to..to, copy);
        }
        _ => {
            let byte = random.below(256) as u8;
            bytes.insert(at, byte);
        }
    }
}

/// Puts another word where the one at `at` stands.
fn replace_word(random: &mut Random, bytes: &mut Vec<u8>, at: usize) {
    let white = |b: &u8| b.is_ascii_whitespace();
    let start = bytes[..at].iter().rposition(white).map_or(0, |k| k + 1);
    let end = bytes[at..].iter().position(white).map_or(bytes.len(), |k| at + k);
    if start <= end {
        let word = WORDS[random.below(WORDS.len())];
        bytes.splice(start..end, word.bytes());
    }
}

fn fuzz(seed: u64, text: &str) {
    let mut random = Random(seed);
    let mut models = 0;
    for case in 0..CASES {
        let mut bytes = text.as_bytes().to_vec();
        for _ in 0..=random.below(4) {
            mutate(&mut random, &mut bytes);
        }
        models += usize::from(parse(&bytes).is_ok());
        check(&bytes, &format!("seed {seed}, case {case}"));
    }
    // Neither all nor none: else the damage says nothing about the readers.
    assert!(models > CASES / 100 && models < CASES, "{models} of {CASES} gave a model");
}

#[test]
fn damaged_bpt() {
    fuzz(1, &bpt_text(3));
    fuzz(2, &bpt_text(7));
}

#[test]
fn damaged_bezierview() {
    fuzz(3, &bv_text());
    fuzz(4, &bv_text().replace('\n', "\r\n"));
}

#[test]
fn damaged_step() {
    let text = compose::mixture().file();
    let mut random = Random(6);
    for case in 0..STEP_CASES {
        let mut bytes = text.clone().into_bytes();
        for _ in 0..=random.below(8) {
            if random.below(2) == 0 { mutate(&mut random, &mut bytes) } else { replace_token(&mut random, &mut bytes) }
        }
        check_step(&bytes, &format!("case {case}"));
    }
}

/// The hard cases in tests/models: every kind of entity.
#[test]
fn damaged_models() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/models");
    let entries = std::fs::read_dir(&folder).expect("tests/models").map(|entry| entry.expect("an entry").path());
    let mut files: Vec<_> = entries.filter(|path| path.extension().is_some_and(|e| e == "step")).collect();
    files.sort();
    let mut random = Random(8);
    for case in 0..STEP_CASES {
        let file = &files[case % files.len()];
        let mut bytes = std::fs::read(file).expect("a model");
        for _ in 0..=random.below(4) {
            if random.below(4) == 0 { mutate(&mut random, &mut bytes) } else { replace_token(&mut random, &mut bytes) }
        }
        check_step(&bytes, &format!("case {case}, {}", file.display()));
    }
}

/// Puts another reference or number where one stands: most of a STEP file is these.
fn replace_token(random: &mut Random, bytes: &mut Vec<u8>) {
    const NUMBERS: [&str; 12] =
        ["0.", "-1.", "1.E30", "1.E-30", "1.E300", "90.", "1.5", "$", "*", "()", "-0.", "123456789"];
    let at = random.below(bytes.len());
    let part = |b: &u8| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'#');
    let Some(start) = bytes[at..].iter().position(part).map(|k| at + k) else { return };
    let length = bytes[start..].iter().take_while(|b| part(b)).count();
    let put = if bytes[start] == b'#' {
        format!("#{}", 10 + random.below(400))
    } else {
        NUMBERS[random.below(NUMBERS.len())].to_owned()
    };
    bytes.splice(start..start + length, put.bytes());
}

#[test]
fn every_prefix() {
    for text in [bpt_text(2), bv_text()] {
        for end in 0..text.len() {
            check(&text.as_bytes()[..end], &format!("the first {end} bytes"));
        }
    }
}

#[test]
fn every_count_huge() {
    for text in [bpt_text(2), bv_text()] {
        let words: Vec<_> = text.split_inclusive(char::is_whitespace).collect();
        for (index, word) in words.iter().enumerate().filter(|(_, w)| w.trim().parse::<u32>().is_ok()) {
            for huge in ["63", "64", "65535", "4294967295", "4294967296", "18446744073709551615"] {
                let mut changed = words.clone();
                let put = format!("{huge}{}", &word[word.trim_end().len()..]);
                changed[index] = &put;
                check(changed.concat().as_bytes(), &format!("word {index} is {huge}"));
            }
        }
    }
}

#[test]
fn noise() {
    let mut random = Random(5);
    for case in 0..2000 {
        let length = random.below(400);
        let mut bytes: Vec<u8> = match case % 3 {
            0 => (0..length).map(|_| random.below(256) as u8).collect(),
            1 => (0..length).map(|_| b"0123456789 .-e\n\r"[random.below(16)]).collect(),
            _ => b"8\n2 2\n".to_vec(),
        };
        bytes.extend((0..random.below(60)).flat_map(|_| b"3 1 "[random.below(3)..].to_vec()));
        check(&bytes, &format!("noise {case}"));
    }
}
