//! What the text may look like, and what is kept of a damaged one.

use crate::compose::{Text, Units, file, one_box};
use crate::{clean, faces, model, parse};

#[test]
fn comments_and_white_space_anywhere() {
    let text = one_box().file();
    let plain = clean(&text);
    assert_eq!(faces(&plain).len(), 6);
    let spaced = text.replace('=', " = /**/ ").replace('(', " /* ; #1=X('*/ ( ").replace(',', "\r\n,\t");
    // Comments and white space may not come between the tokens of the header's strings; none are there.
    let spaced = format!(" \n/* first; 'unclosed */\r\n{spaced}");
    assert_eq!(faces(&clean(&spaced)).len(), 6);
    let one_line = text.replace('\n', "");
    assert_eq!(faces(&clean(&one_line)).len(), 6);
    assert_eq!(faces(&clean(&format!("\u{feff}{text}"))).len(), 6);
}

#[test]
fn entities_in_any_order_and_several_sections() {
    let mut lines = one_box().lines().to_vec();
    lines.reverse();
    assert_eq!(faces(&clean(&file(&lines.concat()))).len(), 6);
    let (one, two) = lines.split_at(lines.len() / 2);
    let sections = format!("{}ENDSEC;\nDATA('second',('SCHEMA'));\n{}", one.concat(), two.concat());
    assert_eq!(faces(&clean(&file(&sections))).len(), 6);
}

#[test]
fn numbers_far_apart() {
    let text = one_box().file().replace('#', "#41234");
    assert_eq!(faces(&clean(&text)).len(), 6);
}

