//! Compiles `kernels/*.cu` with nvcc into one fatbin that src/cuda/module.rs embeds. Without nvcc the program is built
//! for the CPU alone, and says so.

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
            let toolkit = format!("Ok(Toolkit {{ version: {:?}, folder: {folder:?} }})", nvcc.version);
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
    for line in said.lines().filter(|l| !l.trim().is_empty()) {
        println!("cargo::warning={line}");
    }
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
        "--compress-mode=size",
        "-Xptxas=--warn-on-spills",
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
