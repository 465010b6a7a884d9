//! One part of a file, by any number that the file has for it, or by a name.

use crate::compose::{Text, Units, list};
use crate::{faces, model};
use halfpixel::model::{Model, Solidity};

/// Two solids and a set in one part, which stands twice in another; numbers of what may be asked for.
struct Numbers {
    text: Text,
    solid: u32,
    shell: u32,
    set: u32,
    product: u32,
    definition: u32,
    representation: u32,
    usage: u32,
    top: u32,
    face: u32,
}

fn numbers() -> Numbers {
    let mut text = Text::default();
    let context = text.context(Units::Millimetres);
    let shell = text.box_shell([0.0; 3], [1.0; 3]);
    let solid = text.add(format_args!("MANIFOLD_SOLID_BREP('der gro\\X2\\00DF\\X0\\e',#{shell})"));
    let other = text.box_solid([3.0; 3], [4.0; 3]);
    let origin = text.at([0.0; 3]);
    let ball = text.add(format_args!("SPHERICAL_SURFACE('ball',#{origin},2.)"));
    let set = text.add(format_args!("GEOMETRIC_SET('a set',(#{ball}))"));
    let representation = text.representation(&[solid, other, set], context);
    let product = text.next();
    let definition = text.product("part", representation);
    let place = text.at([10.0, 0.0, 0.0]);
    let whole = text.representation(&[origin, place], context);
    let top = text.product("whole", whole);
    let mut usage = 0;
    for (name, place) in [("left", origin), ("right", place)] {
        let item = text.add(format_args!("ITEM_DEFINED_TRANSFORMATION('','',#{origin},#{place})"));
        usage = text.next();
        text.usage(name, [(top, whole), (definition, representation)], item, false);
    }
    let face = faces(&model(&text.file()))[0].id;
    Numbers { text, solid, shell, set, product, definition, representation, usage, top, face }
}

/// Instances, and stored faces.
fn counts(model: &Model) -> (usize, usize) {
    (model.instances.len(), faces(model).len())
}

#[test]
fn any_number_that_the_file_has() {
    let Numbers { text, solid, shell, set, product, definition, representation, usage, top, face } = numbers();
    let select = |number: u32| model(&text.file()).select(&format!("#{number}"));
    // The part has a solid half of 12 faces and an open one of 1: an instance of each.
    for (what, number, expected) in [
        ("product", product, (4, 13)),
        ("version", product + 1, (4, 13)),
        ("definition", definition, (4, 13)),
        ("whole", top, (4, 13)),
        ("representation", representation, (4, 13)),
        ("component", usage, (2, 13)),
        ("solid", solid, (2, 6)),
        ("shell", shell, (2, 6)),
        ("set", set, (2, 1)),
        ("face", face, (2, 1)),
    ] {
        let found = select(number).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_eq!(counts(&found), expected, "{what} #{number}");
    }
    let right = select(usage).expect("the component");
    assert!(right.instances.iter().all(|i| i.name == "whole/right" && i.transform.translation.x == 10.0));
    let solidity = |number| select(number).expect("there").parts[0].solidity;
    assert_eq!(solidity(solid), Solidity::Solid);
    // A shell may be a void's, which looks inward.
    assert_eq!([solidity(shell), solidity(set), solidity(face)], [Solidity::Open; 3]);
}

#[test]
fn names_of_parts_components_solids_and_faces() {
    let text = numbers().text.file();
    let count = |name: &str| counts(&model(&text).select(name).unwrap_or_else(|e| panic!("{name}: {e}")));
    assert_eq!(count("part"), (4, 13));
    assert_eq!(count("left"), (2, 13));
    assert_eq!(count("whole/right"), (2, 13));
    assert_eq!(count("der große"), (2, 6));
    assert_eq!(count("Der Große"), (2, 6));
    assert_eq!(count("a set"), (2, 1));
    assert_eq!(count("face 0 1"), (2, 2));
}

#[test]
fn what_is_not_there_is_said_with_what_is_near() {
    let Numbers { text, solid, set, .. } = numbers();
    let error = |part: &str| model(&text.file()).select(part).expect_err(part).to_string();
    let near = error("der grosse");
    assert!(near.contains("near it are: der große"), "{near}");
    assert!(near.lines().count() == 1 && near.len() < 300, "{near}");
    let near = error("#4000000");
    // The set has a greater number than the solid.
    let [set, solid] = [set, solid].map(|id| near.find(&format!("#{id} (")));
    assert!(set.is_some() && set < solid, "{near}");
    assert!(error("zzz").contains("there are: "), "{}", error("zzz"));
    assert!(error("#0").contains("#0;") && error("#").contains("#;"));
}

#[test]
fn groups_follow_their_faces_past_lost_ones() {
    let mut text = Text::default();
    let context = text.context(Units::Millimetres);
    let solids = [text.box_solid([0.0; 3], [1.0; 3]), text.box_solid([3.0; 3], [4.0; 3])];
    text.representation(&solids, context);
    let whole = text.file();
    // The second plane of the first solid is none.
    let broken = whole.replacen("PLANE(", "NO_PLANE(", 2).replacen("NO_PLANE(", "PLANE(", 1);
    let found = model(&broken);
    assert_eq!((found.lost.len(), faces(&found).len()), (1, 11));
    let expected: Vec<u32> = faces(&found)[5..].iter().map(|f| f.id).collect();
    let second = found.select(&format!("#{}", solids[1])).expect("the second solid");
    assert_eq!(faces(&second).iter().map(|f| f.id).collect::<Vec<_>>(), expected);
    assert_eq!(list(&expected).matches('#').count(), 6);
}

#[test]
fn mapped_items_are_components_too() {
    let mut text = Text::default();
    let items = text.two_places();
    let found = model(&text.file()).select(&format!("#{}", items[1])).expect("the second one");
    assert_eq!((found.instances.len(), found.instances[0].transform.translation.x), (1, 5.0));
}
