//! ETER's rule for hybrid rasterising: leaves that it leaves to software have no longer edges.

use crate::import;
use crate::scene::{ViewSpec, prepare};
use crate::stages::frame::Geometry;
use crate::stages::hardware::edges_reach;
use crate::stages::lens::Lens;
use crate::stages::{Options, Renderer};
use glam::Vec2;

#[test]
fn edges_of_what_software_draws_are_short() {
    let (mut software, mut hardware, mut longest) = (0, 0, 0.0f32);
    for name in ["builtin:teapot", "builtin:drum", "builtin:torus", "builtin:sphere"] {
        let scene = prepare(&import::load(name).expect("a model"), &|_, _| {}).expect("a scene");
        let renderer = Renderer::new(&scene);
        for (zoom, orthographic) in [(1.0, false), (8.0, false), (3.0, true)] {
            let view = ViewSpec { size: [320, 240], zoom, orthographic, ..ViewSpec::default() };
            let (lens, options) = (Lens::new(&view.camera(&scene.bounds).expect("a camera")), Options::default());
            let culled = renderer.cull(&lens, &options).expect("leaves");
            let Geometry { leaves, grids } = renderer.estimate(&lens, &options, culled).expect("grids");
            let meshlets = renderer.evaluate(&lens, &options, &leaves, &grids).expect("vertices");
            for m in &meshlets.meshlets {
                let (leaf, grid) = (&leaves.leaves[m.leaf as usize], &grids[m.leaf as usize]);
                let net = &leaves.nets[leaf.net as usize..leaf.net as usize + leaf.points()];
                const PIXELS: f32 = 32.0;
                if edges_reach(leaf, grid, net, lens.perspective, PIXELS) {
                    hardware += 1;
                    continue;
                }
                software += 1;
                let across = usize::from(m.quads[1]) + 1;
                let at = |i: usize, j: usize| {
                    let v = &meshlets.vertices[m.vertices as usize + i * across + j];
                    Vec2::new(v.x as f32, v.y as f32) / 256.0
                };
                for (i, j) in (0..usize::from(m.quads[0])).flat_map(|i| (0..across - 1).map(move |j| (i, j))) {
                    let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    let edges = [p - q, q - r, r - s, s - p, p - r, q - s];
                    longest = edges.iter().map(|e| e.length()).fold(longest, f32::max);
                }
            }
        }
    }
    assert!(longest <= 32.0 + 1.5 / 256.0, "{longest}");
    assert!(software > 100 && hardware > 100 && longest > 8.0, "{software} {hardware} {longest}");
}
