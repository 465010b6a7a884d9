//! Races and accesses beyond memory, found by the compiler's sanitizers in kernels that have them on purpose.

use std::path::Path;
use std::process::Command;

/// Runs the script; what this compiler can't do it says, with `skipped`.
#[test]
fn sanitizers_find_what_they_must_and_nothing_else() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sanitize_kernels");
    let output = Command::new("bash").arg(root.join("scripts/sanitize_kernels.sh")).arg(&folder).output();
    let output = output.expect("bash can be started");
    let [out, error] = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    println!("{out}{error}");
    assert!(output.status.success(), "{out}{error}");
    for sanitizer in ["thread", "address"] {
        let told = |line: &str| line.starts_with(&format!("{sanitizer}:"));
        assert!(out.lines().any(told), "nothing was said of the {sanitizer} sanitizer:\n{out}");
    }
}
