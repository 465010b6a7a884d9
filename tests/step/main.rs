//! STEP files: small ones made here for what is hard, and the real ones.

#[path = "../support/mod.rs"]
mod support;

mod assemblies;
mod compose;
mod hidden;
mod mended;
mod parts;
mod real;
mod recolor;
mod syntax;
mod units;

use halfpixel::import::{ImportError, read};
use halfpixel::model::{Face, Model};
use std::path::Path;

fn parse(text: &str) -> Result<Model, ImportError> {
    read(text.as_bytes(), Path::new("folder/shape.any"))
}

fn model(text: &str) -> Model {
    parse(text).unwrap_or_else(|e| panic!("{e}\nin\n{text}"))
}

fn faces(model: &Model) -> Vec<&Face> {
    model.parts.iter().flat_map(|p| &p.faces).collect()
}

/// A model of which nothing is lost and nothing was mended.
fn clean(text: &str) -> Model {
    let model = model(text);
    assert!(model.lost.is_empty(), "{:?}", model.lost);
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    model
}

fn assert_box(model: &Model, low: [f64; 3], high: [f64; 3]) {
    let [found_low, found_high] = model.bounds().expect("a model with faces");
    let near = |a: glam::DVec3, b: [f64; 3]| a.abs_diff_eq(b.into(), 1e-6);
    assert!(near(found_low, low) && near(found_high, high), "{found_low} {found_high}");
}
