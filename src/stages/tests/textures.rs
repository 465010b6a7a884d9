//! Trim textures: a texel is set where it is inside or a curve passes it, and nowhere else.

use crate::cuda::selection::Selection;
use crate::import::builtin::builtin;
use crate::scene::{Region, Scene, ViewSpec, prepare};
use crate::stages::cull::{Culler, Leaves};
use crate::stages::lens::Lens;
use crate::stages::trim_cut::Cut;
use crate::stages::trim_texture::Texture;
use crate::stages::{Options, Trim};

/// Texels in u and v: less than a word, words in full, and some more.
const SIZES: [[u32; 2]; 4] = [[1, 1], [37, 23], [64, 9], [150, 40]];
/// What rounding may take of a texel.
const ROUNDING: f64 = 1e-9;

fn check(scene: &Scene, what: &str) -> [usize; 2] {
    let camera = ViewSpec { size: [320, 240], ..ViewSpec::default() }.camera(&scene.bounds).expect("a camera");
    let (lens, options) = (Lens::new(&camera), Options { trim: Trim::Texture, ..Options::default() });
    let mut leaves = Leaves::default();
    for patch in scene.instances[0].patches.clone() {
        Culler::new(scene, &lens, &options, Selection::SINGLE)
            .patch(0, patch as u32, &mut leaves)
            .expect("not too many pieces");
    }
    let mut count = [0; 2];
    for cut in leaves.leaves.iter().filter_map(|leaf| Cut::new(scene, &lens, &options, leaf)) {
        for size in SIZES {
            let texture = Texture::new(&cut, size.map(f64::from));
            for (column, row) in (0..size[0]).flat_map(|column| (0..size[1]).map(move |row| (column, row))) {
                let at = |by: f64| [(column, size[0]), (row, size[1])].map(|(k, n)| (f64::from(k) + by) / f64::from(n));
                let set = texture.contains(at(0.5));
                count[usize::from(set)] += 1;
                let expected = match cut.classify(at(-ROUNDING), at(1.0 + ROUNDING)) {
                    // What only rounding keeps off a curve may be either.
                    Region::Boundary if cut.classify(at(ROUNDING), at(1.0 - ROUNDING)) != Region::Boundary => continue,
                    region => region != Region::Outside,
                };
                assert_eq!(set, expected, "{what}: texel {column}, {row} of {size:?}");
            }
        }
    }
    count
}

#[test]
fn texels_are_set_where_the_face_is() {
    for name in ["plate", "drilled", "ball", "degree22", "touching"] {
        let model = builtin(&format!("trimmed:{name}")).expect("a model");
        let mut scene = prepare(&model, &|_, _| {}).expect("a scene");
        let count = check(&scene, name);
        assert!(count.iter().all(|&n| n > 100), "{name}: {count:?}");
        // The plane of the trims may run against the patch's parameters.
        for patch in &mut scene.patches {
            patch.domain[0].reverse();
        }
        check(&scene, &format!("{name}, turned round"));
    }
}
