//! What a frame on a device has too many of, where no test has the memory for it: kernels that find numbers other than there
//! are. tests/kernels/limits.rs has the others.

use crate::cuda::recorded::{Find, Recorded};
use crate::cuda::{GpuError, abi};
use crate::emulated;
use crate::import;
use crate::scene::{Scene, ViewSpec, prepare};
use crate::stages::topology::MAX_MESHLETS;
use crate::stages::{Options, RenderError, Renderer, cull};

fn scene(name: &str) -> Scene {
    prepare(&import::load(name).expect("a model"), &|_, _| {}).expect("a scene")
}

/// What stops a frame in which a kernel finds a number.
fn stopped(scene: &Scene, zoom: f64, find: Find) -> Option<RenderError> {
    if emulated::missing().is_some() {
        return None;
    }
    let camera = ViewSpec { size: [48, 36], zoom, ..ViewSpec::default() }.camera(&scene.bounds).expect("a camera");
    let mut gpu = Recorded { finds: Some(find), ..Recorded::default() };
    let found = Renderer::new(scene).render_on(&mut gpu, &camera, &Options::default());
    let error = found.map(|frame| frame.stats).expect_err("an error");
    assert!(gpu.finds.is_none(), "no {}", find.kernel);
    println!("{error}");
    Some(error)
}

/// Whatever is counted before there is room for it: no count wraps, and the error has it.
#[test]
fn lists_longer_than_places_have_bits() {
    let most = u64::from(u32::MAX);
    for (kernel, argument, what, limit) in [
        ("trim_meshlets", 1, "fragments to test", most),
        ("fill_list", 0, "pixels to fill", most),
        ("shade_pixels", 0, "pixels in doubt", most),
        ("settle_allocate", 0, "candidates", most / 4),
    ] {
        for needed in [limit + 1, 1 << 40] {
            let find = Find { kernel, argument, byte: 0, number: needed };
            let Some(error) = stopped(&scene("builtin:trimmed:drilled"), 1.0, find) else { return };
            assert_eq!(error, GpuError::TooMany { what, needed, limit }.into());
        }
    }
}

/// A leaf with as many blocks as a frame has meshlets: the others are too many. Two with the most that 32 bits hold: the sum
/// does not wrap.
#[test]
fn more_meshlets_than_words_name() {
    let scene = scene("builtin:teapot");
    let camera = ViewSpec { size: [48, 36], ..ViewSpec::default() }.camera(&scene.bounds).expect("a camera");
    let (staged, _) = Renderer::new(&scene).staged(&camera, &Options::default()).expect("a frame");
    let blocks = |leaf: &abi::Patch| leaf.quads.iter().map(|&n| u64::from(n).div_ceil(7)).product::<u64>();
    let others: u64 = staged.patches[2..].iter().map(blocks).sum();
    for (first, second) in [(MAX_MESHLETS, 0), (u64::from(u32::MAX), u64::from(u32::MAX))] {
        let find = Find { kernel: "meshlet_counts", argument: 1, byte: 0, number: second << 32 | first };
        let Some(error) = stopped(&scene, 1.0, find) else { return };
        let needed = first + second + others;
        assert_eq!(error, RenderError::TooManyMeshlets { needed, limit: MAX_MESHLETS });
        assert_eq!(error.to_string(), format!("this view needs {needed} meshlets; a frame holds 33554432"));
    }
}

/// An error of a patch, told by its number among those of all instances, in the CPU's words.
#[test]
fn more_leaves_than_a_patch_may_have() {
    let mut scene = scene("builtin:teapot");
    let all = scene.instances[0].clone();
    scene.instances[0].patches = 0..3;
    scene.instances.push(all);
    for (item, patch) in [(1, 1), (3, 0), (3 + 17, 17)] {
        let number = item << 8 | u64::from(abi::ERROR_TOO_MANY_LEAVES);
        // `counters` of split::Buffers, and `error` is the first of these.
        let find = Find { kernel: "split_patches", argument: 1, byte: 16, number };
        let Some(error) = stopped(&scene, 40.0, find) else { return };
        let face = scene.faces[scene.patches[patch as usize].face as usize].id;
        assert_eq!(error, RenderError::TooManyLeaves { face, patch, limit: cull::MAX_LEAVES });
    }
}

#[test]
fn more_patches_than_numbers() {
    let mut scene = scene("builtin:teapot");
    scene.instances[0].patches = 0..1 << 31;
    scene.instances = vec![scene.instances[0].clone(); 3];
    let camera = ViewSpec::default().camera(&scene.bounds).expect("a camera");
    let found = Renderer::new(&scene).render_on(&mut Recorded::default(), &camera, &Options::default());
    let (what, needed, limit) = ("patches of all instances", 3 << 31, u64::from(u32::MAX));
    assert_eq!(found.map(|_| ()).expect_err("an error"), GpuError::TooMany { what, needed, limit }.into());
}
