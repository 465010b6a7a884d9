//! Colours in one place of the assembly only.

use crate::clean;
use crate::compose::{Text, Units, list};
use halfpixel::model::Model;
use halfpixel::scene::prepare;

const RED: [f32; 3] = [1.0, 0.0, 0.0];
const BLUE: [f32; 3] = [0.0, 0.0, 1.0];

/// A box twice in a pair, the pair twice in the whole.
struct Pairs {
    text: Text,
    faces: Vec<u32>,
    solid: u32,
    style: u32,
    /// The numbers of the boxes' places in the pair, and of the pairs' in the whole: usage, its shape, relationship and
    /// what joins the two.
    boxes: [[u32; 4]; 2],
    pairs: [[u32; 4]; 2],
    /// The representation of a pair.
    pair: u32,
}

fn pairs() -> Pairs {
    let mut text = Text::default();
    let context = text.context(Units::Millimetres);
    let faces = text.box_faces([0.0; 3], [1.0; 3]);
    let shell = text.add(format_args!("CLOSED_SHELL('',{})", list(&faces)));
    let solid = text.add(format_args!("MANIFOLD_SOLID_BREP('',#{shell})"));
    let style = text.style([0.5; 3], solid);
    let [origin, right, far] = [text.at([0.0; 3]), text.at([5.0, 0.0, 0.0]), text.at([0.0, 9.0, 0.0])];
    let part = text.representation(&[solid], context);
    let pair = text.representation(&[origin, right], context);
    let whole = text.representation(&[origin, far], context);
    let [part_product, pair_product, top] =
        [("part", part), ("pair", pair), ("whole", whole)].map(|(n, r)| text.product(n, r));
    let mut place = |name: &str, ends: [(u32, u32); 2], at: u32| {
        let item = text.add(format_args!("ITEM_DEFINED_TRANSFORMATION('','',#{origin},#{at})"));
        text.usage(name, ends, item, false)
    };
    let boxes =
        [("left", origin), ("right", right)].map(|(n, at)| place(n, [(pair_product, pair), (part_product, part)], at));
    let pairs = [("near", origin), ("far", far)].map(|(n, at)| place(n, [(top, whole), (pair_product, pair)], at));
    Pairs { text, faces, solid, style, boxes, pairs, pair }
}

/// The colours of each instance's faces, through the scene; `.` is the part's own.
fn shown(model: &Model) -> Vec<(String, String)> {
    let scene = prepare(model, &|_, _| {}).expect("a scene");
    let letter = |color: [f32; 3]| {
        if color == RED {
            'r'
        } else if color == BLUE {
            'b'
        } else {
            '.'
        }
    };
    let colors =
        |k: usize| scene.instances[k].patches.clone().map(|p| letter(scene.color(k as u32, p as u32))).collect();
    let found = scene.instances.iter().enumerate();
    found.map(|(k, instance)| (instance.name.trim_start_matches("whole/").to_owned(), colors(k))).collect()
}

/// What `styled` makes of the four boxes, in their order: near left, near right, far left, far right.
fn colors(styled: impl Fn(&mut Pairs)) -> [String; 4] {
    let mut made = pairs();
    styled(&mut made);
    let found = shown(&clean(&made.text.file()));
    let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["near/left", "near/right", "far/left", "far/right"]);
    std::array::from_fn(|k| found[k].1.clone())
}

#[test]
fn a_solid_or_a_face_is_coloured_where_all_contexts_are_passed() {
    for kind in 0..4 {
        let all = colors(|p| p.text.style_in("red", p.solid, p.style, &[p.pairs[1][kind]]));
        assert_eq!(all, ["......", "......", "rrrrrr", "rrrrrr"], "by number {kind}");
        let one = colors(|p| p.text.style_in("red", p.faces[1], p.style, &[p.pairs[1][kind], p.boxes[0][kind]]));
        assert_eq!(one, ["......", "......", ".r....", "......"], "by number {kind}");
    }
    let in_every_pair = colors(|p| p.text.style_in("red", p.faces[2], p.style, &[p.boxes[1][2]]));
    assert_eq!(in_every_pair, ["......", "..r...", "......", "..r..."]);
    let of_representation = colors(|p| p.text.style_in("red", p.faces[5], p.style, &[p.pair]));
    assert_eq!(of_representation, [".....r"; 4]);
    let nowhere = colors(|p| p.text.style_in("red", p.solid, p.style, &[p.boxes[0][2], p.boxes[1][2]]));
    assert_eq!(nowhere, ["......"; 4]);
}

#[test]
fn outer_places_override_inner_ones_and_faces_their_solid() {
    let nested = colors(|p| {
        p.text.style_in("blue", p.faces[0], p.style, &[p.pairs[0][2]]);
        p.text.style_in("red", p.solid, p.style, &[p.pairs[0][2]]);
        p.text.style_in("blue", p.solid, p.style, &[p.boxes[0][2]]);
    });
    assert_eq!(nested, ["brrrrr", "brrrrr", "bbbbbb", "......"]);
}
