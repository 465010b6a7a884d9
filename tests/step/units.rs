//! Units, surfaces by formula and splines: where they end up.

use crate::compose::{Text, Units, list, mixture, one_box};
use crate::{assert_box, clean, faces, model};
use halfpixel::model::SurfaceKind;

#[test]
fn lengths_come_out_in_millimetres() {
    for (units, factor) in [(Units::Millimetres, 1.0), (Units::Metres, 1000.0), (Units::InchesAndDegrees, 25.4)] {
        let mut text = Text::default();
        let context = text.context(units);
        let solid = text.box_solid([0.0; 3], [1.0, 2.0, 3.0]);
        text.representation(&[solid], context);
        let found = clean(&text.file());
        assert_box(&found, [0.0; 3], [factor, 2.0 * factor, 3.0 * factor]);
        assert_eq!(found.unit.as_deref(), Some("mm"));
    }
}

/// A surface trimmed to a rectangle of its parameters, as the file has them.
fn trimmed(units: Units, surface: &str, [a, b, c, d]: [f64; 4]) -> String {
    let mut text = Text::default();
    let context = text.context(units);
    let origin = text.at([0.0; 3]);
    let basis = text.add(surface.replace('@', &format!("#{origin}")));
    let face = text.add(format_args!("RECTANGULAR_TRIMMED_SURFACE('',#{basis},{a:?},{b:?},{c:?},{d:?},.T.,.T.)"));
    let set = text.add(format_args!("GEOMETRIC_SET('',{})", list(&[face])));
    text.representation(&[set], context);
    text.file()
}

#[test]
fn angles_in_degrees_and_lengths_in_inches() {
    let cone = trimmed(Units::InchesAndDegrees, "CONICAL_SURFACE('',@,1.,45.)", [0.0, 90.0, 0.0, 2.0]);
    let found = clean(&cone);
    // A quarter turn; the radius grows from 1 to 3 inches.
    assert_box(&found, [0.0; 3], [3.0 * 25.4, 3.0 * 25.4, 2.0 * 25.4]);
    assert_eq!(faces(&found)[0].kind, SurfaceKind::Cone);
    let sphere =
        trimmed(Units::Millimetres, "SPHERICAL_SURFACE('',@,2.)", [0.0, std::f64::consts::FRAC_PI_2, 0.0, 0.5]);
    assert_box(&clean(&sphere), [0.0; 3], [2.0, 2.0, 2.0 * 0.5f64.sin()]);
}

#[test]
fn the_same_spline_in_all_spellings() {
    let written = |kind: &str, rest: &str| {
        let mut text = Text::default();
        let context = text.context(Units::Millimetres);
        let points: Vec<u32> =
            (0..12).map(|k: i32| text.point([f64::from(k / 4), f64::from(k % 4), f64::from(k * k % 7)])).collect();
        let rows: Vec<String> = points.chunks(4).map(list).collect();
        let base = format!("2,3,({}),.UNSPECIFIED.,.F.,.F.,.F.", rows.join(","));
        let surface = kind.replace("BASE", &base).replace("REST", rest);
        let surface = text.add(surface);
        let set = text.add(format_args!("GEOMETRIC_SET('',(#{surface}))"));
        text.representation(&[set], context);
        clean(&text.file())
    };
    let knots = "(3,3),(4,4),(0.,1.),(0.,1.),.UNSPECIFIED.";
    let weights = "((1.,1.,1.,1.),(1.,1.,1.,1.),(1.,1.,1.,1.))";
    let reference = written("B_SPLINE_SURFACE_WITH_KNOTS('',BASE,REST)", knots);
    let points = |m: &halfpixel::model::Model| faces(m)[0].surface.patches[0].patch.points().to_vec();
    for (kind, rest) in [
        ("BEZIER_SURFACE('',BASE)", ""),
        ("QUASI_UNIFORM_SURFACE('',BASE)", ""),
        ("RATIONAL_B_SPLINE_SURFACE('',BASE,REST)", weights),
        ("(BEZIER_SURFACE() B_SPLINE_SURFACE(BASE) REPRESENTATION_ITEM('x') SURFACE())", ""),
        ("(B_SPLINE_SURFACE(BASE) B_SPLINE_SURFACE_WITH_KNOTS(REST) SURFACE())", knots),
        ("(B_SPLINE_SURFACE(BASE) RATIONAL_B_SPLINE_SURFACE(REST) QUASI_UNIFORM_SURFACE())", weights),
    ] {
        assert_eq!(points(&written(kind, rest)), points(&reference), "{kind}");
    }
    // Uniform knots are not clamped: the same points give a smaller piece.
    let uniform = written("UNIFORM_SURFACE('',BASE)", "");
    assert_ne!(points(&uniform), points(&reference));
}

