//! Compiles `kernels/*.cu` twice: with nvcc into one fatbin that src/cuda/module.rs embeds, and with a C++ compiler against
//! kernels/host, so that src/emulated runs them on the CPU. Without the one or the other the program is built without, and
//! says so.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, fs, io};

/// Compute capabilities that get machine code, by the virtual architecture they are compiled for: one pass of the front
/// end serves all with the same one. PTX of the first lets newer devices compile their own.
const TARGETS: [(u32, &[u32]); 3] = [(80, &[80, 86, 89]), (90, &[90]), (120, &[120])];
/// The first release that knows all targets.
const OLDEST_NVCC: [u32; 2] = [12, 8];
/// Where scripts/install_nvcc.sh puts nvcc, and the file it writes when it has.
const OWN_FOLDER: &str = "target/nvcc/nvidia/cu13";
const OWN_STAMP: &str = "target/nvcc.installed";

fn main() -> ExitCode {
    host_kernels();
    match device_kernels() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            for line in message.lines().filter(|l| !l.trim().is_empty()) {
                println!("cargo::error={line}");
            }
            ExitCode::FAILURE
        }
    }
}

/// Writes `OUT_DIR/device_kernels.rs`: the fatbin and what made it, or why there is none.
fn device_kernels() -> Result<(), String> {
    let root = PathBuf::from(variable("CARGO_MANIFEST_DIR")?);
    let out = PathBuf::from(variable("OUT_DIR")?);
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=kernels");
    // Where sources can't be written to, the script can't install anything either.
    let _ = watch_own_folder(&root);
    let targets: Vec<u32> = TARGETS.iter().flat_map(|t| t.1).copied().collect();
    let (fatbin, toolkit) = match find_nvcc(&root)? {
        Ok(nvcc) => {
            if nvcc.path.is_file() {
                println!("cargo::rerun-if-changed={}", nvcc.path.display());
            }
            compile(&root, &out, &nvcc)?;
            let folder = nvcc.path.parent().map(|p| p.display().to_string()).unwrap_or_default();
            let toolkit = format!(
                "Ok(Toolkit {{ version: {:?}, folder: {folder:?}, spills: include!(\"kernels.spills\") }})",
                nvcc.version
            );
            ("Some(&Aligned(*include_bytes!(\"kernels.fatbin\")))", toolkit)
        }
        Err(reason) => ("None", format!("Err({reason:?})")),
    };
    let text = format!(
        "static FATBIN: Option<&Aligned<[u8]>> = {fatbin};\n\
         const TOOLKIT: Result<Toolkit, &str> = {toolkit};\n\
         const TARGETS: &[u32] = &{targets:?};\n",
    );
    fs::write(out.join("device_kernels.rs"), text).map_err(|e| format!("cannot write device_kernels.rs: {e}"))
}

/// An nvcc that can compile for all targets.
struct Nvcc {
    path: PathBuf,
    /// As in 13.0.88.
    version: String,
}

/// The first usable nvcc of the places it may be in; else the reason that users are told. What `NVCC` names is used,
/// or the build fails.
fn find_nvcc(root: &Path) -> Result<Result<Nvcc, String>, String> {
    for name in ["NVCC", "CUDA_HOME", "CUDA_PATH", "PATH"] {
        println!("cargo::rerun-if-env-changed={name}");
    }
    if env::var_os("NVCC").is_some_and(|v| v == "none") {
        return Ok(Err("NVCC=none".into()));
    }
    if let Some(path) = env::var_os("NVCC").filter(|v| !v.is_empty()) {
        let nvcc = check(Path::new(&path)).map_err(|e| format!("NVCC={}: {e}", Path::new(&path).display()))?;
        return Ok(Ok(nvcc));
    }
    let mut folders: Vec<PathBuf> = Vec::new();
    folders
        .extend(["CUDA_HOME", "CUDA_PATH"].into_iter().filter_map(env::var_os).map(|p| PathBuf::from(p).join("bin")));
    folders.extend(env::split_paths(&env::var_os("PATH").unwrap_or_default()));
    folders.push("/usr/local/cuda/bin".into());
    folders.push(root.join(OWN_FOLDER).join("bin"));
    let mut refused = String::new();
    for path in folders.into_iter().map(|f| f.join("nvcc")).filter(|p| p.is_file()) {
        match check(&path) {
            Ok(nvcc) => return Ok(Ok(nvcc)),
            Err(reason) => refused = format!("{}: {reason}", path.display()),
        }
    }
    Ok(Err(if refused.is_empty() { "no nvcc was found when it was built".into() } else { refused }))
}

