//! `kernels/abi.h` for shaders: its constants and structs, as GLSL, and how a buffer in scalar layout holds them.

use std::fmt::{self, Display, Formatter};

/// A scalar of the header.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scalar {
    header: &'static str,
    glsl: &'static str,
    bytes: usize,
}

const SCALARS: [Scalar; 9] = [
    Scalar { header: "uint32_t", glsl: "uint", bytes: 4 },
    Scalar { header: "int32_t", glsl: "int", bytes: 4 },
    Scalar { header: "uint64_t", glsl: "uint64_t", bytes: 8 },
    Scalar { header: "uint16_t", glsl: "uint16_t", bytes: 2 },
    Scalar { header: "int16_t", glsl: "int16_t", bytes: 2 },
    Scalar { header: "uint8_t", glsl: "uint8_t", bytes: 1 },
    Scalar { header: "int8_t", glsl: "int8_t", bytes: 1 },
    Scalar { header: "float", glsl: "float", bytes: 4 },
    Scalar { header: "double", glsl: "double", bytes: 8 },
];
const UINT: Scalar = SCALARS[0];

/// Words that GLSL keeps for itself and C++ does not; as a name they get an underscore.
const RESERVED: &str = "active atomic_uint attribute buffer cast centroid coherent common discard filter fixed flat half \
                        highp in inout input interface invariant layout lowp mediump noinline noperspective out output \
                        partition patch precise precision readonly resource restrict sample sampler shared smooth \
                        subroutine superp texture uniform varying writeonly";

#[derive(Debug, PartialEq)]
pub struct Constant {
    pub scalar: Scalar,
    pub name: String,
    pub value: String,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    pub scalar: Scalar,
    pub name: String,
    pub dimensions: Vec<usize>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Struct {
    pub name: String,
    /// What `alignas` asks for, or 1.
    pub alignment: usize,
    pub fields: Vec<Field>,
}

#[derive(Debug, PartialEq)]
pub enum Item {
    Constant(Constant),
    Struct(Struct),
}

/// Bytes of a struct in scalar layout: where its fields begin, where the last one ends, from one to the next in an array.
#[derive(Debug, PartialEq)]
pub struct ScalarLayout {
    pub offsets: Vec<usize>,
    pub end: usize,
    pub stride: usize,
}

/// The items of a header that has one declaration a line. Members of enums become constants.
pub fn read(header: &str) -> Vec<Item> {
    let code = header.lines().map(|line| line.split("//").next().unwrap_or_default().trim());
    let mut lines = code.filter(|line| !line.is_empty() && !line.starts_with('#'));
    let mut items = Vec::new();
    while let Some(line) = lines.next() {
        let body = lines.by_ref().take_while(|line| *line != "};");
        if let Some(constant) = line.strip_prefix("static const ") {
            let (scalar, rest) = scalar_of(constant);
            items.push(Item::Constant(constant_of(scalar, rest.trim_end_matches(';'))));
        } else if line.starts_with("enum ") && line.ends_with(": uint32_t {") {
            items.extend(body.map(|member| Item::Constant(constant_of(UINT, member.trim_end_matches(',')))));
        } else if line.starts_with("struct ") && line.ends_with(" {") {
            items.push(Item::Struct(struct_of(line, body.map(field_of).collect())));
        } else {
            panic!("not understood: {line}");
        }
    }
    items
}

/// The items as a file that shaders include.
pub fn write(title: &str, items: &[Item]) -> String {
    let mut text = format!("// {title}\n#ifndef ABI_GLSL\n#define ABI_GLSL\n");
    for extension in ["int8", "int16", "int64"] {
        text += &format!("#extension GL_EXT_shader_explicit_arithmetic_types_{extension} : require\n");
    }
    text += "#extension GL_EXT_scalar_block_layout : require\n\n";
    for item in items {
        text += &match item {
            Item::Constant(constant) => format!("{constant}\n"),
            Item::Struct(one) => format!("\n{}\n", one.padded()),
        };
    }
    text.replace("\n\n\n", "\n\n") + "#endif\n"
}

impl Struct {
    /// `VK_EXT_scalar_block_layout`: a scalar is aligned to its own size, a struct to its largest scalar.
    pub fn scalar_layout(&self) -> ScalarLayout {
        let mut end = 0_usize;
        let offsets = self.fields.iter().map(|field| {
            let offset = end.next_multiple_of(field.scalar.bytes);
            end = offset + field.scalar.bytes * field.dimensions.iter().product::<usize>();
            offset
        });
        let offsets = offsets.collect();
        ScalarLayout { offsets, end, stride: end.next_multiple_of(self.largest_scalar()) }
    }

    /// With a member at its end where C++ makes the struct larger for its `alignas`, which GLSL does not have.
    pub fn padded(&self) -> Struct {
        let ScalarLayout { end, stride, .. } = self.scalar_layout();
        let size = end.next_multiple_of(self.alignment.max(self.largest_scalar()));
        let mut padded = self.clone();
        if size != stride {
            let words = (size - end.next_multiple_of(UINT.bytes)) / UINT.bytes;
            padded.fields.push(Field { scalar: UINT, name: "padding_".into(), dimensions: vec![words] });
        }
        padded
    }

    fn largest_scalar(&self) -> usize {
        self.fields.iter().map(|field| field.scalar.bytes).max().unwrap_or(1)
    }
}

impl Display for Constant {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let suffix = match self.scalar.header {
            "uint32_t" => "u",
            "uint64_t" => "ul",
            _ => "",
        };
        write!(f, "const {} {} = {}{suffix};", self.scalar.glsl, glsl_name(&self.name), self.value)
    }
}

impl Display for Struct {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        writeln!(f, "struct {} {{", glsl_name(&self.name))?;
        for field in &self.fields {
            let dimensions: String = field.dimensions.iter().map(|n| format!("[{n}]")).collect();
            writeln!(f, "    {} {}{dimensions};", field.scalar.glsl, glsl_name(&field.name))?;
        }
        writeln!(f, "}};")
    }
}

pub fn glsl_name(name: &str) -> String {
    let reserved = RESERVED.split_whitespace().any(|word| word == name);
    if reserved { format!("{name}_") } else { name.to_owned() }
}

fn scalar_of(declaration: &str) -> (Scalar, &str) {
    let parts = declaration.split_once(' ');
    let found = parts.and_then(|(kind, rest)| Some((*SCALARS.iter().find(|s| s.header == kind)?, rest)));
    found.unwrap_or_else(|| panic!("no scalar that is known: {declaration}"))
}

fn constant_of(scalar: Scalar, text: &str) -> Constant {
    let (name, value) = text.split_once(" = ").unwrap_or_else(|| panic!("no value: {text}"));
    Constant { scalar, name: name.into(), value: value.into() }
}

fn struct_of(line: &str, fields: Vec<Field>) -> Struct {
    let name = line.trim_start_matches("struct ").trim_end_matches(" {");
    let aligned = name.strip_prefix("alignas(").and_then(|rest| rest.split_once(") "));
    let (alignment, name) = aligned.map_or((1, name), |(bytes, name)| (number(bytes), name));
    Struct { name: name.into(), alignment, fields }
}

fn field_of(line: &str) -> Field {
    let (scalar, declarator) = scalar_of(line);
    let mut parts = declarator.trim_end_matches(';').split('[');
    let name = parts.next().unwrap_or_default().into();
    let dimensions = parts.map(|part| number(part.trim_end_matches(']'))).collect();
    Field { scalar, name, dimensions }
}

fn number(text: &str) -> usize {
    text.parse().unwrap_or_else(|e| panic!("{text}: {e}"))
}
