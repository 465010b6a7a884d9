//! Parts, instances, solids and colours.

use crate::compose::{Text, Units, list};
use crate::{assert_box, clean, faces, model};
use glam::{DMat3, DVec3};
use halfpixel::model::{Face, Model, Solidity};

/// The outward normal and a point of a face.
fn normal(face: &Face) -> (DVec3, DVec3) {
    let net = face.surface.patches[0].patch.net();
    let h = 1e-3;
    let [p, u, v] = [net.position(0.5, 0.5), net.position(0.5 + h, 0.5), net.position(0.5, 0.5 + h)];
    let normal = (u - p).cross(v - p).normalize();
    (if face.reversed { -normal } else { normal }, p)
}

fn linear(value: f64) -> f32 {
    ((value + 0.055) / 1.055).powf(2.4) as f32
}

#[test]
fn a_void_looks_inward() {
    for sense in ["F", "T"] {
        let mut text = Text::default();
        let context = text.context(Units::Millimetres);
        let [outer, inner] = [text.box_shell([0.0; 3], [4.0; 3]), text.box_shell([1.0; 3], [2.0; 3])];
        let inner = text.add(format_args!("ORIENTED_CLOSED_SHELL('',*,#{inner},.{sense}.)"));
        let solid = text.add(format_args!("BREP_WITH_VOIDS('',#{outer},(#{inner}))"));
        text.representation(&[solid], context);
        let found = clean(&text.file());
        assert_eq!(found.parts.len(), 1);
        assert_eq!(found.parts[0].solidity, Solidity::Solid);
        for (k, face) in faces(&found).into_iter().enumerate() {
            let (normal, point) = normal(face);
            let outward = if k < 6 { point - DVec3::splat(2.0) } else { point - DVec3::splat(1.5) };
            let expected = k < 6 || sense == "T";
            assert_eq!(normal.dot(outward) > 0.0, expected, "face {k}, sense {sense}");
        }
    }
}

#[test]
fn shells_without_solids_are_open() {
    let mut text = Text::default();
    let context = text.context(Units::Millimetres);
    let faces = text.box_faces([0.0; 3], [1.0; 3]);
    let open = text.add(format_args!("OPEN_SHELL('',{})", list(&faces[..5])));
    let shells = text.add(format_args!("SHELL_BASED_SURFACE_MODEL('',(#{open}))"));
    let turned = text.add(format_args!("ORIENTED_FACE('',*,#{},.F.)", faces[5]));
    let set = text.add(format_args!("CONNECTED_FACE_SET('',(#{turned}))"));
    let sets = text.add(format_args!("FACE_BASED_SURFACE_MODEL('',(#{set}))"));
    text.representation(&[shells, sets], context);
    let found = clean(&text.file());
    assert_eq!(found.parts[0].solidity, Solidity::Open);
    let all = &found.parts[0].faces;
    assert_eq!(all.len(), 6);
    let (n, p) = normal(&all[4]);
    assert!(n.dot(p - DVec3::splat(0.5)) > 0.0);
    let (n, p) = normal(&all[5]);
    assert!(n.dot(p - DVec3::splat(0.5)) < 0.0, "an oriented face turns the face");
}

#[test]
fn faceted_breps_and_faces_without_surface() {
    let mut text = Text::default();
    let context = text.context(Units::Millimetres);
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|p| text.point(p));
    let faces: Vec<u32> = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
        .iter()
        .map(|f| {
            let ring = text.add(format_args!("POLY_LOOP('',{})", list(&f.map(|k| corners[k]))));
            let bound = text.add(format_args!("FACE_OUTER_BOUND('',#{ring},.T.)"));
            text.add(format_args!("FACE('',(#{bound}))"))
        })
        .collect();
    let shell = text.add(format_args!("CLOSED_SHELL('',{})", list(&faces)));
    let solid = text.add(format_args!("FACETED_BREP('',#{shell})"));
    text.representation(&[solid], context);
    let found = clean(&text.file());
    let mut uses = std::collections::BTreeMap::new();
    for face in &found.parts[0].faces {
        let curves: Vec<_> = face.loops.iter().flat_map(|l| &l.curves).collect();
        assert_eq!(curves.len(), 3);
        curves.iter().for_each(|c| *uses.entry(c.edge).or_insert(0) += 1);
        let (n, p) = normal(face);
        assert!(n.dot(p - DVec3::splat(0.2)) > 0.0 || n.dot(DVec3::ONE) > 0.0);
    }
    assert_eq!(uses.len(), 6, "both sides give an edge one number");
    assert!(uses.values().all(|&count| count == 2));
}

