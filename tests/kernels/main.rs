//! Kernels on the CPU (`kernels/host`): each piece of the emulation against a plain reference, and every mistake that a
//! kernel can make, made on purpose; the frame's own kernels against the CPU's stages.

#[cfg(not(host_kernels))]
#[test]
fn skipped() {
    skip::skip(halfpixel::emulated::missing().expect("a reason"));
}

#[cfg(host_kernels)]
mod adopted;
#[cfg(host_kernels)]
mod atomics;
#[cfg(host_kernels)]
mod block;
#[cfg(host_kernels)]
mod collectives;
#[cfg(host_kernels)]
mod evaluate;
#[cfg(host_kernels)]
mod evaluate_bounds;
#[cfg(host_kernels)]
mod evaluate_mma;
#[cfg(host_kernels)]
mod evaluate_normals;
#[cfg(host_kernels)]
mod evaluate_scene;
#[cfg(host_kernels)]
mod faults;
#[cfg(host_kernels)]
mod frame;
#[path = "../support/fresh.rs"]
mod fresh;
#[cfg(host_kernels)]
mod geometry;
#[cfg(host_kernels)]
mod limits;
#[cfg(host_kernels)]
mod numbers;
mod planned;
#[cfg(host_kernels)]
mod products;
#[cfg(host_kernels)]
mod sanitizers;
#[path = "../support/skip.rs"]
mod skip;
#[cfg(host_kernels)]
mod sparse_products;
#[cfg(host_kernels)]
mod special_products;
#[cfg(host_kernels)]
mod support;
#[cfg(host_kernels)]
mod texture;
#[cfg(host_kernels)]
mod trims;

// The test kernels; their names join the list of kernels before `main`.
#[cfg(host_kernels)]
#[link(name = "halfpixel_selftest", kind = "static", modifiers = "+whole-archive")]
unsafe extern "C" {}
