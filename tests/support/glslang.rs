//! The GLSL compiler of `scripts/install_glslang.sh`.

use crate::fresh::root;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

const INSTALLED: &str = "target/glslang/cmeel.prefix";
/// What a shader's module depends on besides its text: Vulkan 1.3 means SPIR-V 1.6.
const TARGET: [&str; 3] = ["--target-env", "vulkan1.3", "--quiet"];

pub struct Glslang {
    folder: PathBuf,
}

impl Glslang {
    /// The compiler that scripts/glslang_wheels.txt pins, if it is installed; a word about it if not.
    pub fn installed() -> Option<Glslang> {
        let read = |file: &str| fs::read(root().join(file)).ok();
        let pinned =
            read("scripts/glslang_wheels.txt").is_some_and(|list| read("target/glslang.installed") == Some(list));
        let found = pinned.then(|| Glslang { folder: root().join(INSTALLED) });
        if found.is_none() {
            eprintln!("skipped: glslang is not installed as pinned (scripts/install_glslang.sh)");
        }
        found
    }

    /// The module of a shader, without names.
    pub fn compile(&self, shader: &Path) -> Result<Vec<u8>, String> {
        self.run(shader, &["-g0"])
    }

    /// The module of a shader, with names.
    pub fn compile_named(&self, shader: &Path) -> Result<Vec<u8>, String> {
        self.run(shader, &[])
    }

    /// Fails where a module breaks a rule of Vulkan 1.3.
    pub fn validate(&self, module: &Path) -> Result<(), String> {
        let mut validator = self.program("spirv-val");
        run(validator.args(["--target-env", "vulkan1.3", "--scalar-block-layout"]).arg(module))
    }

    /// Its name, and so its stage, is that of the file.
    fn run(&self, shader: &Path, options: &[&str]) -> Result<Vec<u8>, String> {
        let name = shader.file_name().unwrap_or_default().to_string_lossy();
        let module = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.spv"));
        let mut compiler = self.program("glslang");
        compiler.args(TARGET).args(options).arg(format!("-I{}", root().join("vk_shaders").display()));
        run(compiler.arg("-o").arg(&module).arg(shader))?;
        fs::read(&module).map_err(|e| format!("{}: {e}", module.display()))
    }

    fn program(&self, name: &str) -> Command {
        let mut command = Command::new(self.folder.join("bin").join(name));
        command.env("LD_LIBRARY_PATH", self.folder.join("lib"));
        command
    }
}

fn run(command: &mut Command) -> Result<(), String> {
    let output = command.output().map_err(|e| format!("{}: {e}", command.get_program().display()))?;
    let said = || format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    if output.status.success() { Ok(()) } else { Err(said()) }
}
