//! `vk_shaders`: the structs of `kernels/abi.h` in GLSL.

#[path = "support/fresh.rs"]
mod fresh;
#[path = "support/glsl.rs"]
mod glsl;

use fresh::{agrees, root};
use glsl::{Item, Struct};
use std::collections::BTreeMap;
use std::fs;

const HEADER: &str = "kernels/abi.h";
const BINDINGS: &str = "src/cuda/abi.rs";
const GLSL: &str = "vk_shaders/abi.glsl";
const TITLE: &str = "Made of kernels/abi.h by tests/shaders.rs: change that file, and read its comments there.";

#[test]
fn the_glsl_side_of_the_abi_is_fresh() {
    agrees(GLSL, &glsl::write(TITLE, &glsl::read(&text(HEADER))));
}

#[test]
fn structs_lie_in_buffers_as_the_host_writes_them() {
    let bindings = text(BINDINGS);
    for one in structs() {
        let padded = one.padded();
        let layout = padded.scalar_layout();
        let offsets = padded.fields.iter().map(|field| field.name.clone()).zip(layout.offsets);
        let offsets: BTreeMap<_, _> = offsets.filter(|(name, _)| name != "padding_").collect();
        assert_eq!(offsets, asserted_offsets(&bindings, &one.name), "{}", one.name);
        assert_eq!(Some(layout.stride), asserted_size(&bindings, &one.name), "{}", one.name);
    }
}

#[test]
fn headers_become_glsl() {
    let header = "#pragma once\n/// A number.\nstatic const uint32_t NONE = 0xff;\nstatic const int32_t STEPS = 256;\n\
                  enum Rule : uint32_t {\n    RULE_A = 0,\n};\n/// A struct.\nstruct alignas(16) Odd {\n\
                  \x20   uint64_t word;\n    float patch[2][3]; // name\n    uint8_t last;\n};\n";
    let items = glsl::read(header);
    let made = glsl::write("Made.", &items);
    let expected = "\nconst uint NONE = 0xffu;\nconst int STEPS = 256;\nconst uint RULE_A = 0u;\n\nstruct Odd {\n    \
                    uint64_t word;\n    float patch_[2][3];\n    uint8_t last;\n    uint padding_[3];\n};\n\n#endif\n";
    assert!(made.ends_with(expected), "{made}");
    let Some(Item::Struct(odd)) = items.last() else { panic!("{items:?}") };
    let layout = odd.padded().scalar_layout();
    assert_eq!((layout.offsets, layout.stride), (vec![0, 8, 32, 36], 48));
}

#[test]
fn assertions_of_the_bindings_are_read() {
    let bindings = "const _: () = {\n[\"Size of A\"][::core::mem::size_of::<A>() - 16usize];\n[\n\"Offset of field: A::x\",\n\
                    ][::core::mem::offset_of!(A, x) - 8usize];\n[\"\"][::core::mem::offset_of!(AB, y) - 4usize];\n};\n";
    assert_eq!(asserted_size(bindings, "A"), Some(16));
    assert_eq!(asserted_offsets(bindings, "A"), BTreeMap::from([("x".to_owned(), 8)]));
}

fn structs() -> Vec<Struct> {
    let items = glsl::read(&text(HEADER)).into_iter();
    let structs = items.filter_map(|item| if let Item::Struct(one) = item { Some(one) } else { None });
    structs.collect()
}

/// Offsets of a struct's fields that the bindings assert.
fn asserted_offsets(bindings: &str, of: &str) -> BTreeMap<String, usize> {
    let start = format!("offset_of!({of}, ");
    let found = bindings.split(&start).skip(1).map(|rest| {
        let (field, bytes) = rest.split_once(") - ").expect("an assertion of an offset");
        (field.to_owned(), leading_number(bytes))
    });
    found.collect()
}

/// The size of a struct that the bindings assert.
fn asserted_size(bindings: &str, of: &str) -> Option<usize> {
    let (_, rest) = bindings.split_once(&format!("size_of::<{of}>() - "))?;
    Some(leading_number(rest))
}

fn leading_number(text: &str) -> usize {
    let digits = text.split_once("usize").map(|(digits, _)| digits);
    digits.and_then(|digits| digits.parse().ok()).unwrap_or_else(|| panic!("no number: {:.20}", text))
}

fn text(file: &str) -> String {
    fs::read_to_string(root().join(file)).unwrap_or_else(|e| panic!("cannot read {file}: {e}"))
}
