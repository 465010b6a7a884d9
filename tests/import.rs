//! Readers: what they take over, what they say of the rest, and where.

mod support;

use glam::{DVec3, DVec4};
use halfpixel::import::{ImportError, load, read};
use halfpixel::model::Model;
use std::path::Path;
use support::{bpt_text, bv_text, numbers, real_model};

fn parse(text: &str) -> Result<Model, ImportError> {
    read(text.as_bytes(), Path::new("folder/shape.any"))
}

fn model(text: &str) -> Model {
    parse(text).unwrap_or_else(|e| panic!("{e}\nin\n{text}"))
}

fn error(text: &str) -> String {
    parse(text).expect_err(text).to_string()
}

fn points(model: &Model, face: usize) -> &[DVec4] {
    model.parts[0].faces[face].surface.patches[0].patch.points()
}

fn degrees(model: &Model) -> Vec<[usize; 2]> {
    model.parts[0].faces.iter().map(|f| f.surface.patches[0].patch.degree()).collect()
}

const TWO: &str = "2\n1 1\n0 0 0\n0 1 0\n1 0 0\n1 1 .5\n2 1\n0 0 1\n0 1 1\n1 0 1\n1 1 1\n2 0 1e0\n2 1 +1\n";

#[test]
fn bpt_holds_degrees_and_points_with_u_outermost() {
    let model = model(TWO);
    assert_eq!(degrees(&model), [[1, 1], [2, 1]]);
    assert_eq!(model.name, "shape");
    assert_eq!(model.instances.len(), 1);
    assert!(model.warnings.is_empty());
    assert_eq!(points(&model, 0)[1], DVec4::new(0.0, 1.0, 0.0, 1.0));
    assert_eq!(points(&model, 1)[4], DVec4::new(2.0, 0.0, 1.0, 1.0));
    // (u, v) = (1, 0) is the last row's first point.
    let corner = model.parts[0].faces[0].surface.patches[0].patch.net().position(1.0, 0.0);
    assert_eq!(corner, DVec3::X);
    assert_eq!(model.parts[0].faces[1].id, 1);
}

#[test]
fn line_ends_byte_order_mark_and_missing_last_break_change_nothing() {
    let expected = points(&model(TWO), 1).to_vec();
    for text in [TWO.replace('\n', "\r\n"), TWO.replace('\n', "\r"), format!("\u{feff}{TWO}"), TWO.trim().to_owned()] {
        let found = model(&text);
        assert_eq!(points(&found, 1), expected, "{text:?}");
        assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    }
}

#[test]
fn errors_name_file_line_and_word() {
    for text in [TWO.replace("1 0 1\n", "1 zero 1\n"), TWO.replace("1 0 1\n", "1 zero 1\n").replace('\n', "\r\n")] {
        assert_eq!(error(&text), "folder/shape.any: line 10: expected a finite number, found \"zero\"");
    }
    let line_4 = |bad: &str| error(&TWO.replacen("0 1 0\n", bad, 1));
    assert!(line_4("0 nan 0\n").contains("line 4: expected a finite number, found \"nan\""));
    assert!(line_4("0 1e999 0\n").contains("line 4: expected a finite number, found \"1e999\""));
    assert!(error(&TWO.replace("2 1\n0 0 1", "2 -1\n0 0 1")).contains("line 7: expected a patch's degree"));
    let long = "x".repeat(5000);
    assert!(line_4(&long).len() < 150, "a long word is cut");
}

#[test]
fn a_file_cut_short_gives_what_is_complete_and_says_so() {
    let whole = bpt_text(40);
    let cut = model(&whole[..whole.len() / 2]);
    let kept = cut.parts[0].faces.len();
    assert!((18..=20).contains(&kept), "{kept}");
    assert_eq!(cut.warnings.len(), 1);
    let message = &cut.warnings[0].message;
    assert!(message.contains(&format!("ends inside patch {kept}; {kept} complete ones")), "{message}");
    assert!(message.contains("line "), "{message}");
    // Inside the first patch nothing is complete.
    assert!(error(&whole[..100]).contains("no patch could be read"), "{}", error(&whole[..100]));
    assert!(error("12\n").contains("no patch could be read"));
}

#[test]
fn a_number_that_the_cut_shortened_is_not_taken() {
    let whole = bpt_text(3);
    // Within the last number of the first patch: "0.150000" may have lost digits.
    let end = whole.match_indices("3 3\n").nth(1).map_or(0, |(at, _)| at);
    let cut = parse(&whole[..end - 3]);
    assert!(cut.is_err(), "the only patch is not known to be complete");
    let cut = model(&whole[..end]);
    assert_eq!(cut.parts[0].faces.len(), 1);
}