/// A box in an assembly in an assembly: turned, then mirrored by an operator, then mapped.
fn nested(parent_first: bool) -> Text {
    let mut text = Text::default();
    let context = text.context(Units::Millimetres);
    let origin = text.at([0.0; 3]);
    let solid = text.box_solid([0.0; 3], [1.0, 2.0, 3.0]);
    let brep = text.add(format_args!("ADVANCED_BREP_SHAPE_REPRESENTATION('',(#{solid}),#{context})"));
    let part = text.representation(&[origin], context);
    text.add(format_args!("SHAPE_REPRESENTATION_RELATIONSHIP('','',#{part},#{brep})"));
    let middle_place = text.placement([10.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]);
    let middle = text.representation(&[origin, middle_place], context);
    let top = text.representation(&[origin], context);
    let [part_product, middle_product] = [text.product("part", part), text.product("middle", middle)];
    let top_product = text.product("top", top);
    // x' = 10 - y, y' = x
    let above = text.at([0.0, 0.0, 5.0]);
    for (name, place) in [("a", middle_place), ("b", above)] {
        let [one, two] = if parent_first { [place, origin] } else { [origin, place] };
        let operator = text.add(format_args!("ITEM_DEFINED_TRANSFORMATION('','',#{one},#{two})"));
        text.usage(name, [(middle_product, middle), (part_product, part)], operator, parent_first);
    }
    // x'' = 100 - x', all doubled.
    let [x, y, z] = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|d| text.direction(d));
    let point = text.point([100.0, 0.0, 0.0]);
    let mirror = text.add(format_args!("CARTESIAN_TRANSFORMATION_OPERATOR_3D('','','',#{x},#{y},#{point},2.,#{z})"));
    text.usage("m", [(top_product, top), (middle_product, middle)], mirror, false);
    text
}

#[test]
fn nested_assemblies_with_a_mirror() {
    let found = clean(&nested(false).file());
    assert_eq!((found.parts.len(), found.parts[0].faces.len(), found.instances.len()), (1, 6, 2));
    assert_eq!(found.parts[0].name, "part");
    let names: Vec<&str> = found.instances.iter().map(|i| i.name.as_str()).collect();
    assert_eq!(names, ["top/m/a", "top/m/b"]);
    let corner = |k: usize, p: [f64; 3]| found.instances[k].transform.transform_point3(p.into());
    assert!(corner(0, [1.0, 2.0, 3.0]).abs_diff_eq(DVec3::new(84.0, 2.0, 6.0), 1e-9), "{}", corner(0, [1.0, 2.0, 3.0]));
    assert!(corner(1, [1.0, 2.0, 3.0]).abs_diff_eq(DVec3::new(98.0, 4.0, 16.0), 1e-9));
    for instance in &found.instances {
        let determinant = DMat3::determinant(&instance.transform.matrix3);
        assert!((determinant + 8.0).abs() < 1e-9, "{determinant}");
    }
}

#[test]
fn relationships_from_parent_to_child_mean_the_same() {
    let [one, two] = [false, true].map(|parent_first| clean(&nested(parent_first).file()));
    for (a, b) in one.instances.iter().zip(&two.instances) {
        assert_eq!(a.name, b.name);
        assert!(a.transform.abs_diff_eq(b.transform, 1e-12), "{} {}", a.transform, b.transform);
    }
    assert_eq!(two.instances.len(), 2);
}

#[test]
fn surfaces_without_bounds_are_said() {
    let mut text = Text::default();
    let context = text.context(Units::Millimetres);
    let solid = text.box_solid([0.0; 3], [1.0; 3]);
    let origin = text.at([0.0; 3]);
    let plane = text.add(format_args!("PLANE('',#{origin})"));
    let swept = text.add(format_args!("EXTRUDED_AREA_SOLID('',#{origin},#{origin},1.)"));
    text.representation(&[solid, plane, swept], context);
    let found = model(&text.file());
    assert_eq!(faces(&found).len(), 6);
    assert_eq!((found.warnings.len(), found.warnings[0].entity), (1, Some(plane)));
    assert_eq!((found.lost.len(), found.lost[0].entity), (1, Some(swept)));
    assert!(found.lost[0].message.contains("EXTRUDED_AREA_SOLID"), "{:?}", found.lost);
}

