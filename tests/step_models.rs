//! Hard cases of reading STEP: small files in tests/models, with what each must come to by formula (cases.py there).

use halfpixel::import::{self, ImportError};
use halfpixel::model::{Face, Model, Part};
use halfpixel::scene::{self, View, ViewSpec};
use halfpixel::stages;
use halfpixel::verify::{Sampling, verify};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What expected.json says of a file; areas in square millimetres.
#[derive(Deserialize)]
struct Expected {
    note: String,
    faces: usize,
    unique_faces: usize,
    area: f64,
    relative_tolerance: f64,
    /// By the face's entity number; one instance.
    areas: BTreeMap<u32, f64>,
    bounds: Option<[[f64; 3]; 2]>,
    /// Words of each warning, in their order.
    warnings: Vec<String>,
    /// Faces.
    hidden: usize,
    lone_curves: usize,
    /// No trim curve is an approximation.
    exact: bool,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/models")
}

fn cases() -> BTreeMap<String, Expected> {
    let text = std::fs::read_to_string(folder().join("expected.json")).expect("tests/models/expected.json");
    serde_json::from_str(&text).expect("tests/models/expected.json")
}

fn load(name: &str) -> Result<Model, ImportError> {
    import::load(&folder().join(name).to_string_lossy())
}

/// Each case's complaints, one line each; empty when all is well.
fn complaints(judge: impl Fn(&Expected, &Model) -> Vec<String>) -> String {
    let mut text = String::new();
    for (name, expected) in cases() {
        let found = match load(&name) {
            Ok(model) => judge(&expected, &model),
            Err(error) => vec![error.to_string()],
        };
        for line in found {
            text += &format!("{name} ({}): {line}\n", expected.note);
        }
    }
    text
}

fn figures_area(model: &Model) -> f64 {
    model.measure(&|_done, _all| {}).total.value
}

fn face_area(face: &Face) -> f64 {
    figures_area(&Model::from_part("", Part { faces: vec![face.clone()], ..Part::default() }))
}

fn differs(found: f64, expected: f64, relative: f64) -> bool {
    // Also true where one is no number.
    found.is_nan() || (found - expected).abs() > relative * expected.abs()
}

#[test]
fn the_table_names_every_file() {
    let entries = std::fs::read_dir(folder()).expect("tests/models");
    let files = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned());
    let mut files: Vec<String> = files.filter(|name| name.ends_with(".step")).collect();
    files.sort();
    assert!(files.len() >= 71, "only {} files", files.len());
    assert_eq!(files, cases().into_keys().collect::<Vec<_>>());
}

