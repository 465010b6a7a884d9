//! What a user meets where Vulkan is asked for and can't be used.

use std::process::Command;

fn halfpixel(arguments: &[&str], driver: &str) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_halfpixel"));
    let output = command.args(arguments).env("VK_DRIVER_FILES", driver).env("VK_ICD_FILENAMES", driver).output();
    let output = output.expect("the program starts");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_missing_driver_is_one_clear_line() {
    let folder = std::env::temp_dir().join(format!("halfpixel-vulkan-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let picture = folder.join("a.png").to_string_lossy().into_owned();
    for raster in ["hardware", "hybrid"] {
        let arguments = ["render", "builtin:sphere", "--size", "16x12", "--raster", raster, "-o", &picture];
        let (code, said) = halfpixel(&arguments, "/nowhere.json");
        assert_eq!(code, Some(1), "{said}");
        assert!(said.starts_with(&format!("halfpixel: --raster {raster} can't be used: ")), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
    // What asks for nothing by name goes on.
    let arguments = ["render", "builtin:sphere", "--size", "16x12", "--raster", "auto", "-o", &picture];
    assert_eq!(halfpixel(&arguments, "/nowhere.json"), (Some(0), String::new()));
    assert_eq!(halfpixel(&["devices"], "/nowhere.json").0, Some(0));
    std::fs::remove_dir_all(folder).expect("it is ours");
}

#[test]
fn the_baseline_is_a_benchmark() {
    let (code, said) = halfpixel(&["render", "builtin:sphere", "--raster", "tessellation", "-o", "a.png"], "");
    assert!(code == Some(2) && said.contains("bench tessellation"), "{said}");
    let (code, said) = halfpixel(&["render", "builtin:sphere", "--raster", "none", "-o", "a.png"], "");
    assert!(code == Some(2) && said.contains("hybrid") && !said.contains("tessellation"), "{said}");
}

#[test]
fn vertices_that_no_memory_holds_are_refused() {
    let drawn = ["render", "builtin:sphere", "--backend", "emulated", "--raster", "hardware", "-o", "a.png"];
    let (code, said) = halfpixel(&[&drawn[..], &["--frame", "fused"]].concat(), "");
    // Where the kernels can't be emulated, that is said instead.
    assert!(code == Some(2) && said.contains("--frame staged") || code == Some(1), "{said}");
}
