//! The banner of the default scene: gathered on a rod by rings, its lower edge pointed.
//!
//! The mesh is a wave extruded downwards, so it unrolls into the flat cloth it was cut from.

use crate::{
    glb::GlbMesh,
    paint::{mix, paint, with_grid},
    pleats::Pleats,
    sheet::grid_triangles,
};
use bevy::math::{Vec2, Vec3};
use image::{ImageFormat, RgbImage};
use std::{f32::consts::TAU, io::Cursor};

/// Name of the node in the file.
pub const NODE: &str = "Banner";

/// Width of the flat cloth in metres.
const CLOTH_WIDTH: f32 = 1.5;
/// Width on the rod in metres: the cloth is gathered to this.
pub const HUNG_WIDTH: f32 = 1.28;
/// Height at the sides in metres.
const SIDE_HEIGHT: f32 = 1.45;
/// Height in the middle in metres.
const MIDDLE_HEIGHT: f32 = 1.85;

/// Waves along the rod; a ring holds the crest between each two, and both ends.
const PLEATS: usize = 6;
/// Number of rings, evenly spread over the rod.
pub const RINGS: usize = PLEATS + 1;
const CELLS_PER_PLEAT: usize = 8;
const COLUMNS: usize = PLEATS * CELLS_PER_PLEAT;
const ROWS: usize = 56;

/// The mesh with its pins. The rings lie on y = 0 and the cloth hangs down from there.
pub fn banner() -> Result<GlbMesh, String> {
    let wave = Pleats::gathered(CLOTH_WIDTH, HUNG_WIDTH, PLEATS);
    let mut mesh =
        GlbMesh { name: NODE.into(), base_color: [1.0; 4], texture: Some(png(&heraldry())?), ..Default::default() };
    for row in 0..=ROWS {
        for column in 0..=COLUMNS {
            let across = column as f32 / COLUMNS as f32;
            let height = SIDE_HEIGHT + (MIDDLE_HEIGHT - SIDE_HEIGHT) * (1.0 - (2.0 * across - 1.0).abs());
            let down = height * row as f32 / ROWS as f32;
            let (position, normal) = wave.place(across * CLOTH_WIDTH);
            mesh.positions.push(position - Vec3::new(0.5 * HUNG_WIDTH, down, 0.0));
            mesh.normals.push(normal);
            mesh.uvs.push(Vec2::new(across, down / MIDDLE_HEIGHT));
            mesh.pins.push(if row == 0 && column % CELLS_PER_PLEAT == 0 { 1.0 } else { 0.0 });
        }
    }
    mesh.indices = grid_triangles(COLUMNS, ROWS);
    Ok(mesh)
}

const CRIMSON: [f32; 3] = [0.56, 0.07, 0.11];
const GOLD: [f32; 3] = [0.90, 0.66, 0.24];
const CREAM: [f32; 3] = [0.95, 0.90, 0.79];

/// A golden sun on crimson with a double border and a fine grid.
fn heraldry() -> RgbImage {
    const PIXELS_PER_METRE: f32 = 320.0;
    let size = Vec2::new(CLOTH_WIDTH, MIDDLE_HEIGHT);
    let pixels = size * PIXELS_PER_METRE;
    paint(pixels.x as u32, pixels.y as u32, |uv| {
        let place = uv * size;
        let across = 1.0 - (2.0 * uv.x - 1.0).abs();
        let lower_edge = SIDE_HEIGHT + (MIDDLE_HEIGHT - SIDE_HEIGHT) * across;
        let to_edge = place.x.min(CLOTH_WIDTH - place.x).min(place.y).min(0.88 * (lower_edge - place.y));
        let color = match to_edge {
            d if d < 0.045 => GOLD,
            d if (0.075..0.09).contains(&d) => CREAM,
            _ => sun(place - Vec2::new(0.5 * CLOTH_WIDTH, 0.72)).unwrap_or(CRIMSON),
        };
        with_grid(color, place, 0.0625)
    })
}

/// Colour of the sun at a place relative to its centre, in metres.
fn sun(place: Vec2) -> Option<[f32; 3]> {
    const RAYS: f32 = 16.0;
    let radius = place.length();
    // From 0 on a ray's axis to 1 half way to the next.
    let off_axis = 2.0 * (place.to_angle() / TAU * RAYS).rem_euclid(1.0);
    let off_axis = (off_axis - 1.0).abs();
    let ray_end = 0.24 + (0.42 - 0.24) * (1.0 - off_axis);
    match radius {
        r if r < 0.17 => Some(GOLD),
        r if r < 0.20 => Some(CRIMSON),
        r if r < 0.225 => Some(CREAM),
        r if r < ray_end => Some(mix(GOLD, CREAM, 0.15)),
        _ => None,
    }
}

fn png(picture: &RgbImage) -> Result<Vec<u8>, String> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mesh_unrolls_to_the_cloth_it_was_cut_from() {
        let mesh = banner().expect("a banner");
        let upper_edge = &mesh.positions[..=COLUMNS];
        let length: f32 = upper_edge.windows(2).map(|ends| ends[0].distance(ends[1])).sum();
        // The chords are a little shorter than the wave.
        assert!((length / CLOTH_WIDTH - 1.0).abs() < 0.02, "{length}");
        let rings = mesh.pins.iter().filter(|&&pin| pin == 1.0).count();
        assert_eq!(rings, RINGS);
        for (position, _) in mesh.positions.iter().zip(&mesh.pins).filter(|(_, pin)| **pin == 1.0) {
            assert!(position.y == 0.0 && position.z.abs() < 1e-4, "{position}");
        }
    }

    #[test]
    fn the_asset_is_what_the_generator_makes() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/banner.glb");
        let file = gltf::Gltf::from_slice(&std::fs::read(path).expect("assets/banner.glb")).expect("valid glTF");
        let blob = file.blob.expect("a binary chunk");
        for (expected, bytes) in banner().expect("a banner").positions.iter().zip(blob.chunks_exact(12)) {
            let number = |i: usize| f32::from_le_bytes([bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]]);
            let found = Vec3::new(number(0), number(4), number(8));
            assert!(found.distance(*expected) < 1e-5, "{found} {expected}: run `cargo run --example make_banner`");
        }
    }
}
