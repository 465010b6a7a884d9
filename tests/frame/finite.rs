//! What a program reads of a picture: every number of every channel is finite, on the hard cases too.

use exr::prelude::*;
use std::process::Command;

/// Channels of a drawn EXR as (name, values); integers as they are.
fn channels(arguments: &[&str], name: &str) -> Vec<(String, Vec<f32>)> {
    let folder = std::env::temp_dir().join(format!("halfpixel-finite-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join(format!("{name}.exr"));
    let mut program = Command::new(env!("CARGO_BIN_EXE_halfpixel"));
    program.arg("render").args(arguments).args(["--size", "120x90", "-o"]).arg(&path);
    let output = program.output().expect("the program runs");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    let image = read_all_flat_layers_from_file(&path).expect("an EXR");
    std::fs::remove_dir_all(&folder).expect("the folder is ours");
    let channel = |c: &AnyChannel<FlatSamples>| (c.name.to_string(), c.sample_data.values_as_f32().collect());
    image.layer_data.iter().flat_map(|layer| layer.channel_data.list.iter().map(channel)).collect()
}

#[test]
fn no_channel_holds_what_is_not_a_number() {
    let cases: [&[&str]; 10] = [
        &["builtin:stress"],
        &["builtin:stress:weights", "--zoom", "8"],
        &["builtin:stress:coincident"],
        &["builtin:stress:collapsed", "--view", "left"],
        &["builtin:stress:nearplane", "--eye=0,0,0.2", "--target=10,0,0"],
        &["builtin:stress:room", "--eye=0,0,1.0001", "--target=3,1,0"],
        &["builtin:stress:offset1e9", "--projection", "orthographic"],
        &["builtin:sphere", "--eye=0,0,1", "--target=0,0,-1"],
        &["builtin:teapot", "--zoom", "1e12"],
        &["builtin:sphere", "--fov", "179"],
    ];
    for (k, arguments) in cases.into_iter().enumerate() {
        let channels = channels(arguments, &k.to_string());
        assert_eq!(channels.len(), 16, "{arguments:?}");
        for (name, values) in channels {
            let wrong = values.iter().filter(|v| !v.is_finite()).count();
            assert_eq!(wrong, 0, "{arguments:?}: channel {name}");
        }
    }
}
