//! The command line: parse, then call `commands/`.
fn main() {}