#[test]
fn mapped_items_share_their_part() {
    let mut text = Text::default();
    let context = text.context(Units::Millimetres);
    let inches = text.context(Units::InchesAndDegrees);
    let solid = text.box_solid([0.0; 3], [1.0; 3]);
    let part = text.representation(&[solid], inches);
    let origin = text.at([0.0; 3]);
    let items: Vec<u32> = (0..3)
        .map(|k| {
            let target = text.at([100.0 * f64::from(k), 0.0, 0.0]);
            text.mapped(part, origin, target)
        })
        .collect();
    text.style([0.5; 3], items[1]);
    text.representation(&items, context);
    let found = clean(&text.file());
    assert_eq!((found.parts.len(), found.instances.len()), (1, 3));
    // Inches inside, millimetres outside.
    assert_box(&found, [0.0; 3], [225.4, 25.4, 25.4]);
    let colors: Vec<_> = found.instances.iter().map(|i| i.color).collect();
    assert_eq!(colors, [None, Some([linear(0.5); 3]), None]);
}

#[test]
fn assemblies_of_themselves_end() {
    let mut text = Text::default();
    let context = text.context(Units::Millimetres);
    let origin = text.at([0.0; 3]);
    let solid = text.box_solid([0.0; 3], [1.0; 3]);
    let own = text.next();
    // The map comes first, then the item, then the representation.
    let item = text.mapped(own + 2, origin, origin);
    assert_eq!(text.representation(&[solid, item], context), own + 2);
    let found = model(&text.file());
    assert_eq!(found.instances.len(), 1);
    assert!(found.warnings.iter().any(|w| w.message.contains("contains itself")), "{:?}", found.warnings);
    // Each level twice in the next: 2^40 at the top.
    let mut text = Text::default();
    let context = text.context(Units::Millimetres);
    let origin = text.at([0.0; 3]);
    let solid = text.box_solid([0.0; 3], [1.0; 3]);
    let mut level = text.representation(&[solid], context);
    for _ in 0..40 {
        let items = [text.mapped(level, origin, origin), text.mapped(level, origin, origin)];
        level = text.representation(&items, context);
    }
    let found = model(&text.file());
    assert!(found.warnings.iter().any(|w| w.message.contains("the rest is left out")), "{:?}", found.warnings);
    // Without anything to show it is no work.
    let empty = model(&text.file().replace(&format!("(#{solid})"), "()"));
    assert!(empty.warnings.iter().any(|w| w.message.contains("belong to no representation")), "{:?}", empty.warnings);
}

fn color_of(model: &Model, name: &str) -> Option<[f32; 3]> {
    faces(model).into_iter().find(|f| *f.name == *name).unwrap().color
}

#[test]
fn colours_are_inherited_and_overridden() {
    let mut text = Text::default();
    let (all, solid, shape) = text.solid_of_faces();
    let [gray, dark] = [[linear(0.5); 3], [linear(0.25); 3]];
    let bare = clean(&text.file());
    assert_eq!(color_of(&bare, "face 0 0"), None);
    text.style([0.25; 3], shape);
    let found = clean(&text.file());
    assert_eq!(color_of(&found, "face 0 0"), Some(dark), "of the representation");
    text.style([0.5; 3], solid);
    let found = clean(&text.file());
    assert_eq!(color_of(&found, "face 0 0"), Some(gray), "of the solid");
    let red = text.add("DRAUGHTING_PRE_DEFINED_COLOUR('red')");
    let style = text.style_of(red, all[0]);
    // A colour for rendering, without a fill area.
    let rgb = text.add("COLOUR_RGB('',0.25,0.25,0.25)");
    let rendering = text.add(format_args!("SURFACE_STYLE_RENDERING(.NORMAL_SHADING.,#{rgb})"));
    let side = text.add(format_args!("SURFACE_SIDE_STYLE('',(#{rendering}))"));
    let usage = text.add(format_args!("SURFACE_STYLE_USAGE(.POSITIVE.,#{side})"));
    let assigned = text.add(format_args!("PRESENTATION_STYLE_ASSIGNMENT((#{usage}))"));
    text.add(format_args!("OVER_RIDING_STYLED_ITEM('',(#{assigned}),#{},#{style})", all[1]));
    text.style([0.5; 3], all[1]);
    let found = clean(&text.file());
    assert_eq!(color_of(&found, "face 0 0"), Some([1.0, 0.0, 0.0]));
    assert_eq!(color_of(&found, "face 0 1"), Some(dark), "what overrides wins, wherever it stands");
    assert_eq!(color_of(&found, "face 1 0"), Some(gray));
}