#[test]
fn more_data_than_declared_is_said() {
    let model = model(&bpt_text(3).replacen('3', "2", 1));
    assert_eq!(model.parts[0].faces.len(), 2);
    assert!(model.warnings[0].message.starts_with("line 36: more data follows the 2 patches"), "{:?}", model.warnings);
}

#[test]
fn huge_counts_need_no_memory() {
    for text in [
        "4000000000\n3 3\n0 0 0\n",
        "2\n4000000000 4000000000\n0 0 0\n",
        "5\n4000000000 4000000000\n0 0 0\n",
        "8\n4294967295 4294967295\n0 0 0 1\n",
        "3\n4294967295\n0 0 0\n",
        "10\n4294967295 4294967295 4294967295 4294967295\n0 0 0\n",
        "1\n4294967295 4294967295\n0 0 0\n",
    ] {
        assert!(error(text).contains("no patch could be read"), "{}", error(text));
    }
    assert!(error("99999999999999999999\n3 3\n").contains("no known format"));
}

#[test]
fn impossible_patches_are_left_out_by_name() {
    let text = format!("3\n0 2\n{}64 1\n{}1 1\n{}", numbers(3, 3), numbers(130, 3), numbers(4, 3));
    let found = model(&text);
    assert_eq!(degrees(&found), [[1, 1]]);
    assert_eq!(found.parts[0].faces[0].id, 2, "numbers are those of the file");
    let messages: Vec<_> = found.warnings.iter().map(|w| w.message.as_str()).collect();
    assert_eq!(messages[0], "line 2: patch 0 is left out: degree 0 is outside 1 to 63");
    assert_eq!(messages[1], "line 6: patch 1 is left out: degree 64 is outside 1 to 63");
    assert_eq!(found.warnings[1].entity, Some(6));

    let negative = format!("8\n1 1\n{}8\n1 1\n1 1 1 1\n2 2 2 -1\n3 3 3 1\n4 4 4 1\n", numbers(4, 4));
    let found = model(&negative);
    assert_eq!(found.parts[0].faces.len(), 1);
    assert!(found.warnings[0].message.contains("weight of control point 1 is -1"), "{:?}", found.warnings);
    let only = error("8\n1 1\n1 1 1 1\n2 2 2 0\n3 3 3 1\n4 4 4 1\n");
    assert!(only.contains("weight of control point 1 is 0"), "{only}");
}

#[test]
fn bezierview_kinds_groups_and_what_is_left_out() {
    let model = model(&bv_text());
    let faces = &model.parts[0].faces;
    assert_eq!(degrees(&model), [[2, 2], [1, 2], [1, 1], [2, 2]]);
    let names: Vec<_> = faces.iter().map(|f| &*f.name).collect();
    assert_eq!(names, ["body", "the lid", "the lid", ""]);
    assert!(faces[0].color.is_some() && faces[1].color == faces[2].color);
    assert!(faces[0].color != faces[1].color && faces[1].color != faces[3].color);
    // Kind 8 is homogeneous already.
    assert_eq!(points(&model, 2)[0], DVec4::new(1.0, 1.25, 1.5, 1.75));
    let messages: Vec<_> = model.warnings.iter().map(|w| w.message.as_str()).collect();
    assert_eq!(messages.len(), 3);
    for (message, (line, kind)) in messages.iter().zip([(28, "kind 1"), (45, "kind 9"), (53, "kind 10")]) {
        assert!(message.starts_with(&format!("line {line}: ")) && message.contains(kind), "{message}");
        assert!(message.contains("(1 in the file"), "{message}");
    }
    assert!(error("1\n3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").contains("polyhedra (kind 1) are left out"));
    assert!(error(&format!("4\n2\n{}7\n", numbers(9, 3))).contains("line 12: there is no kind 7"));
    assert!(model_without_group().is_none());
}

fn model_without_group() -> Option<[f32; 3]> {
    model(&format!("4\n2\n{}", numbers(9, 3))).parts[0].faces[0].color
}

#[test]
fn a_bezier_triangle_is_the_same_surface() {
    // x = 1 - s - t, y = s t, z = t^2 in barycentric coordinates (r, s, t), degree 2: rows r-s, then t.
    let text = "3\n2\n1 0 0\n.5 0 0\n0 0 0\n.5 0 0\n0 .5 0\n0 0 1\n";
    let model = model(text);
    let net = model.parts[0].faces[0].surface.patches[0].patch.net();
    for (u, v) in (0..=10).flat_map(|i| (0..=10).map(move |j| (f64::from(i) / 10.0, f64::from(j) / 10.0))) {
        let (r, s, t) = (1.0 - u, u * (1.0 - v), u * v);
        let exact = DVec3::new(r, s * t, t * t);
        assert!((net.position(u, v) - exact).length() < 1e-15 * 4.0, "at {u} {v}");
    }
}

