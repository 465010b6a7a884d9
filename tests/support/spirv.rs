//! SPIR-V modules: the words that tests of shaders ask about (SPIR-V specification 1.6, sections 2.3 and 3).

const MAGIC: u32 = 0x0723_0203;
const HEADER_WORDS: usize = 5;
const OP_NAME: u32 = 5;
const OP_MEMBER_NAME: u32 = 6;
const OP_CAPABILITY: u32 = 17;
const OP_TYPE_RUNTIME_ARRAY: u32 = 29;
const OP_DECORATE: u32 = 71;
const OP_MEMBER_DECORATE: u32 = 72;
const ARRAY_STRIDE: u32 = 6;
const OFFSET: u32 = 35;

pub struct Module {
    words: Vec<u32>,
}

impl Module {
    pub fn read(bytes: &[u8]) -> Module {
        let (words, rest) = bytes.as_chunks::<4>();
        let words: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
        assert!(rest.is_empty() && words.len() >= HEADER_WORDS && words[0] == MAGIC, "no SPIR-V module");
        Module { words }
    }

    /// Major and minor version.
    pub fn version(&self) -> (u8, u8) {
        let [_, major, minor, _] = self.words[1].to_be_bytes();
        (major, minor)
    }

    pub fn capabilities(&self) -> Vec<u32> {
        self.operands(OP_CAPABILITY).map(|operands| operands[0]).collect()
    }

    /// Names and byte offsets of a struct's members, as the struct of this name that lies in a buffer has them.
    pub fn member_offsets(&self, of: &str) -> Vec<(String, usize)> {
        let id = self.buffer_struct(of).unwrap_or_else(|| panic!("no struct {of} in a buffer"));
        let names = self.operands(OP_MEMBER_NAME).filter(|operands| operands[0] == id);
        let names = names.map(|operands| (text(&operands[2..]), self.offset(id, operands[1])));
        names.map(|(name, offset)| (name, offset.expect("a member's offset"))).collect()
    }

    /// Bytes from one to the next in an array without end of a struct of this name.
    pub fn array_stride(&self, of: &str) -> Option<usize> {
        let element = self.buffer_struct(of)?;
        let array = self.operands(OP_TYPE_RUNTIME_ARRAY).find(|operands| operands[1] == element)?[0];
        let stride = self.operands(OP_DECORATE).find(|operands| operands[..2] == [array, ARRAY_STRIDE])?[2];
        Some(stride as usize)
    }

    fn buffer_struct(&self, name: &str) -> Option<u32> {
        let named = self.operands(OP_NAME).filter(|operands| text(&operands[1..]) == name);
        named.map(|operands| operands[0]).find(|&id| self.offset(id, 0).is_some())
    }

    fn offset(&self, id: u32, member: u32) -> Option<usize> {
        let mut decorations = self.operands(OP_MEMBER_DECORATE);
        let found = decorations.find(|operands| operands[..3] == [id, member, OFFSET]);
        found.map(|operands| operands[3] as usize)
    }

    /// Operands of every instruction of this kind.
    fn operands(&self, opcode: u32) -> impl Iterator<Item = &[u32]> {
        let mut rest = &self.words[HEADER_WORDS..];
        let instructions = std::iter::from_fn(move || {
            let first = *rest.first()?;
            let (instruction, after) = rest.split_at((first >> 16).max(1) as usize);
            rest = after;
            Some((first & 0xffff, &instruction[1..]))
        });
        instructions.filter(move |&(found, _)| found == opcode).map(|(_, operands)| operands)
    }
}

/// A literal string: UTF-8 that ends with a zero.
fn text(words: &[u32]) -> String {
    let bytes = words.iter().flat_map(|word| word.to_le_bytes()).take_while(|&byte| byte != 0);
    String::from_utf8_lossy(&bytes.collect::<Vec<u8>>()).into_owned()
}