#[test]
fn strings_are_decoded() {
    for (raw, meant) in [
        ("it''s", "it's"),
        (r"a\\b", r"a\b"),
        (r"\X\E9t\X\E9", "été"),
        (r"\X2\03B103B2\X0\!", "αβ!"),
        (r"\X2\D83DDE00\X0\", "😀"),
        (r"\X4\0001F600\X0\", "😀"),
        (r"\S\d", "ä"),
        (r"\PA\x", "x"),
        (r"\X2\zz\X0\", r"\X2\zz\X0\"),
        (r"C:\new", r"C:\new"),
        ("a;/* b */#1=", "a;/* b */#1="),
        ("wrap\nped", "wrapped"),
        ("naïve", "naïve"),
        ("", ""),
    ] {
        let text = one_box().file().replace("face 0 0", raw);
        assert_eq!(faces(&clean(&text))[0].name.as_ref(), meant, "{raw}");
    }
}

#[test]
fn text_that_is_scanned_in_pieces() {
    // Strings and comments that look like statements, wherever the text is cut.
    let mut text = Text::default();
    let context = text.context(Units::Millimetres);
    let mut solids = Vec::new();
    for k in 0..200 {
        solids.push(text.box_solid([f64::from(k), 0.0, 0.0], [f64::from(k) + 0.5, 1.0, 1.0]));
        text.add(format_args!("OTHER('{}')", ";\n#10=OTHER($);\n#11=CLOSED_SHELL('',(".repeat(20)));
        text.add(format_args!("OTHER($) /*{}*/", ";\n#10=OTHER($);'\n#11=OTHER('".repeat(20)));
    }
    text.representation(&solids, context);
    let text = text.file();
    assert!(text.len() > 1 << 20, "{} bytes are too few to be cut", text.len());
    assert_eq!(faces(&clean(&text)).len(), 1200);
}

#[test]
fn errors_have_line_and_column_and_lose_one_entity() {
    let text = one_box();
    let face = text.lines().iter().position(|l| l.contains("ADVANCED_FACE('face 1 0'")).unwrap();
    for (from, to, column) in [
        // The statement itself.
        ("ADVANCED_FACE(", "ADVANCED_FACE((", None),
        ("ADVANCED_FACE", "ADVANCED FACE", None),
        (",.F.);", ",.F.;", None),
        (",.F.);", ",.F);", None),
        (",.F.);", ",@);", None),
        ("'face 1 0'", "'face 1 0", None),
        ("'face 1 0'", "/* 'face 1 0'", None),
        ("=ADV", "=?ADV", Some("=?")),
    ] {
        let mut lines = text.lines().to_vec();
        lines[face] = lines[face].replace(from, to);
        let broken = file(&lines.concat());
        let found = model(&broken);
        assert_eq!(faces(&found).len(), 5, "{to}");
        let message = &found.warnings[0].message;
        let line = 8 + face;
        // An unclosed string or comment is found where it ends, or where the next quote stands.
        assert!(message.starts_with("line "), "{message}");
        if let Some(column) = column {
            let column = lines[face].find(column).unwrap() + 2;
            assert!(message.starts_with(&format!("line {line}, column {column}: ")), "{message}");
        }
        assert!(found.lost.iter().any(|l| l.message.contains("is not in the file")), "{:?}", found.lost);
    }
    // Nothing is lost by a missing semicolon.
    let missing = text.file().replacen(";\n#40=", "\n#40=", 1);
    let found = model(&missing);
    assert_eq!(faces(&found).len(), 6);
    assert!(found.warnings[0].message.contains("expected a semicolon"), "{:?}", found.warnings);
}

#[test]
fn a_file_cut_anywhere() {
    let text = one_box().file();
    let mut most = 0;
    for end in (0..text.len()).step_by(37) {
        let Ok(found) = parse(&text[..end]) else { continue };
        let count = faces(&found).len();
        assert!(count >= most, "{count} faces of {end} bytes, {most} of fewer");
        most = count;
        assert!(found.warnings.iter().any(|w| w.message.contains("may be cut")), "{:?}", found.warnings);
    }
    assert_eq!(most, 6, "all faces stand before the end");
    let half = model(&text[..text.len() * 4 / 5]);
    assert!((1..6).contains(&faces(&half).len()));
    assert!(half.warnings.iter().any(|w| w.message.contains("belong to no representation")), "{:?}", half.warnings);
}

#[test]
fn nothing_that_can_be_shown() {
    for text in ["ISO-10303-21;", "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"] {
        let message = parse(text).expect_err(text).to_string();
        assert!(message.contains("no face could be read"), "{message}");
    }
    assert!(parse("").expect_err("empty").to_string().contains("empty"));
    assert!(parse("/* STEP? */ no").expect_err("no STEP").to_string().contains("no known format"));
    let deep = file(&format!("#1=A({}{});\n", "(".repeat(200_000), ")".repeat(200_000)));
    assert!(parse(&deep).is_err());
}

#[test]
fn circles_of_entities_end() {
    let shell = "#1=CLOSED_SHELL('',(#1,#1,#1,#1));\n#2=MANIFOLD_SOLID_BREP('',#1);\n";
    assert!(parse(&file(shell)).expect_err("a shell of itself").to_string().contains("circle"));
    let branching: String = (1..16).map(|k| format!("#{k}=OPEN_SHELL('',(#{0},#{0},#{0},#{0}));\n", k + 1)).collect();
    assert!(parse(&file(&branching)).is_err());
    let line = one_box().lines().iter().find(|l| l.contains("=LINE(")).cloned().unwrap();
    let id = line.split('=').next().unwrap();
    for curve in [
        format!("{id}=TRIMMED_CURVE('',{id},(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(1.)),.T.,.PARAMETER.);\n"),
        format!("{id}=SURFACE_CURVE('',{id},(),.CURVE_3D.);\n"),
        format!(
            "#9={id};#8=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,{id});\n{id}=COMPOSITE_CURVE('',(#8,#8,#8),.F.);\n"
        ),
    ] {
        let found = model(&one_box().file().replace(&line, &curve));
        assert_eq!(faces(&found).len(), 4, "two faces share the edge");
        assert!(found.lost.iter().all(|l| l.message.contains("circle")), "{:?}", found.lost);
    }
}

#[test]
fn numbers_used_twice_are_said() {
    let text = file(&format!("{}#10=OTHER();\n", one_box().lines().concat()));
    let found = model(&text);
    assert_eq!(faces(&found).len(), 6);
    assert!(found.warnings[0].message.contains("#10"), "{:?}", found.warnings);
}