/// The two formats open with the same numbers where a `.bpt` declares as many patches as a kind is called.
#[test]
fn formats_that_open_alike_are_told_apart() {
    for count in [1, 3, 4, 5, 8, 9, 10, 11] {
        for degree in ["1 1", "2 2", "3 3"] {
            let side = degree.len() - 2 + degree[..1].parse::<usize>().unwrap_or(0);
            let text: String = (0..count)
                .map(|_| format!("{degree}\n{}", numbers(side * side, 3).replace(".25", "").replace(".5", "")))
                .collect();
            let found = model(&format!("{count}\n{text}"));
            assert_eq!(found.parts[0].faces.len(), count, "{count} patches of {degree}");
            assert!(found.warnings.is_empty(), "{:?}", found.warnings);
        }
    }
    for (header, width) in [("5\n1 1\n", 3), ("8\n1 1\n", 4), ("4\n1\n", 3)] {
        for segments in 1..4 {
            let whole = |t: String| t.replace(".25", "").replace(".5", "").replace(".75", "");
            let text = (0..segments).map(|_| format!("{header}{}", whole(numbers(4, width)))).collect::<String>();
            let found = model(&text);
            assert_eq!(found.parts[0].faces.len(), segments, "{text}");
            assert!(found.warnings.is_empty(), "{:?}", found.warnings);
        }
    }
}

#[test]
fn other_formats_are_named() {
    let iges = format!("{:72}S      1\n{:72}G      1\n", "a part", "1H,,1H;");
    for (text, name) in [
        (iges.as_str(), "IGES"),
        ("3D Geometry File Format        4", "3DM"),
        ("# a comment\ncstype rat bspline\n", "OBJ"),
        ("# a comment\n\nv 0 0 0\n", "OBJ"),
        ("#X3D V3.0 utf8\n", "X3D"),
        ("DBRep_DrawableShape\n", "BREP"),
    ] {
        let message = error(text);
        assert!(message.contains(&format!("{name} ")) || message.contains(name), "{message}");
        assert!(message.contains("not read yet") && message.contains(".bpt, BezierView .bv"), "{message}");
    }
    for text in ["hello", "\u{0}\u{1}\u{2}", "-3\n", "12 apples", "1.5 2 3", "<html>", "group", "#", "{}"] {
        let message = error(text);
        assert!(message.starts_with("folder/shape.any: "), "{message}");
    }
    assert!(error("hello").contains("no known format; what can be read: STEP, .bpt, BezierView .bv"));
    for text in ["", " \n\r\n\t"] {
        assert!(error(text).contains("empty"));
    }
}

#[test]
fn missing_files_folders_and_built_in_models() {
    assert!(matches!(load("/nowhere/at/all.bpt"), Err(ImportError::Io { .. })));
    assert!(matches!(load("."), Err(ImportError::Io { .. })));
    assert!(matches!(load("builtin:nothing"), Err(ImportError::Builtin(_))));
    assert_eq!(load("builtin:teapot").map(|m| m.parts[0].faces.len()).ok(), Some(32));
}

#[test]
fn real_files() -> Result<(), ImportError> {
    let expected = [("teapot.bpt", 32), ("killeroo.bpt", 11532), ("sphere.bv", 24), ("tri1.bv", 3), ("twg2.bv", 288)];
    for (name, faces) in expected {
        let Some(path) = real_model(name) else { continue };
        let start = std::time::Instant::now();
        let model = load(&path.to_string_lossy())?;
        let ms = start.elapsed().as_secs_f64() * 1e3;
        println!("{name}: {faces} faces in {ms:.1} ms");
        assert_eq!(model.parts[0].faces.len(), faces, "{name}");
        assert!(model.warnings.is_empty(), "{name}: {:?}", model.warnings);
        if name == "sphere.bv" {
            for (face, k) in model.parts[0].faces.iter().flat_map(|f| (0..9).map(move |k| (f, k))) {
                let (u, v) = (f64::from(k % 3) / 2.0, f64::from(k / 3) / 2.0);
                let radius = face.surface.patches[0].patch.net().position(u, v).length();
                assert!((radius - 1.0).abs() < 1e-8, "{radius}");
            }
        }
    }
    Ok(())
}
