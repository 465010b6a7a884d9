//! `src/cuda/abi.rs` is what bindgen makes of `kernels/abi.h`.

#[path = "support/fresh.rs"]
mod fresh;
#[path = "support/skip.rs"]
mod skip;

use fresh::{agrees, root};
use std::env;
use std::path::PathBuf;

const HEADER: &str = "kernels/abi.h";
const FRESH: &str = "src/cuda/abi.rs";

#[test]
fn the_rust_side_of_the_abi_is_fresh() {
    let Some(folder) = libclang() else {
        skip::skip("no libclang (scripts/install_nvcc.sh brings one, or set LIBCLANG_PATH)");
        return;
    };
    // SAFETY: this is the only test of its process, so no other thread looks at the environment.
    unsafe { env::set_var("LIBCLANG_PATH", folder) };
    let bindings = bindgen::Builder::default()
        .header(root().join(HEADER).to_string_lossy())
        .clang_args(["-x", "c++", "-std=c++20"])
        .raw_line(format!("//! Made by bindgen from {HEADER}: change that file, and read its comments there."))
        .allowlist_file(".*/abi(_scene)?\\.h")
        .constified_enum_module("FillRule")
        .constified_enum_module("ArithmeticRule")
        .constified_enum_module("Region")
        .constified_enum_module("BoundRule")
        .constified_enum_module("GridRule")
        .constified_enum_module("CullRule")
        .derive_default(true)
        .derive_partialeq(true)
        .use_core()
        .merge_extern_blocks(true)
        .disable_header_comment()
        .formatter(bindgen::Formatter::Prettyplease)
        .generate()
        .unwrap_or_else(|e| panic!("{HEADER}: {e}"));
    agrees(FRESH, &bindings.to_string());
}

/// Where libclang is: where LIBCLANG_PATH says, the wheel's of scripts/install_nvcc.sh, or a usual place.
fn libclang() -> Option<PathBuf> {
    let own = root().join("target/nvcc/clang/native");
    let mut folders: Vec<PathBuf> = env::var_os("LIBCLANG_PATH").map(PathBuf::from).into_iter().collect();
    folders.push(own);
    folders.extend((14..=22).rev().map(|n| PathBuf::from(format!("/usr/lib/llvm-{n}/lib"))));
    let has = |folder: &PathBuf| folder.join("libclang.so").exists() || folder.join("libclang.so.1").exists();
    folders.into_iter().find(has)
}
