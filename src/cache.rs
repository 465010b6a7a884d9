//! What benches measured on this machine's devices, kept in the user's cache: files with a JSON object each, by device and driver.
//! A file that can't be read, or not as what is asked for, holds nothing.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// A file of the cache: in `HALFPIXEL_CACHE`, `XDG_CACHE_HOME` or `HOME/.cache`, whichever is set first.
pub fn file(name: &str) -> io::Result<PathBuf> {
    let folder = |name: &str| env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let cache = folder("HALFPIXEL_CACHE")
        .or_else(|| folder("XDG_CACHE_HOME").map(|f| f.join("halfpixel")))
        .or_else(|| folder("HOME").map(|f| f.join(".cache/halfpixel")));
    let cache = cache.ok_or_else(|| io::Error::other("neither HALFPIXEL_CACHE, XDG_CACHE_HOME nor HOME is set"))?;
    Ok(cache.join(name))
}

/// What is kept of a device.
pub fn get<T: DeserializeOwned>(file: &Path, device: &str) -> Option<T> {
    serde_json::from_value(read(file)?.remove(device)?).ok()
}

/// Keeps it beside what there is of other devices.
pub fn put(file: &Path, device: &str, found: &impl Serialize) -> io::Result<()> {
    let mut all = read(file).unwrap_or_default();
    all.insert(device.into(), serde_json::to_value(found).map_err(io::Error::other)?);
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::write(file, serde_json::to_string_pretty(&all).map_err(io::Error::other)? + "\n")
}

fn read(file: &Path) -> Option<BTreeMap<String, Value>> {
    serde_json::from_str(&fs::read_to_string(file).ok()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_are_kept_beside_each_other_and_what_is_broken_is_nothing() {
        let folder = env::temp_dir().join(format!("halfpixel-cache-{}", std::process::id()));
        let file = folder.join("some/kept.json");
        assert_eq!(get::<f64>(&file, "a"), None);
        put(&file, "a", &1.5).unwrap();
        put(&file, "b", &[1, 2]).unwrap();
        assert_eq!((get(&file, "a"), get(&file, "b")), (Some(1.5), Some([1, 2])));
        assert_eq!((get::<f64>(&file, "b"), get::<f64>(&file, "c")), (None, None));
        for broken in ["", "{\"a\": 1.5", "[1.5]", "nonsense"] {
            fs::write(&file, broken).unwrap();
            assert_eq!(get::<f64>(&file, "a"), None, "{broken}");
        }
        put(&file, "a", &2.5).unwrap();
        assert_eq!(get(&file, "a"), Some(2.5));
        fs::remove_dir_all(folder).unwrap();
    }
}
