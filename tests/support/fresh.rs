//! Committed files that are made by a program: `HALFPIXEL_UPDATE=1 cargo test` writes them anew.

use std::path::Path;
use std::{env, fs};

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Fails where a committed file is not this text, unless it is to be written.
pub fn agrees(file: &str, text: &str) {
    let path = root().join(file);
    if env::var_os("HALFPIXEL_UPDATE").is_some() {
        fs::write(&path, text).unwrap_or_else(|e| panic!("cannot write {file}: {e}"));
    }
    let committed = fs::read_to_string(&path).unwrap_or_default();
    let difference = committed.lines().zip(text.lines()).find(|(old, new)| old != new);
    assert!(committed == text, "{file} is stale ({difference:#?}): run HALFPIXEL_UPDATE=1 cargo test, and commit it");
}