#[test]
fn bad_splines_are_lost_by_name() {
    let text = mixture().file();
    for (from, to, why) in [
        ("((1.,2.),(1.,1.))", "((1.,-2.),(1.,1.))", "weight"),
        ("((1.,2.),(1.,1.))", "((1.,2.),(1.))", "weights"),
        ("((2,2),(2,2),", "((2,2),(2,1000000000),", "multiplicities"),
        ("(0.,1.),(0.,1.)", "(0.,1.),(1.,0.)", "knot"),
        ("B_SPLINE_SURFACE(1,1,", "B_SPLINE_SURFACE(1,100,", "degree 100"),
    ] {
        assert!(text.contains(from), "{from}");
        let found = model(&text.replace(from, to));
        assert_eq!(found.lost.len(), 1, "{to}: {:?}", found.lost);
        assert!(found.lost[0].message.contains(why) && found.lost[0].entity.is_some(), "{:?}", found.lost);
    }
}

/// At a corner the offset jumps: no number of pieces follows it.
#[test]
fn an_offset_that_no_pieces_follow_is_lost_with_its_number() {
    let text = one_box();
    let line = text.lines().iter().find(|l| l.contains("=LINE(")).cloned().expect("a line");
    let (id, _) = line.split_once('=').expect("a number");
    let points = "#9001=CARTESIAN_POINT('',(0.,0.,0.));\n#9002=CARTESIAN_POINT('',(1.,0.,0.));\n\
                  #9003=CARTESIAN_POINT('',(1.,1.,0.));\n#9004=DIRECTION('',(0.,0.,1.));\n";
    let offset =
        format!("{points}#9005=POLYLINE('',(#9001,#9002,#9003));\n{id}=OFFSET_CURVE_3D('',#9005,0.1,.F.,#9004);\n");
    let found = model(&text.file().replace(&line, &offset));
    assert_eq!((faces(&found).len(), found.lost.len()), (4, 2));
    assert!(found.lost.iter().all(|l| l.message.contains("pieces don't follow")), "{:?}", found.lost);
}

#[test]
fn a_mixture_of_everything() {
    let found = clean(&mixture().file());
    assert_eq!(faces(&found).len(), 16);
    let kinds: Vec<SurfaceKind> = faces(&found).iter().map(|f| f.kind).collect();
    for kind in
        [SurfaceKind::Plane, SurfaceKind::Sphere, SurfaceKind::Cone, SurfaceKind::Extrusion, SurfaceKind::BSpline]
    {
        assert!(kinds.contains(&kind), "{kind:?}");
    }
}

#[test]
fn units_that_are_missing_or_broken_are_said() {
    let text = one_box().file();
    let none = text.replace("GLOBAL_UNIT_ASSIGNED_CONTEXT", "OTHER");
    let found = model(&none);
    assert!(found.warnings.iter().any(|w| w.message.contains("millimetres are assumed")), "{:?}", found.warnings);
    assert_box(&found, [0.0; 3], [1.0, 2.0, 3.0]);
}

/// A file may claim to be exact beyond any need; what was fitted as near as was asked for is then no warning.
#[test]
fn good_fits_are_no_warning_however_fine_the_tolerance() {
    let fine =
        include_str!("../models/cylinder_oblique.step").replace("LENGTH_MEASURE(1.E-5)", "LENGTH_MEASURE(1.E-8)");
    assert!(fine.contains("1.E-8"));
    clean(&fine);
}
