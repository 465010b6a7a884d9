//! What a file hides, what it has besides faces, and references that lead elsewhere.

use crate::compose::{Text, Units, file, one_box};
use crate::{clean, faces, model, parse};
use halfpixel::import::load;

#[test]
fn hidden_places_of_a_part_are_counted_and_others_shown() {
    let mut text = Text::default();
    let items = text.two_places();
    let style = text.style([0.5; 3], items[1]);
    let plain = clean(&text.file());
    assert_eq!((plain.instances.len(), plain.unshown.hidden_faces), (2, 0));
    text.add(format_args!("INVISIBILITY((#{style}))"));
    let found = clean(&text.file());
    assert_eq!((found.instances.len(), found.unshown.hidden_faces), (1, 6));
    assert_eq!(found.instances[0].transform.translation.x, 0.0);
}

#[test]
fn a_file_that_hides_everything_says_so() {
    let mut text = one_box();
    let solid = text.lines().iter().position(|l| l.contains("MANIFOLD_SOLID_BREP")).expect("a solid") as u32 + 10;
    text.add(format_args!("INVISIBILITY((#{solid}))"));
    let error = parse(&text.file()).expect_err("nothing to show").to_string();
    assert!(error.contains("hides all of its 6 faces"), "{error}");
}

#[test]
fn hidden_faces_of_a_shell_and_layers_of_layers() {
    let mut text = Text::default();
    let (all, ..) = text.solid_of_faces();
    // A layer that is on itself must not be followed for ever.
    let own = text.next();
    text.add(format_args!("PRESENTATION_LAYER_ASSIGNMENT('','',(#{},#{own}))", all[2]));
    text.add(format_args!("INVISIBILITY((#{own},#{},#4000000))", all[3]));
    let found = model(&text.file());
    assert_eq!((faces(&found).len(), found.unshown.hidden_faces), (4, 2));
    assert!(faces(&found).iter().all(|f| f.id != all[2] && f.id != all[3]));
}

#[test]
fn references_to_other_files_are_counted() {
    let text = one_box();
    let section = "REFERENCE;\n#900=<other.stp#a>;\n#901=<other.stp#b>;\nENDSEC;\n";
    let found = model(&text.file().replace("DATA;", &format!("{section}DATA;")));
    assert_eq!(faces(&found).len(), 6);
    assert!(found.warnings[0].message.contains("2 entities stand in other files"), "{:?}", found.warnings);
}

/// A box, and a product whose shape stands in another file.
fn referring(file: &str) -> String {
    let mut text = one_box();
    let context = text.context(Units::Millimetres);
    let empty = text.representation(&[], context);
    let definition = text.product("elsewhere", empty);
    let document = text.add(format_args!("DOCUMENT_FILE('{file}','','',$,'',$)"));
    text.add(format_args!("APPLIED_DOCUMENT_REFERENCE(#{document},'',(#{definition}))"));
    text.file()
}

#[test]
fn files_that_refer_to_each_other_end() {
    let folder = std::env::temp_dir().join(format!("halfpixel-references-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    // Names may be those of another system, and only files beside the first one are opened.
    let files = [("a.step", r"C:\\parts\\B.STEP"), ("b.step", "../c.stp"), ("c.stp", "a.step")];
    for (name, to) in files {
        std::fs::write(folder.join(name), referring(to)).expect("a temporary file");
    }
    let found = load(&folder.join("a.step").to_string_lossy());
    std::fs::remove_dir_all(&folder).expect("removed");
    let found = found.expect("a model");
    assert_eq!((found.instances.len(), faces(&found).len()), (3, 18));
    let names: Vec<&str> = found.instances.iter().map(|i| i.name.as_str()).collect();
    assert!(names.iter().any(|name| name.matches("elsewhere").count() == 2), "{names:?}");
    assert_eq!(found.warnings.len(), 1, "{:?}", found.warnings);
    let message = &found.warnings[0].message;
    assert!(message.contains("c.stp: #") && message.ends_with("a.step, which refers to itself"), "{message}");
}

#[test]
fn bytes_without_a_file_open_no_other_one() {
    let found = model(&referring("Cargo.step"));
    let message = &found.warnings[0].message;
    assert!(message.contains("\"elsewhere\"") && message.contains("Cargo.step, which is not looked for"), "{message}");
}

#[test]
fn every_lost_item_is_told_once() {
    let mut text = one_box();
    let context = text.context(Units::Millimetres);
    let solids: Vec<u32> = (0..20_000).map(|_| text.add("SOLID_OF_NO_KIND('')")).collect();
    let twice: Vec<u32> = solids.iter().chain(&solids).copied().collect();
    text.representation(&twice, context);
    text.representation(&solids, context);
    let found = model(&file(&text.lines().concat()));
    assert_eq!(found.lost.len(), 20_000);
}
