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
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgba)?;
    writer.finish().context("PNG")
}

fn srgb_bytes(frame: &Frame) -> Vec<u8> {
    let [width, height] = frame.camera.size;
    let pixels = (0..width * height).into_par_iter().map(|i| encode(frame.color(i % width, i / width)));
    pixels.collect::<Vec<_>>().into_flattened()
}

/// Linear RGBA to sRGB bytes (IEC 61966-2-1); alpha stays linear.
fn encode(rgba: [f32; 4]) -> [u8; 4] {
    let byte = |x: f32| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
    let curve = |x: f32| if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    let [r, g, b, a] = rgba;
    [byte(curve(r)), byte(curve(g)), byte(curve(b)), byte(a)]
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
