//! Colour patterns computed pixel by pixel, so that no picture files are needed.

use bevy::{
    asset::RenderAssetUsages,
    image::{Image, ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    math::Vec2,
};
use image::{DynamicImage, Rgb, RgbImage};

/// Samples per pixel in each direction: smooth edges.
const SAMPLES: u32 = 3;

/// A picture of `width` × `height` pixels whose sRGB colour at (0…1, 0…1), from the top left, is given by `color`.
pub fn paint(width: u32, height: u32, color: impl Fn(Vec2) -> [f32; 3]) -> RgbImage {
    let size = Vec2::new(width as f32, height as f32);
    RgbImage::from_fn(width, height, |x, y| {
        let mut sum = [0.0; 3];
        for sample in 0..SAMPLES * SAMPLES {
            let inside = Vec2::new((sample % SAMPLES) as f32 + 0.5, (sample / SAMPLES) as f32 + 0.5) / SAMPLES as f32;
            let value = color((Vec2::new(x as f32, y as f32) + inside) / size);
            for (sum, value) in sum.iter_mut().zip(value) {
                *sum += value;
            }
        }
        Rgb(sum.map(|sum| (255.0 * sum / (SAMPLES * SAMPLES) as f32).round() as u8))
    })
}

/// The picture as a texture that repeats.
pub fn to_texture(picture: RgbImage) -> Image {
    let mut texture = Image::from_dynamic(DynamicImage::ImageRgb8(picture), true, RenderAssetUsages::default());
    texture.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        ..ImageSamplerDescriptor::linear()
    });
    texture
}

/// Linear mixture of two colours.
pub fn mix(a: [f32; 3], b: [f32; 3], share_of_b: f32) -> [f32; 3] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * share_of_b)
}

/// Darkens along the lines of a square grid, so that the eye sees how the cloth is sheared and stretched.
/// `place` and `pitch` have the same unit.
pub fn with_grid(color: [f32; 3], place: Vec2, pitch: f32) -> [f32; 3] {
    let to_line = (place / pitch - (place / pitch).round()).abs() * pitch;
    let line_width = 0.05 * pitch;
    if to_line.min_element() < line_width { mix(color, [0.0; 3], 0.22) } else { color }
}
