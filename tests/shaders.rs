//! `vk_shaders`: the structs of `kernels/abi.h` in GLSL, and that every shader's committed module is what the pinned
//! glslang makes of it.

#[path = "support/fresh.rs"]
mod fresh;
#[path = "support/glsl.rs"]
mod glsl;
#[path = "support/glslang.rs"]
mod glslang;
#[path = "support/spirv.rs"]
mod spirv;

use fresh::{agrees, root};
use glsl::{Item, Struct};
use glslang::Glslang;
use spirv::Module;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::{env, fs};

const HEADERS: [&str; 2] = ["kernels/abi.h", "kernels/abi_scene.h"];
const BINDINGS: &str = "src/cuda/abi.rs";
const GLSL: &str = "vk_shaders/abi.glsl";
const TITLE: &str =
    "Made of kernels/abi.h and abi_scene.h by tests/shaders.rs: change those, and read their comments there.";
const FOLDER: &str = "vk_shaders";
const STAGES: [&str; 8] = ["mesh", "task", "frag", "vert", "tesc", "tese", "comp", "geom"];
/// The capability FragmentShadingRateKHR: glslang 12 declares it for mesh shaders that do not use it.
const FRAGMENT_SHADING_RATE: u32 = 4422;
/// The capability MeshShadingEXT.
const MESH_SHADING: u32 = 5283;
const TRIANGLE: &str = "#version 460
#extension GL_EXT_mesh_shader : require
layout(local_size_x = 1) in;
layout(triangles, max_vertices = 3, max_primitives = 1) out;
void main() {
    SetMeshOutputsEXT(3, 1);
    for (uint i = 0; i < 3; i++) gl_MeshVerticesEXT[i].gl_Position = vec4(i & 1, i >> 1, 0, 1);
    gl_PrimitiveTriangleIndicesEXT[0] = uvec3(0, 1, 2);
    gl_MeshPrimitivesEXT[0].gl_CullPrimitiveEXT = false;
}
";

/// All that host and device share.
fn header() -> Vec<glsl::Item> {
    HEADERS.iter().flat_map(|page| glsl::read(&text(page))).collect()
}

/// The structs are written before a shader that includes them is compiled.
static ABI: LazyLock<()> = LazyLock::new(|| agrees(GLSL, &glsl::write(TITLE, &header())));
/// What the compiler makes of every shader, committed anew if that is asked for; nothing where there is no compiler.
static COMPILED: LazyLock<Vec<Compiled>> = LazyLock::new(compile_all);

struct Compiled {
    shader: PathBuf,
    /// The module, or what the compiler says.
    made: Result<Vec<u8>, String>,
}

#[test]
fn the_glsl_side_of_the_abi_is_fresh() {
    LazyLock::force(&ABI);
}

#[test]
fn modules_are_what_the_compiler_makes_of_the_shaders() {
    let stale = COMPILED.iter().filter_map(|Compiled { shader, made }| match made {
        Err(said) => Some(format!("{}:\n{said}", shader.display())),
        Ok(made) => (fs::read(module_of(shader)).ok().as_ref() != Some(made)).then(|| shader.display().to_string()),
    });
    let stale: Vec<String> = stale.collect();
    let mend = "run HALFPIXEL_UPDATE=1 cargo test --test shaders, and commit the .spv";
    assert!(stale.is_empty(), "shaders that do not compile or whose module is stale ({mend}):\n{}", stale.join("\n"));
}

#[test]
fn every_module_has_its_shader() {
    LazyLock::force(&COMPILED);
    let expected: BTreeSet<PathBuf> = shaders().iter().map(|shader| module_of(shader)).collect();
    let committed: BTreeSet<PathBuf> = files(&["spv"]).into_iter().collect();
    let odd: Vec<_> = committed.symmetric_difference(&expected).collect();
    assert!(odd.is_empty(), "modules without a shader, or shaders without a module: {odd:#?}");
}

#[test]
fn modules_ask_for_what_devices_have() {
    LazyLock::force(&COMPILED);
    for path in files(&["spv"]) {
        let module = Module::read(&fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display())));
        assert_eq!(module.version(), (1, 6), "SPIR-V version of {}", path.display());
        let rate = module.capabilities().contains(&FRAGMENT_SHADING_RATE);
        assert!(!rate, "{} declares FragmentShadingRateKHR", path.display());
    }
}