/// Asks an nvcc for its version.
fn check(path: &Path) -> Result<Nvcc, String> {
    let output = Command::new(path).arg("--version").output().map_err(|e| format!("it can't be run: {e}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let version = text.lines().find_map(|l| Some(l.split_once(", V")?.1.trim().to_owned()));
    let version = version.ok_or("it names no version")?;
    let mut numbers = version.split('.').map(|n| n.parse().unwrap_or(0));
    let [oldest, oldest_minor] = OLDEST_NVCC;
    if [numbers.next().unwrap_or(0), numbers.next().unwrap_or(0)] < OLDEST_NVCC {
        return Err(format!("nvcc {version} is too old, {oldest}.{oldest_minor} is needed"));
    }
    Ok(Nvcc { path: path.to_owned(), version })
}

/// Makes cargo look again once scripts/install_nvcc.sh has run. A path that isn't there would be looked at in every
/// build, and the folder holds thousands of files: so an empty file stands for "not yet".
fn watch_own_folder(root: &Path) -> io::Result<()> {
    let stamp = root.join(OWN_STAMP);
    if !stamp.exists() {
        fs::create_dir_all(root.join("target"))?;
        fs::write(&stamp, "")?;
    }
    println!("cargo::rerun-if-changed={}", stamp.display());
    Ok(())
}

/// Compiles all kernels as one translation unit, unless nothing that decides the result has changed.
fn compile(root: &Path, out: &Path, nvcc: &Nvcc) -> Result<(), String> {
    let sources = sources(root).map_err(|e| format!("cannot read kernels: {e}"))?;
    let units = sources.iter().filter(|(name, _)| name.ends_with(".cu"));
    let unit: String = units.map(|(name, _)| format!("#include \"kernels/{name}\"\n")).collect();
    let arguments = arguments();
    let mut hasher = DefaultHasher::new();
    (&nvcc.version, &nvcc.path, &arguments, &sources).hash(&mut hasher);
    let key = format!("{:016x}", hasher.finish());
    let (fatbin, stamp) = (out.join("kernels.fatbin"), out.join("kernels.key"));
    if fatbin.is_file() && fs::read_to_string(&stamp).is_ok_and(|old| old == key) {
        return Ok(());
    }
    let file = out.join("kernels.cu");
    fs::write(&file, unit).map_err(|e| format!("cannot write {}: {e}", file.display()))?;
    // From the root, so that messages and line tables say kernels/evaluate.cu.
    let output = Command::new(&nvcc.path).current_dir(root).args(&arguments).arg("-o").arg(&fatbin).arg(&file).output();
    let output = output.map_err(|e| format!("cannot run {}: {e}", nvcc.path.display()))?;
    let said = [output.stdout, output.stderr].map(|t| String::from_utf8_lossy(&t).into_owned()).concat();
    if !output.status.success() {
        let about_a_kernel = said.contains("): error");
        let hint = if about_a_kernel { "" } else { ": is there a g++ it knows? NVCC=none builds for the CPU alone" };
        return Err(format!("{said}\n{} ({}) can't compile kernels/{hint}", nvcc.path.display(), nvcc.version));
    }
    let (spills, warnings): (Vec<&str>, Vec<&str>) =
        said.lines().filter(|l| !l.trim().is_empty()).partition(|l| l.contains("Registers are spilled"));
    warnings.iter().for_each(|line| println!("cargo::warning={line}"));
    let file = out.join("kernels.spills");
    fs::write(&file, format!("&{spills:?}")).map_err(|e| format!("cannot write {}: {e}", file.display()))?;
    fs::write(&stamp, key).map_err(|e| format!("cannot write {}: {e}", stamp.display()))
}

/// IEEE arithmetic as on the CPU: contraction off, so that FMA is only where a kernel writes it (DESIGN section 3),
/// denormals kept, divisions and roots rounded to nearest. Fast versions are written out where an error bound allows.
fn arguments() -> Vec<String> {
    let mut all: Vec<String> = [
        "-fatbin",
        "-std=c++20",
        "-O3",
        "-I.",
        "-Ikernels",
        "--fmad=false",
        "--ftz=false",
        "--prec-div=true",
        "--prec-sqrt=true",
        // Profilers show lines; costs no instruction.
        "-lineinfo",
        // tests/kernel_resources wants none.
        "-Xptxas=--warn-on-spills",
        "--compress-mode=size",
        // One thread a target and core.
        "--threads=0",
    ]
    .map(String::from)
    .into();
    for (k, (virtual_target, targets)) in TARGETS.iter().enumerate() {
        let mut code: Vec<String> = targets.iter().map(|t| format!("sm_{t}")).collect();
        if k == 0 {
            code.push(format!("compute_{virtual_target}"));
        }
        all.push(format!("-gencode=arch=compute_{virtual_target},code=[{}]", code.join(",")));
    }
    all
}

/// Names and contents of what nvcc reads, in order of name. The folder of the host shim is not among them.
fn sources(root: &Path) -> io::Result<Vec<(String, Vec<u8>)>> {
    let mut sources = Vec::new();
    for entry in fs::read_dir(root.join("kernels"))? {
        let path = entry?.path();
        if path.is_file() {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            sources.push((name, fs::read(&path)?));
        }
    }
    sources.sort();
    Ok(sources)
}

fn variable(name: &str) -> Result<String, String> {
    env::var(name).map_err(|e| format!("{name}: {e}"))
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
