//! Several files at once, parts, lists and lost faces, in the library and as a user meets them.

mod support;

use glam::{DAffine3, DVec3};
use halfpixel::import;
use halfpixel::model::{Instance, Layout, Model, PartError, Warning};
use serde_json::Value;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use support::bpt_text;

fn halfpixel(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_halfpixel"));
    command.args(arguments).stdin(Stdio::null()).output().expect("the program starts")
}

fn json(arguments: &[&str]) -> (Value, String) {
    let output = halfpixel(arguments);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {errors}");
    (serde_json::from_slice(&output.stdout).expect("one JSON value and nothing else"), errors)
}

fn fails(arguments: &[&str], status: i32) -> String {
    let output = halfpixel(arguments);
    assert_eq!(output.status.code(), Some(status), "{arguments:?}");
    assert!(output.stdout.is_empty());
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder of this test's own, removed when the test ends.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("halfpixel-library-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        Self(folder)
    }

    fn file(&self, name: &str, text: &str) -> String {
        let path = self.0.join(name);
        std::fs::write(&path, text).expect("a temporary file");
        path.to_string_lossy().into_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn builtin(name: &str) -> Model {
    import::load(&format!("builtin:{name}")).expect("a built-in model")
}

/// An assembly of a teapot (#10) and a sphere (#20), the sphere twice.
fn assembly() -> Model {
    let mut model = Model::join(vec![builtin("teapot"), builtin("sphere")], Layout::Overlay);
    let named = [("teapot", 10), ("Kugel", 20)];
    for (part, (name, id)) in model.parts.iter_mut().zip(named) {
        (part.name, part.id) = (name.into(), id);
        part.faces.iter_mut().zip(100 * id..).for_each(|(face, number)| face.id = number);
    }
    model.instances[1].name = "stand/ball 1".into();
    let transform = DAffine3::from_translation(DVec3::X);
    model.instances.push(Instance { part: 1, transform, name: "stand/ball 2".into(), ..Instance::default() });
    model
}

#[test]
fn parts_are_selected_by_name_instance_and_number() {
    let kept = |part: &str| {
        let model = assembly().select(part).unwrap_or_else(|e| panic!("{part}: {e}"));
        let names: Vec<String> = model.instances.iter().map(|i| model.parts[i.part].name.clone()).collect();
        (names.join(" "), model.parts.iter().map(|p| p.faces.len()).sum::<usize>())
    };
    let ball = builtin("sphere").parts[0].faces.len();
    assert_eq!(kept("Kugel"), ("Kugel Kugel".into(), ball));
    assert_eq!(kept("kugel"), ("Kugel Kugel".into(), ball));
    assert_eq!(kept("#20"), ("Kugel Kugel".into(), ball));
    assert_eq!(kept("ball 2"), ("Kugel".into(), ball));
    assert_eq!(kept("stand/ball 1"), ("Kugel".into(), ball));
    assert_eq!(kept("stand"), ("Kugel Kugel".into(), ball));
    assert_eq!(kept("teapot"), ("teapot".into(), 32));
    assert_eq!(kept("#1003"), ("teapot".into(), 1));
    let near = "near it are: #10 (teapot), #20 (Kugel)";
    for id in ["5", "0", "x"] {
        let expected = PartError::NoEntity { id: id.into(), near: near.into() };
        assert_eq!(assembly().select(&format!("#{id}")).unwrap_err(), expected);
    }
    let error = assembly().select("kettle of tea").unwrap_err().to_string();
    assert!(error.contains("there are: Kugel, ball 1, ball 2, "), "{error}");
    let error = assembly().select("teapod").unwrap_err().to_string();
    assert!(error.contains("near it are: teapot"), "{error}");
}

#[test]
fn a_grid_keeps_models_apart_and_in_order() {
    let names = ["teapot", "sphere", "teapot", "sphere", "sphere", "teapot", "sphere"];
    let joined = Model::join(names.map(builtin).into(), Layout::Grid);
    assert_eq!((joined.parts.len(), joined.instances.len()), (7, 7));
    let boxes: Vec<[DVec3; 2]> = (0..7)
        .map(|k| Model { instances: vec![joined.instances[k].clone()], ..joined.clone() }.bounds().expect("a box"))
        .collect();
    for (a, b) in (0..7).flat_map(|a| (0..a).map(move |b| (a, b))) {
        let apart = (0..2).any(|k| boxes[a][0][k] > boxes[b][1][k] || boxes[b][0][k] > boxes[a][1][k]);
        assert!(apart, "{a} {:?} and {b} {:?}", boxes[a], boxes[b]);
        // Reading order: in the same row to the right, or in a row before.
        assert!(boxes[a][0].x > boxes[b][1].x || boxes[a][1].y <= boxes[b][0].y, "{a} after {b}");
    }
    assert!(boxes.iter().all(|b| b[0].z.abs() < 1e-12), "all stand on z = 0");
    let [low, high] = joined.bounds().expect("a box");
    let size = high - low;
    assert!(size.x / size.y < 2.5 && size.y / size.x < 2.5, "near a square: {size}");
    let overlay = Model::join(names.map(builtin).into(), Layout::Overlay);
    let teapot = builtin("teapot").bounds().expect("a box");
    assert_eq!(overlay.instances[2].transform, builtin("teapot").instances[0].transform);
    assert!(overlay.bounds().expect("a box")[1].x <= teapot[1].x.max(1.0));
    assert!(Model::join(Vec::new(), Layout::Grid).bounds().is_none());
}

#[test]
fn units_that_differ_are_a_warning() {
    let in_unit = |unit: Option<&str>| Model { unit: unit.map(Into::into), ..builtin("sphere") };
    let same = Model::join(vec![in_unit(Some("mm")), in_unit(Some("mm"))], Layout::Overlay);
    assert_eq!((same.unit.as_deref(), same.warnings.len()), (Some("mm"), 0));
    let mixed = Model::join(vec![in_unit(Some("mm")), in_unit(None)], Layout::Overlay);
    assert_eq!((mixed.unit.as_deref(), mixed.warnings.len()), (None, 1));
}

#[test]
fn figures_count_what_is_lost_and_the_faces_are_listed() {
    let mut model = assembly();
    model.lost.push(Warning { entity: Some(77), message: "no surface".into() });
    model.warnings.push(Warning { entity: Some(1003), message: "#1003: mended".into() });
    let areas = model.measure(&|_, _| {});
    let figures = model.figures(&areas);
    let ball = builtin("sphere").parts[0].faces.len();
    assert_eq!((figures.faces, figures.unique_faces, figures.lost_faces), (32 + 2 * ball, 32 + ball, 1));
    assert_eq!(figures.surface_types.values().sum::<usize>(), figures.unique_faces);
    let list = model.list_faces(&areas);
    assert_eq!(list.len(), figures.unique_faces);
    let one = list.iter().find(|f| f.entity == 1003).expect("listed");
    assert_eq!((one.part.as_str(), one.warnings.len()), ("teapot", 1));
    let sum = |part: &str| list.iter().filter(|f| f.part == part).map(|f| f.area).sum::<f64>();
    assert!((sum("Kugel") / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-7);
    assert!((sum("teapot") + 2.0 * sum("Kugel") - figures.area).abs() < 1e-9 * figures.area);
}

#[test]
fn lists_of_files_are_read_and_what_is_wrong_in_them_is_counted() {
    let folder = Folder::new("lists");
    let (a, b) = (folder.file("a.bpt", &bpt_text(3)), folder.file("b.bpt", &bpt_text(5)));
    let empty = folder.file("empty.bpt", "");
    let list = format!("@{}", folder.file("list.txt", &format!("# two files\n{a}\n\n  {b}  \n")));
    let (info, errors) = json(&["info", "--json", &list]);
    assert_eq!((&info["faces"], &info["files"], errors.as_str()), (&8.into(), &2.into(), ""));
    let (info, errors) = json(&["info", "--json", &list, &empty, "/nowhere.bpt", "builtin:teapot"]);
    assert_eq!((&info["faces"], &info["files"]), (&40.into(), &5.into()));
    assert_eq!(info["unread_files"].as_array().map(Vec::len), Some(2));
    assert!(errors.contains("2 of 5 files can't be read") && errors.lines().count() == 1, "{errors}");
    assert!(fails(&["info", "--strict", &list, &empty], 1).contains("1 of 3 files"));
    assert!(fails(&["info", &empty, "/nowhere.bpt"], 1).contains("2 of 2 files"));
    assert!(fails(&["info", "@/nowhere.txt"], 1).contains("the list of files"));
    let nothing = format!("@{}", folder.file("nothing.txt", "# none\n"));
    assert!(fails(&["info", &nothing], 1).contains("names no file"));
    fails(&["info", &a, "builtin:nonsense"], 2);
}

#[test]
fn several_files_make_one_picture_that_keeps_the_contract() {
    let common =
        ["builtin:teapot", "builtin:sphere", "--layout", "grid", "--size", "160x120", "--view", "top", "--json"];
    let (report, _) = json(&[&["verify"], &common[..]].concat());
    assert_eq!((&report["violations"], &report["cracks"], &report["files"]), (&0.into(), &0.into(), &2.into()));
    assert!(report["drawn"].as_u64() > Some(1500), "{report}");
    let folder = Folder::new("picture");
    let picture = folder.file("a.png", "");
    let (report, _) = json(&[&["render"], &common[..], &["-o", &picture]].concat());
    assert_eq!((&report["patches"], &report["lost_faces"]), (&40.into(), &0.into()));
}

#[test]
fn one_part_is_looked_at_alone() {
    let (info, _) = json(&["info", "builtin:teapot", "builtin:sphere", "--part", "sphere", "--json", "--faces"]);
    let faces = info["face_list"].as_array().expect("a list").clone();
    assert_eq!(Value::from(faces.len()), info["unique_faces"]);
    assert!(faces.iter().all(|f| f["surface"].is_string() && f["area_relative_error"].is_number()));
    let (one, _) = json(&["info", "builtin:teapot", "--part", "#5", "--json", "--faces"]);
    assert_eq!((&one["faces"], &one["face_list"][0]["entity"]), (&1.into(), &5.into()));
    assert!(fails(&["info", "builtin:teapot", "--part", "lid of gold"], 1).contains("named \"lid of gold\""));
    let table = String::from_utf8_lossy(&halfpixel(&["info", "builtin:teapot", "--faces"]).stdout).into_owned();
    assert!(table.contains("#31 bezier, 1 patches, 0 loops"), "{table}");
}
