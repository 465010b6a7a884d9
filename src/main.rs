//! The command line: parse, then call `commands/`. Exit status 0: done, 1: it failed, 2: wrong usage.

fn main() -> std::process::ExitCode {
    halfpixel::commands::main(std::env::args_os())
}
