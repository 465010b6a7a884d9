//! Names of stages and groups of launches, for profilers: NVTX ranges.

/// Profilers put the library there that is told of ranges; NVTX itself asks for nothing else.
const TOOL: &str = if cfg!(target_pointer_width = "64") { "NVTX_INJECTION64_PATH" } else { "NVTX_INJECTION32_PATH" };

/// Ranges of one thread: a tool sees them nested as they were opened.
#[derive(Debug)]
pub(super) struct Ranges {
    /// There is a tool. NVTX does nothing without one, but making its strings takes time.
    told: bool,
}

impl Ranges {
    pub fn new() -> Self {
        Self { told: std::env::var_os(TOOL).is_some_and(|path| !path.is_empty()) }
    }

    pub fn open(&self, name: &'static str) {
        if self.told {
            push(name);
        }
    }

    pub fn close(&self) {
        if self.told {
            pop();
        }
    }
}

#[cfg(any(target_os = "linux", windows))]
fn push(name: &'static str) {
    nvtx::range_push!("{name}");
}

#[cfg(any(target_os = "linux", windows))]
fn pop() {
    nvtx::range_pop!();
}

#[cfg(not(any(target_os = "linux", windows)))]
fn push(_name: &'static str) {}

#[cfg(not(any(target_os = "linux", windows)))]
fn pop() {}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::path::Path;
    use std::process::Command;
    use std::{env, fs};

    const SAYS: &str = "HALFPIXEL_RANGES_TEST";

    /// Writes what it is told to the file that the environment names: NVTX's own interface for tools (nvtxTypes.h).
    const RECORDER: &str = r#"
        #include <stdio.h>
        #include <stdlib.h>
        typedef void (*Function)(void);
        struct Callbacks { size_t size; int (*table)(int module, Function ***table, unsigned *size); };
        static void say(const char *what, const char *name) {
            FILE *file = fopen(getenv("HALFPIXEL_RANGES_TEST"), "a");
            if (file) fprintf(file, "%s%s\n", what, name), fclose(file);
        }
        static int push(const char *name) { say("open ", name); return 0; }
        static int pop(void) { say("close", ""); return 0; }
        int InitializeInjectionNvtx2(const void *(*tables)(unsigned)) {
            const struct Callbacks *callbacks = (const struct Callbacks *)tables(1);
            Function **table;
            unsigned size;
            if (!callbacks || !callbacks->table(1, &table, &size) || size < 12) return 0;
            *table[9] = (Function)push;
            *table[11] = (Function)pop;
            return 1;
        }
    "#;

    /// What the next test runs in a process of its own: NVTX looks for a tool once.
    #[test]
    fn opens_and_closes() {
        let ranges = Ranges::new();
        assert_eq!(ranges.told, env::var_os(TOOL).is_some_and(|path| !path.is_empty()));
        if env::var_os(SAYS).is_some() {
            ranges.open("frame");
            ranges.open("cull");
            ranges.close();
            ranges.close();
        }
    }

    /// The same without a tool, with one that isn't there, and with one.
    #[test]
    fn a_tool_is_told() {
        let folder = env::temp_dir().join(format!("halfpixel-ranges-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let (source, tool, says) = (folder.join("tool.c"), folder.join("libtool.so"), folder.join("says"));
        fs::write(&source, RECORDER).expect("a source");
        let told = |tool: &Path| {
            let mut child = Command::new(env::current_exe().expect("this program"));
            child.args(["--exact", "cuda::ranges::tests::opens_and_closes"]).env(SAYS, &says).env(TOOL, tool);
            let output = child.output().expect("it starts");
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
            fs::read_to_string(&says).unwrap_or_default()
        };
        assert_eq!(told(Path::new("")), "");
        assert_eq!(told(&tool), "");
        let compiled = Command::new("cc").args(["-shared", "-fPIC", "-o"]).arg(&tool).arg(&source).status();
        if compiled.is_ok_and(|status| status.success()) {
            assert_eq!(told(&tool), "open frame\nopen cull\nclose\nclose\n");
        } else {
            eprintln!("skipped: cc makes no library here");
        }
        fs::remove_dir_all(&folder).expect("the folder");
    }
}
