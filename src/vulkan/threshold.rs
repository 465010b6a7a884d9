//! From how many pixels on hardware draws a quad faster than software does: measured on each device by `bench raster`, and kept
//! in the user's cache. Speed alone hangs on it, never the picture.

use super::Found;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::{env, fs, io};

/// Pixels along the longer side of a quad, where nothing has been measured: ETER section 6.2 calls smaller triangles small.
pub const UNMEASURED: f64 = 16.0;

/// Where it is kept: in `HALFPIXEL_CACHE`, `XDG_CACHE_HOME` or `HOME/.cache`, whichever is set first.
pub fn file() -> Option<PathBuf> {
    let folder = |name: &str| env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let cache = folder("HALFPIXEL_CACHE")
        .or_else(|| folder("XDG_CACHE_HOME").map(|f| f.join("halfpixel")))
        .or_else(|| folder("HOME").map(|f| f.join(".cache/halfpixel")))?;
    Some(cache.join("raster.json"))
}

/// What was measured on a device with this driver.
pub fn stored(found: &Found) -> Option<f64> {
    let pixels = *read().ok()?.get(&key(found))?;
    // Nobody's file is trusted with what is no number of pixels.
    (pixels.is_finite() && pixels >= 0.0).then_some(pixels)
}

/// Keeps it beside those of other devices; the file it is in.
pub fn store(found: &Found, pixels: f64) -> io::Result<PathBuf> {
    let path = file().ok_or_else(|| io::Error::other("neither HALFPIXEL_CACHE, XDG_CACHE_HOME nor HOME is set"))?;
    let mut all = read().unwrap_or_default();
    all.insert(key(found), pixels);
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::write(&path, serde_json::to_string_pretty(&all).map_err(io::Error::other)? + "\n")?;
    Ok(path)
}

fn key(found: &Found) -> String {
    format!("{}, {}, {}", found.name, found.driver, found.uuid)
}

fn read() -> io::Result<BTreeMap<String, f64>> {
    let path = file().ok_or_else(|| io::Error::other("no folder for it"))?;
    serde_json::from_str(&fs::read_to_string(path)?).map_err(io::Error::other)
}
