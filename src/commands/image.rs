//! Image files: PNG for people, EXR with every channel for programs.

use super::attributes::{Attributes, attributes};
use super::{UsageError, output};
use crate::scene::Scene;
use crate::stages::Frame;
use anyhow::{Context, Result};
use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage};
use rayon::prelude::*;
use std::io::{Seek, Write};
use std::path::Path;
use std::sync::LazyLock;

/// What an image file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// 8 bits a channel, sRGB.
    Png,
    /// Linear colour, depth, normal, position, parameters and numbers of face, patch and instance.
    Exr,
}

impl ImageFormat {
    /// By the suffix of the file's name.
    pub fn of(path: &Path) -> Result<Self, UsageError> {
        let suffix = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match suffix.as_str() {
            "png" => Ok(Self::Png),
            "exr" => Ok(Self::Exr),
            _ => Err(UsageError(format!("{}: images are written as .png or .exr: use one of them", path.display()))),
        }
    }
}

/// Writes a frame; the file appears whole or not at all.
pub fn write_frame(path: &Path, format: ImageFormat, scene: &Scene, frame: &Frame) -> Result<()> {
    let size = frame.camera.size;
    match format {
        ImageFormat::Png => {
            let bytes = srgb_bytes(frame);
            output::write_file(path, |file| write_png(file, size, &bytes))
        }
        ImageFormat::Exr => {
            let pixels = attributes(scene, frame);
            output::write_file(path, |file| write_exr(file, size, &pixels))
        }
    }
}

/// Writes 8-bit RGBA, row by row from the top, as PNG.
pub fn write_png(file: impl Write, size: [u32; 2], rgba: &[u8]) -> Result<()> {
    let mut encoder = png::Encoder::new(file, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fastest);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgba)?;
    writer.finish().context("PNG")
}

fn srgb_bytes(frame: &Frame) -> Vec<u8> {
    let [width, height] = frame.camera.size.map(|n| n as usize);
    let mut bytes = vec![0; width * height * 4];
    bytes.par_chunks_mut(width * 4).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
            let color = frame.color(x as u32, y as u32);
            // Background stays as it is.
            if color[3] > 0.0 {
                pixel.copy_from_slice(&encode(color));
            }
        }
    });
    bytes
}

/// Linear RGBA to sRGB bytes (IEC 61966-2-1); alpha stays linear.
fn encode([r, g, b, a]: [f32; 4]) -> [u8; 4] {
    let table = &*SRGB;
    [table.byte(r), table.byte(g), table.byte(b), byte(a)]
}

fn byte(x: f32) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// The byte of a linear value, by the formula.
fn srgb(x: f32) -> u8 {
    byte(if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 })
}

/// The same from a table: a power for each channel of each pixel would take longer than all else in a picture's file.
struct SrgbTable {
    /// The least value of each byte, and one beyond them all.
    least: [f32; 257],
    /// The byte of the least value with these upper 16 bits.
    first: Vec<u8>,
}

static SRGB: LazyLock<SrgbTable> = LazyLock::new(SrgbTable::new);

impl SrgbTable {
    fn new() -> Self {
        let one = 1f32.to_bits();
        let least = |k: usize| {
            let (mut low, mut high) = (0, one + 1);
            while low < high {
                let middle = (low + high) / 2;
                if usize::from(srgb(f32::from_bits(middle))) >= k { high = middle } else { low = middle + 1 }
            }
            if k > 255 { f32::INFINITY } else { f32::from_bits(low) }
        };
        Self {
            least: std::array::from_fn(least),
            first: (0..=one >> 16).map(|k| srgb(f32::from_bits(k << 16))).collect(),
        }
    }

    fn byte(&self, x: f32) -> u8 {
        // What is not a number is black.
        let x = if x > 0.0 { x.min(1.0) } else { return 0 };
        let mut byte = self.first[(x.to_bits() >> 16) as usize];
        while x >= self.least[usize::from(byte) + 1] {
            byte += 1;
        }
        byte
    }
}

/// Writes every channel as 32-bit EXR, lossless (ZIP).
pub fn write_exr(file: impl Write + Seek, size: [u32; 2], pixels: &[Attributes]) -> Result<()> {
    let real = |name: &str, of: fn(&Attributes) -> f32| {
        AnyChannel::new(name, FlatSamples::F32(pixels.par_iter().map(of).collect()))
    };
    let number = |name: &str, of: fn(&Attributes) -> u32| {
        AnyChannel::new(name, FlatSamples::U32(pixels.par_iter().map(of).collect()))
    };
    let channels = [
        real("R", |p| p.rgba[0]),
        real("G", |p| p.rgba[1]),
        real("B", |p| p.rgba[2]),
        real("A", |p| p.rgba[3]),
        real("Z", |p| p.depth),
        real("N.X", |p| p.normal[0]),
        real("N.Y", |p| p.normal[1]),
        real("N.Z", |p| p.normal[2]),
        real("P.X", |p| p.position[0]),
        real("P.Y", |p| p.position[1]),
        real("P.Z", |p| p.position[2]),
        real("uv.U", |p| p.uv[0]),
        real("uv.V", |p| p.uv[1]),
        number("id.face", |p| p.id[0]),
        number("id.patch", |p| p.id[1]),
        number("id.instance", |p| p.id[2]),
    ];
    let size = (size[0] as usize, size[1] as usize);
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let software_name = Some(concat!("halfpixel ", env!("CARGO_PKG_VERSION")).into());
    let attributes = LayerAttributes { software_name, ..LayerAttributes::default() };
    let image = Image::from_layer(Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, channels));
    image.write().to_buffered(file).context("EXR")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_says_what_the_formula_says() {
        let values = (0..=1f32.to_bits() + 1000).step_by(997).map(f32::from_bits);
        let borders = SRGB.least.iter().flat_map(|x| [x.next_down(), *x, x.next_up()]);
        for x in values.chain(borders).chain([-1.0, -0.0, 2.0, f32::NAN, f32::NEG_INFINITY]) {
            assert_eq!(SRGB.byte(x), srgb(x), "{x}");
        }
        assert_eq!([0.0, 0.5, 1.0].map(|x| SRGB.byte(x)), [0, 188, 255]);
    }
}