#[test]
fn modules_are_valid() {
    LazyLock::force(&COMPILED);
    let Some(glslang) = Glslang::installed() else { return };
    for path in files(&["spv"]) {
        glslang.validate(&path).unwrap_or_else(|said| panic!("{}: {said}", path.display()));
    }
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

/// As above, but by the compiler's own offsets.
#[test]
fn the_compiler_lays_structs_out_as_the_host() {
    LazyLock::force(&ABI);
    let Some(glslang) = Glslang::installed() else { return };
    let module = compiled_text(&glslang, "all_structs.comp", &shader_of_all(&structs()));
    let bindings = text(BINDINGS);
    for one in structs() {
        let names = one.fields.iter().map(|field| (glsl::glsl_name(&field.name), field.name.clone()));
        let names: BTreeMap<String, String> = names.collect();
        let found = module.member_offsets(&one.name).into_iter();
        let found: BTreeMap<_, _> = found.filter_map(|(name, at)| Some((names.get(&name)?.clone(), at))).collect();
        assert_eq!(found, asserted_offsets(&bindings, &one.name), "{}", one.name);
        assert_eq!(module.array_stride(&one.name), asserted_size(&bindings, &one.name), "{}", one.name);
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

#[test]
fn modules_are_read() {
    let words: [u32; 11] = [0x0723_0203, 0x0001_0600, 11, 9, 0, 2 << 16 | 17, 4422, 2 << 16 | 17, 1, 2 << 16 | 19, 2];
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let module = Module::read(&bytes);
    assert_eq!((module.version(), module.capabilities()), ((1, 6), vec![FRAGMENT_SHADING_RATE, 1]));
}

#[test]
fn the_compiler_says_what_it_does_not_understand() {
    let Some(glslang) = Glslang::installed() else { return };
    let path = temporary("wrong.frag", "#version 460\nvoid main() { nothing(); }\n");
    let said = glslang.compile(&path).expect_err("a wrong shader");
    assert!(said.contains("wrong.frag") && said.contains("nothing"), "{said}");
}

/// Mesh shaders as the pinned compiler makes them: valid, without the capability that Debian 12's declares, the same twice.
#[test]
fn mesh_shaders_compile() {
    let Some(glslang) = Glslang::installed() else { return };
    let path = temporary("triangle.mesh", TRIANGLE);
    let made = glslang.compile(&path).unwrap_or_else(|said| panic!("{said}"));
    assert_eq!(Ok(&made), glslang.compile(&path).as_ref());
    let module = Module::read(&made);
    assert_eq!((module.version(), module.capabilities()), ((1, 6), vec![MESH_SHADING]));
}

fn compile_all() -> Vec<Compiled> {
    LazyLock::force(&ABI);
    let Some(glslang) = Glslang::installed() else { return Vec::new() };
    let update = env::var_os("HALFPIXEL_UPDATE").is_some();
    let compiled = shaders().into_iter().map(|shader| {
        let made = glslang.compile(&shader);
        if let (true, Ok(made)) = (update, &made) {
            let module = module_of(&shader);
            fs::write(&module, made).unwrap_or_else(|e| panic!("cannot write {}: {e}", module.display()));
        }
        Compiled { shader, made }
    });
    compiled.collect()
}

/// `meshlet.mesh` becomes `meshlet.mesh.spv`.
fn module_of(shader: &Path) -> PathBuf {
    PathBuf::from(format!("{}.spv", shader.display()))
}

fn shaders() -> Vec<PathBuf> {
    files(&STAGES)
}

/// Files of the folder that end so, sorted.
fn files(suffixes: &[&str]) -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join(FOLDER)).unwrap_or_else(|e| panic!("cannot list {FOLDER}: {e}"));
    let paths = entries.map(|entry| entry.unwrap_or_else(|e| panic!("cannot list {FOLDER}: {e}")).path());
    let ends_so = |path: &PathBuf| path.extension().is_some_and(|end| suffixes.iter().any(|suffix| end == *suffix));
    let mut found: Vec<PathBuf> = paths.filter(ends_so).collect();
    found.sort();
    found
}

/// A shader that reads and writes a buffer of every struct.
fn shader_of_all(structs: &[Struct]) -> String {
    let mut buffers = String::new();
    let mut copies = String::new();
    for (i, Struct { name, .. }) in structs.iter().enumerate() {
        buffers += &format!("layout(set = 0, binding = {i}, scalar) buffer List{i} {{ {name} list{i}[]; }};\n");
        copies += &format!("    list{i}[1] = list{i}[0];\n");
    }
    let start = "#version 460\n#extension GL_GOOGLE_include_directive : require\n#include \"abi.glsl\"\n";
    format!("{start}layout(local_size_x = 1) in;\n{buffers}void main() {{\n{copies}}}\n")
}

fn compiled_text(glslang: &Glslang, name: &str, shader: &str) -> Module {
    let made = glslang.compile_named(&temporary(name, shader));
    Module::read(&made.unwrap_or_else(|said| panic!("{said}")))
}

fn temporary(name: &str, shader: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&path, shader).unwrap_or_else(|e| panic!("cannot write {}: {e}", path.display()));
    path
}

fn structs() -> Vec<Struct> {
    let items = header().into_iter();
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
