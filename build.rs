//! Builds the kernels that run on the CPU (kernels/host).

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    host_kernels();
}

/// Compiles kernels/host and, against it, the kernels and the shim's own test kernels, with `cfg(host_kernels)`. Where no
/// C++20 compiler is found the program does without, and says why (`emulated::missing`).
fn host_kernels() {
    println!("cargo::rustc-check-cfg=cfg(host_kernels)");
    println!("cargo::rerun-if-changed=kernels");
    println!("cargo::rerun-if-env-changed=CXX");
    println!("cargo::rerun-if-env-changed=CXXFLAGS");
    println!("cargo::rerun-if-env-changed=HALFPIXEL_SANITIZE_KERNELS");
    let sanitizer = env::var("HALFPIXEL_SANITIZE_KERNELS").unwrap_or_default();
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    if let Err(why) = probe_host_compiler(&out) {
        println!("cargo::rustc-env=HALFPIXEL_NO_HOST_KERNELS={why}");
        return;
    }
    println!("cargo::rustc-cfg=host_kernels");
    println!("cargo::rustc-link-search=native={}", out.display());
    // Kernels are found through a list that they join before `main`, so the linker must keep them all.
    for (name, folder, suffix, keep) in [
        ("halfpixel_host", "kernels/host", "cpp", ""),
        ("halfpixel_kernels", "kernels", "cu", ":+whole-archive"),
        ("halfpixel_selftest", "kernels/host/selftest", "cu", "not linked"),
    ] {
        let files = files_in(&root.join(folder), suffix);
        if files.is_empty() {
            continue;
        }
        let mut build = host_build(&root);
        sanitize(&mut build, &sanitizer, suffix);
        build.files(files).cargo_metadata(false).compile(name);
        // tests/kernels links the test kernels itself.
        if keep != "not linked" {
            println!("cargo::rustc-link-lib=static{keep}={name}");
        }
    }
}

/// `HALFPIXEL_SANITIZE_KERNELS=thread cargo test --test ...`: kernels under ThreadSanitizer in whole frames (or `address`).
/// The runtime tells ThreadSanitizer about fibers and is not instrumented itself.
fn sanitize(build: &mut cc::Build, sanitizer: &str, suffix: &str) {
    if sanitizer.is_empty() {
        return;
    }
    // Rust links without the compiler's default libraries: g++'s, by name.
    println!("cargo::rustc-link-arg=-l{}san", &sanitizer[..1]);
    build.debug(true);
    if sanitizer == "thread" && suffix == "cpp" {
        build.define("HP_TSAN", None);
    } else {
        build.flag(format!("-fsanitize={sanitizer}"));
    }
}

/// One way to compile what runs on the CPU. `a * b + c` stays two roundings, as nvcc is told too; no C++ library is needed
/// to link.
fn host_build(root: &Path) -> cc::Build {
    let mut build = cc::Build::new();
    build.cpp(true).std("c++20").cpp_link_stdlib(None).opt_level(2).warnings(true).extra_warnings(true);
    build.include(root.join("kernels")).flag("-xc++").flag("-ffp-contract=off").flag("-fno-strict-aliasing");
    build.flag("-fno-exceptions").flag("-fno-rtti").flag("-fno-threadsafe-statics").flag("-Wno-unknown-pragmas");
    // Diagnoses name files as they stand in the repository.
    build.flag(format!("-fmacro-prefix-map={}/=", root.display()));
    build
}

fn probe_host_compiler(out: &Path) -> Result<(), String> {
    let target = |what| env::var(format!("CARGO_CFG_TARGET_{what}")).unwrap_or_default();
    if target("FAMILY") != "unix" || !["x86_64", "aarch64"].contains(&target("ARCH").as_str()) {
        return Err("kernels run on the CPU of x86-64 and AArch64 Unix systems only".into());
    }
    let source = out.join("probe.cpp");
    let text = "#include <source_location>\nauto line(std::source_location at = std::source_location::current()) \
                { return at.line(); }\ntemplate <class T> requires (sizeof(T) == 4) T f(T x) { return x; }\n\
                int main() { return f((int)line()); }\n";
    fs::write(&source, text).map_err(|e| format!("cannot write {}: {e}", source.display()))?;
    let mut build = host_build(out);
    build.file(&source).cargo_metadata(false).cargo_warnings(false);
    let compiler = build.try_get_compiler().map_err(|_| "no C++ compiler was found when this was built".to_owned())?;
    build.try_compile("halfpixel_probe").map_err(|_| {
        let found = compiler.path().display();
        format!("{found} built no C++20 when this was built: g++ 12 or clang 16 can, and CXX chooses one")
    })
}

fn files_in(folder: &Path, suffix: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == suffix)).collect();
    files.sort();
    files
}
