//! What cuobjdump tells of the kernels.

use crate::fresh::root;
use crate::skip::skip;
use halfpixel::cuda;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// What one kernel takes on one target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Usage {
    /// 32-bit registers a thread.
    pub registers: u32,
    /// Bytes a thread: nothing may be kept there.
    pub stack: u32,
    pub local: u32,
    /// Bytes a block, those that CUDA reserves included.
    pub shared: u32,
}

/// By kernel and target.
pub type Usages = BTreeMap<String, BTreeMap<u32, Usage>>;

/// A machine instruction.
#[derive(Clone, Debug)]
pub struct Instruction {
    pub address: u64,
    /// A predicate decides.
    pub conditional: bool,
    /// As in `FFMA` or `STG.E.128`.
    pub operation: String,
    pub operands: String,
}

impl Instruction {
    /// Of a line such as `/*0b90*/  @P0 BRA 0x11f0 ;  /* 0x... */`.
    fn of(line: &str) -> Option<Self> {
        let (address, rest) = line.strip_prefix("/*")?.split_once("*/")?;
        let address = u64::from_str_radix(address, 16).ok()?;
        let text = rest.split_once(';')?.0.trim();
        let guarded = text.starts_with('@');
        let text = if guarded { text.split_once(' ')?.1.trim() } else { text };
        let (operation, operands) = text.split_once(' ').unwrap_or((text, ""));
        // BRA.U names its predicate as an operand.
        let conditional = guarded || (operation.starts_with("BRA") && operands.contains(','));
        Some(Self { address, conditional, operation: operation.into(), operands: operands.trim().into() })
    }

    /// Where a branch goes.
    pub fn target(&self) -> Option<u64> {
        // BRA.DIV is taken where a warp has diverged before a collective: never here.
        if !self.operation.starts_with("BRA") || self.operation == "BRA.DIV" {
            return None;
        }
        let address = self.operands.rsplit([' ', ',']).next()?.strip_prefix("0x")?;
        u64::from_str_radix(address, 16).ok()
    }
}

/// What cuobjdump tells of the embedded fatbin.
pub struct Dump {
    program: PathBuf,
    fatbin: PathBuf,
}

impl Dump {
    /// `None`, with a line that says why, where kernels or cuobjdump are missing. `name` keeps tests' files apart.
    pub fn new(name: &str) -> Option<Self> {
        let fatbin = cuda::fatbin().map_err(skip).ok()?;
        let Some(program) = cuobjdump() else {
            skip("no cuobjdump (scripts/install_nvcc.sh brings one)");
            return None;
        };
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("kernels-{name}.fatbin"));
        fs::write(&path, fatbin).expect("a temporary file");
        Some(Self { program, fatbin: path })
    }

    fn text(&self, what: &str) -> String {
        let output = Command::new(&self.program).arg(what).arg(&self.fatbin).output().expect("cuobjdump runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("text")
    }

    pub fn usages(&self) -> Usages {
        let text = self.text("--dump-resource-usage");
        let (mut usages, mut target, mut kernel) = (Usages::new(), 0, String::new());
        for line in text.lines().map(str::trim) {
            if let Some(name) = line.strip_prefix("arch = sm_") {
                target = name.parse().expect("a target");
            } else if let Some(name) = line.strip_prefix("Function ") {
                kernel = name.trim_end_matches(':').to_owned();
            } else if line.starts_with("REG:") {
                let field = |name: &str| {
                    let found = line.split_whitespace().find_map(|f| f.strip_prefix(name)?.strip_prefix(':'));
                    found.and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("no {name} in {line}"))
                };
                // From sm_90 on, what CUDA reserves is in the figure, but for kernels that declare none.
                let declared = field("SHARED");
                let shared = declared + if target < 90 || declared == 0 { 1024 } else { 0 };
                let usage = Usage { registers: field("REG"), stack: field("STACK"), local: field("LOCAL"), shared };
                assert_eq!(usages.entry(kernel.clone()).or_default().insert(target, usage), None, "{kernel} twice");
            }
        }
        usages
    }

    /// Instructions of every kernel on every target.
    pub fn instructions(&self) -> BTreeMap<(String, u32), Vec<Instruction>> {
        let (mut kernels, mut target, mut kernel) = (BTreeMap::new(), 0, String::new());
        for line in self.text("--dump-sass").lines().map(str::trim) {
            if let Some(name) = line.strip_prefix("arch = sm_") {
                target = name.parse().expect("a target");
            } else if let Some(name) = line.strip_prefix("Function : ") {
                kernel = name.to_owned();
            } else if let Some(instruction) = Instruction::of(line) {
                kernels.entry((kernel.clone(), target)).or_insert_with(Vec::new).push(instruction);
            }
        }
        kernels
    }

    /// Matrix instructions by kernel and target.
    pub fn products(&self) -> BTreeMap<(String, u32), BTreeMap<String, u32>> {
        let mut products: BTreeMap<_, BTreeMap<String, u32>> = BTreeMap::new();
        for (kernel, instructions) in self.instructions() {
            for i in instructions.into_iter().filter(|i| i.operation.contains("MMA.")) {
                *products.entry(kernel.clone()).or_default().entry(i.operation).or_insert(0) += 1;
            }
        }
        products
    }

    /// Threads a block of every kernel, from the launch bounds in its PTX.
    pub fn threads(&self) -> BTreeMap<String, u32> {
        let (mut threads, mut kernel) = (BTreeMap::new(), String::new());
        for line in self.text("--dump-ptx").lines() {
            if let Some((_, name)) = line.split_once(".entry ") {
                kernel = name.trim_end_matches('(').trim().to_owned();
            } else if let Some(number) = line.trim().strip_prefix(".maxntid ") {
                let number = number.split(',').map(|n| n.trim().parse::<u32>().expect("a number")).product();
                threads.insert(kernel.clone(), number);
            }
        }
        threads
    }
}

/// cuobjdump beside the nvcc that was used, from the project's own folder, or in PATH.
fn cuobjdump() -> Option<PathBuf> {
    let mut folders: Vec<PathBuf> = cuda::toolkit().map(|t| t.folder.into()).into_iter().collect();
    folders.push(root().join("target/nvcc/nvidia/cu13/bin"));
    folders.extend(env::split_paths(&env::var_os("PATH").unwrap_or_default()));
    folders.into_iter().map(|f| f.join("cuobjdump")).find(|p| p.is_file())
}