#[test]
fn no_face_is_lost() {
    let wrong = complaints(|expected, model| {
        let figures = model.figures(&model.measure(&|_done, _all| {}));
        let mut lines: Vec<String> = model.lost.iter().map(|w| format!("lost {:?}: {}", w.entity, w.message)).collect();
        for (what, found, expected) in
            [("faces", figures.faces, expected.faces), ("unique faces", figures.unique_faces, expected.unique_faces)]
        {
            if found != expected {
                lines.push(format!("{found} {what} for {expected}"));
            }
        }
        lines
    });
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn areas_are_those_of_the_formulas() {
    let wrong = complaints(|expected, model| {
        let mut lines = Vec::new();
        let faces: Vec<&Face> = model.parts.iter().flat_map(|p| &p.faces).collect();
        for (&id, &area) in &expected.areas {
            let of_entity: Vec<f64> = faces.iter().filter(|f| f.id == id).map(|f| face_area(f)).collect();
            match of_entity[..] {
                [found] if !differs(found, area, expected.relative_tolerance) => {}
                _ => lines.push(format!("face #{id} has area {of_entity:?} for {area}")),
            }
        }
        let total = figures_area(model);
        if differs(total, expected.area, expected.relative_tolerance) {
            lines.push(format!("area {total} for {}", expected.area));
        }
        lines
    });
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn parts_stand_in_their_places() {
    let wrong = complaints(|expected, model| {
        let Some(bounds) = expected.bounds else { return vec![] };
        let found = model.bounds().map(|b| b.map(Into::<[f64; 3]>::into));
        let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-6);
        match found {
            Some([low, high]) if near(low, bounds[0]) && near(high, bounds[1]) => vec![],
            _ => vec![format!("the box is {found:?} for {bounds:?}")],
        }
    });
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn what_is_mended_or_approximated_is_said_and_nothing_else() {
    let wrong = complaints(|expected, model| {
        let found: Vec<&str> = model.warnings.iter().map(|w| w.message.as_str()).collect();
        let alike = found.len() == expected.warnings.len();
        let alike = alike && expected.warnings.iter().zip(&found).all(|(words, line)| line.contains(words.as_str()));
        if alike { vec![] } else { vec![format!("{found:?} for {:?}", expected.warnings)] }
    });
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn what_is_not_shown_is_counted() {
    let wrong = complaints(|expected, model| {
        let found = (model.unshown.hidden_faces, model.unshown.lone_curves);
        let expected = (expected.hidden, expected.lone_curves);
        if found == expected {
            vec![]
        } else {
            vec![format!("{found:?} hidden faces and lone curves for {expected:?}")]
        }
    });
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn images_that_are_rational_are_exact() {
    let wrong = complaints(|expected, model| {
        if !expected.exact {
            return vec![];
        }
        let faces = || model.parts.iter().flat_map(|p| &p.faces);
        let approximated = faces().filter(|f| f.approximation.curves > 0).map(|f| format!("#{} is approximated", f.id));
        let curves = faces().flat_map(|f| f.loops.iter()).flat_map(|l| &l.curves);
        let gap = curves.map(|c| c.gap).fold(0.0, f64::max);
        let far = (gap > 1e-13).then(|| format!("an edge is {gap:e} off its image"));
        approximated.chain(far).collect()
    });
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// Every pixel of small frames, near and far.
#[test]
fn frames_keep_the_contract() {
    let wrong = complaints(|_, model| {
        let scene = scene::prepare(model, &|_done, _all| {}).expect("a scene");
        let mut lines = Vec::new();
        for (view, zoom) in [(View::Iso, 1.0), (View::Bottom, 5.0)] {
            let spec = ViewSpec { size: [96, 72], view, zoom, ..ViewSpec::default() };
            let camera = spec.camera(&scene.bounds).expect("a camera");
            let options = stages::Options::default();
            let frame = stages::Renderer::new(&scene).render(&camera, &options).expect("a frame");
            let pixels = |x: u32, y: u32| frame.pixel(x, y);
            let report = verify(&scene, &camera, &options, &pixels, &Sampling::default(), &|_, _| {});
            let failures = [report.violations, report.cracks, report.covering_failures, report.depth_failures];
            if failures != [0; 4] || (zoom == 1.0 && report.drawn == 0) {
                lines.push(format!("{view:?} at {zoom}: {failures:?} of {} pixels", report.drawn));
            }
        }
        lines
    });
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn lengths_come_in_millimetres() {
    let wrong = complaints(|_, model| match model.unit.as_deref() {
        Some("mm") => vec![],
        other => vec![format!("the unit is {other:?}")],
    });
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn a_mirrored_part_is_an_instance() {
    let model = load("mapped_items.step").expect("mapped_items.step");
    assert_eq!(model.instances.len(), 2);
    assert_eq!(model.instances[0].part, model.instances[1].part, "the part is copied");
    let mut scales: Vec<f64> = model.instances.iter().map(|i| i.transform.matrix3.determinant()).collect();
    scales.sort_by(f64::total_cmp);
    assert!((scales[0] + 8.0).abs() < 1e-9 && (scales[1] - 1.0).abs() < 1e-9, "determinants {scales:?}");
}

#[test]
fn repeated_parts_are_not_copied() {
    let model = load("assembly_nested.step").expect("assembly_nested.step");
    let cubes = model.parts.iter().filter(|p| !p.faces.is_empty()).count();
    assert_eq!((cubes, model.instances.len()), (1, 6));
}

/// A file that ends early is an error, or a model that says what is missing; never a silent part of it.
#[test]
fn a_file_cut_off_says_so() {
    for name in ["cylinder_seam.step", "assembly_nested.step", "rational_closed_tube.step", "void.step"] {
        let bytes = std::fs::read(folder().join(name)).expect(name);
        let records = bytes.windows(5).position(|w| w == b"DATA;").expect("a data section");
        let last = bytes.windows(7).rposition(|w| w == b"ENDSEC;").expect("an end");
        for step in 0..=64 {
            let end = records + (last - records) * step / 64;
            if let Ok(model) = import::read(&bytes[..end], Path::new(name)) {
                let told = !(model.warnings.is_empty() && model.lost.is_empty());
                assert!(told, "{name} cut at byte {end} of {} is read without a word", bytes.len());
            }
        }
    }
}

#[test]
fn what_is_no_step_file_is_refused() {
    let read = |bytes: &[u8]| import::read(bytes, Path::new("x.step"));
    assert!(matches!(read(b""), Err(ImportError::Empty { .. })));
    assert!(matches!(read(b" \n\r\t "), Err(ImportError::Empty { .. })));
    assert!(matches!(read(b"a letter about ISO-10303-21;"), Err(ImportError::Unknown { .. })));
    assert!(matches!(read(&[0x89, b'P', b'N', b'G', 0, 1, 2]), Err(ImportError::Unknown { .. })));
    // It calls itself STEP, and nothing follows.
    assert!(read(b"ISO-10303-21;").is_err());
    assert!(
        read(b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n")
            .map_or(true, |m| { m.instances.is_empty() && !m.warnings.is_empty() })
    );
}
