//! Sixty files of a real library (bench/library_sample.txt): every face of the text is read.

use halfpixel::import;
use halfpixel::scene::{ViewSpec, prepare};
use halfpixel::stages::{Options, Renderer};
use halfpixel::verify::{Sampling, verify};
use std::path::{Path, PathBuf};

/// The folder that scripts/fetch_library.sh filled; says how to get it where there is none.
fn library() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let named = std::env::var_os("HALFPIXEL_LIBRARY").map(PathBuf::from);
    let folders = named.into_iter().chain(["target/library_sample", "target/library"].map(|f| root.join(f)));
    let found = folders.into_iter().find(|f| names().iter().all(|name| f.join(name).is_file()));
    if found.is_none() {
        eprintln!("skipped: run scripts/fetch_library.sh target/library_sample bench/library_sample.txt");
    }
    found
}

fn names() -> Vec<String> {
    let list = Path::new(env!("CARGO_MANIFEST_DIR")).join("bench/library_sample.txt");
    let text = std::fs::read_to_string(list).expect("bench/library_sample.txt");
    text.lines().map(str::to_owned).collect()
}

fn count(text: &[u8], word: &[u8]) -> usize {
    text.windows(word.len()).filter(|w| *w == word).count()
}

#[test]
fn every_face_of_the_sample_is_read() {
    let Some(folder) = library() else { return };
    let names = names();
    assert_eq!(names.len(), 60);
    let mut wrong = String::new();
    for name in names {
        let path = folder.join(&name);
        let entities = count(&std::fs::read(&path).expect("a file of the sample"), b"ADVANCED_FACE");
        match import::load(&path.to_string_lossy()) {
            Ok(model) => {
                let faces: usize = model.parts.iter().map(|p| p.faces.len()).sum();
                for lost in &model.lost {
                    wrong += &format!("{name}: lost {:?}: {}\n", lost.entity, lost.message);
                }
                if faces != entities {
                    wrong += &format!("{name}: {faces} faces for {entities} ADVANCED_FACE\n");
                }
            }
            Err(error) => wrong += &format!("{error}\n"),
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// Files of the whole library that were wrong once, all pixels of the usual view.
#[test]
fn files_that_contradict_themselves_are_drawn_whole() {
    let folder = std::env::var_os("HALFPIXEL_LIBRARY").map(PathBuf::from);
    let folder = folder.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("target/library"));
    // Edges run against their loops, and the walls between show their backs.
    for name in ["Diode_THT.3dshapes/Diode_Bridge_GeneSiC_KBPC_T.step"] {
        let path = folder.join(name);
        if !path.is_file() {
            eprintln!("skipped: there is no {name} (scripts/fetch_library.sh target/library)");
            continue;
        }
        let model = import::load(&path.to_string_lossy()).expect(name);
        let scene = prepare(&model, &|_, _| {}).expect(name);
        let camera = ViewSpec { size: [400, 300], ..ViewSpec::default() }.camera(&scene.bounds).expect("a camera");
        let frame = Renderer::new(&scene).render(&camera, &Options::default()).expect("a frame");
        let pixels = |x, y| frame.pixel(x, y);
        let report = verify(&scene, &camera, &Options::default(), &pixels, &Sampling::default(), &|_, _| {});
        assert!(report.drawn > 10_000 && report.passed(), "{name}: {:?}", report.worst);
    }
}
