//! What colour a shaded pixel gets: the lit surface, or one of the pictures that explain a frame (`--show`).

use super::Show;
use super::light::Light;
use super::shade::Shader;
use super::topology::{Primitive, index_of, meshlet_of, primitive};

/// One pixel's surface, as colours see it.
pub(super) struct Look<'a> {
    /// Leaf number.
    pub number: u32,
    /// Leaf parameters after refinement.
    pub parameters: [f32; 2],
    pub word: u64,
    /// Pixel number in the image.
    pub pixel: u32,
    /// The light on it and some more pixels, and which of them it is.
    pub light: &'a Light,
    pub lane: usize,
}

/// Edge length in pixels at which `--show triangle-size` turns from red to green (ETER figure 7).
const SMALL_TRIANGLE: i32 = 16;

/// Linear RGB of a pixel.
pub(super) fn color(shader: &Shader, look: &Look) -> [f32; 3] {
    let leaf = &shader.leaves[look.number as usize];
    let lit = |base: [f32; 3]| look.light.on(base, look.lane);
    match shader.options.show {
        Show::Shaded => lit(shader.scene.color(leaf.instance, leaf.patch)),
        Show::Patches => lit(hashed(leaf.patch.wrapping_mul(31).wrapping_add(leaf.instance))),
        Show::Meshlets => lit(hashed(meshlet_of(look.word) ^ 0x5bd1_e995)),
        Show::Grid => grid(shader, look),
        Show::Normals => [0, 1, 2].map(|k| [0.5, -0.5, -0.5][k] * look.light.normal[k][look.lane] + 0.5),
        Show::Depth => {
            let depth = super::topology::depth_of(look.word);
            // From the far end of the model's depth (dark) to the near one.
            let far = if shader.lens.perspective { shader.near_over_far() } else { 0.0 };
            [((depth - far) / (1.0 - far)).clamp(0.02, 1.0); 3]
        }
        Show::Error => error_color(grid_error(shader, look)),
        Show::TriangleSize => lit(triangle_size(shader, look)),
    }
}

impl Shader<'_> {
    fn near_over_far(&self) -> f32 {
        (self.lens.near / (self.lens.near + self.lens.extent)) as f32
    }
}

/// How far from the pixel's centre the surface point of its interpolated parameter projects, in pixels, by f64.
fn grid_error(shader: &Shader, look: &Look) -> f64 {
    let (lens, scene) = (shader.lens, shader.scene);
    let leaf = &shader.leaves[look.number as usize];
    let [u, v] = leaf.to_patch(shader.interpolated(look.number, look.word, look.pixel).map(f64::from));
    let patch = &scene.patches[leaf.patch as usize];
    let map = lens.patch_map(&scene.instances[leaf.instance as usize], patch.origin);
    let p = map.apply(scene.net(patch).jet(u, v).point);
    let place = p.truncate().truncate() / lens.denominator(p);
    let at = [look.pixel % lens.size[0], look.pixel / lens.size[0]];
    (0..2).map(|k| (place[k] + lens.half(k) - f64::from(at[k]) - 0.5).abs()).fold(0.0, f64::max)
}

/// Yeo 2012, figure 12: grey below a tenth of a pixel, blue below a half, green below one, red above.
fn error_color(error: f64) -> [f32; 3] {
    match error {
        e if e < 0.1 => [0.35; 3],
        e if e < 0.5 => [0.05, 0.12, 0.75],
        e if e < 1.0 => [0.05, 0.55, 0.08],
        _ => [0.75, 0.03, 0.03],
    }
}

/// A colour that differs for neighbouring numbers: hue from a hash, even brightness.
fn hashed(number: u32) -> [f32; 3] {
    let h = number.wrapping_mul(0x9e37_79b9) ^ (number >> 7).wrapping_mul(0x85eb_ca6b);
    let hue = (h >> 8) as f32 / (1 << 24) as f32;
    std::array::from_fn(|k| {
        let t = (hue + k as f32 / 3.0).fract();
        0.15 + 0.7 * ((t - 0.5).abs() * 6.0 - 1.0).clamp(0.0, 1.0)
    })
}

/// The surface with its quads' borders dark.
fn grid(shader: &Shader, look: &Look) -> [f32; 3] {
    let leaf = &shader.leaves[look.number as usize];
    let quads = shader.grids[look.number as usize].quads;
    let base = look.light.on(shader.scene.color(leaf.instance, leaf.patch), look.lane);
    let meshlet = &shader.meshlets.meshlets[meshlet_of(look.word) as usize];
    let size = [0, 1].map(|k| {
        // Pixels a quad measures along its side, from the meshlet's corners.
        let n = usize::from(meshlet.quads[k]);
        let far = if k == 0 { meshlet.vertex(n, 0) } else { meshlet.vertex(0, n) };
        let (a, b) = (shader.meshlets.vertices[meshlet.vertex(0, 0)], shader.meshlets.vertices[far]);
        ((a.x - b.x) as f32).hypot((a.y - b.y) as f32) / 256.0 / n as f32
    });
    let near_line = (0..2).any(|k| {
        let p = look.parameters[k] * quads[k] as f32;
        (p - p.round()).abs() * size[k] < 0.6
    });
    if near_line { base.map(|c| c * 0.2) } else { base }
}

/// ETER figure 7: red where the triangle's box is smaller than 16 pixels, green where it is larger.
fn triangle_size(shader: &Shader, look: &Look) -> [f32; 3] {
    let meshlet = &shader.meshlets.meshlets[meshlet_of(look.word) as usize];
    let (Primitive::Triangle(corners) | Primitive::Edge(corners)) = primitive(meshlet, index_of(look.word));
    let v = corners.map(|[i, j]| shader.meshlets.vertices[meshlet.vertex(i, j)]);
    let span = |f: fn(&super::evaluate::Vertex) -> i32| {
        let values = v.each_ref().map(f);
        values.iter().max().unwrap_or(&0) - values.iter().min().unwrap_or(&0)
    };
    let small = span(|v| v.x).max(span(|v| v.y)) < SMALL_TRIANGLE * super::evaluate::SUBPIXELS;
    if small { [0.7, 0.1, 0.1] } else { [0.1, 0.6, 0.15] }
}
