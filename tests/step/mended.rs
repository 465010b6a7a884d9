//! What is wrong in a file and can be put right.

use crate::compose::one_box;
use crate::model;
use halfpixel::model::{Model, Solidity};

fn area(model: &Model) -> f64 {
    model.figures(&model.measure(&|_, _| {})).area
}

#[test]
fn an_edge_that_runs_against_its_loop_is_turned() {
    let text = one_box().file();
    let whole = model(&text);
    assert_eq!(whole.parts[0].solidity, Solidity::Solid);
    let whole = area(&whole);
    let uses: Vec<usize> = text.match_indices("=ORIENTED_EDGE(").map(|(at, _)| at).collect();
    assert_eq!(uses.len(), 24);
    for at in uses {
        let end = at + text[at..].find(';').expect("the end of the entity");
        let entity = &text[at..end];
        let other = if entity.contains(".T.") { entity.replace(".T.", ".F.") } else { entity.replace(".F.", ".T.") };
        let found = model(&[&text[..at], &other, &text[end..]].concat());
        assert!(found.lost.is_empty());
        // The shell may not be closed: backs are shown.
        assert_eq!(found.parts[0].solidity, Solidity::Open);
        assert_eq!(found.warnings.len(), 1, "{entity}: {:?}", found.warnings);
        assert!(found.warnings[0].message.contains("runs against its loop"), "{:?}", found.warnings);
        assert!((area(&found) - whole).abs() < 1e-9 * whole, "{entity}: {} {whole}", area(&found));
    }
}
