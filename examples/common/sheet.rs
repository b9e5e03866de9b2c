//! Grids, and a square sheet of any resolution.

use crate::paint::{paint, to_texture, with_grid};
use bevy::{asset::RenderAssetUsages, mesh::Indices, mesh::PrimitiveTopology, prelude::*};

/// A square of `side` metres and `resolution` × `resolution` vertices in the plane y = 0, row by row from −z to +z;
/// its warp runs along x.
pub fn sheet_mesh(side: f32, resolution: u32) -> Mesh {
    let cells = resolution as usize - 1;
    grid_mesh(cells, cells, |uv| side * Vec3::new(uv.x - 0.5, 0.0, uv.y - 0.5))
}

/// A grid of (columns + 1) × (rows + 1) vertices, row by row; `place` says where texture coordinates from 0 to 1 are.
pub fn grid_mesh(columns: usize, rows: usize, place: impl Fn(Vec2) -> Vec3) -> Mesh {
    let row = |row: usize| (0..=columns).map(move |column| (column as f32, row as f32));
    let cells = Vec2::new(columns as f32, rows as f32);
    let uvs: Vec<Vec2> = (0..=rows).flat_map(row).map(|uv| Vec2::from(uv) / cells).collect();
    let positions: Vec<Vec3> = uvs.iter().map(|&uv| place(uv)).collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
        .with_inserted_indices(Indices::U32(grid_triangles(columns, rows)))
        .with_computed_normals()
}

/// Two triangles per cell of a grid of (columns + 1) × (rows + 1) vertices, row by row downwards, seen from +z.
/// The diagonals alternate, so that the cloth has no preferred direction of its own.
pub fn grid_triangles(columns: usize, rows: usize) -> Vec<u32> {
    let mut indices = Vec::with_capacity(6 * columns * rows);
    let vertex = |row: usize, column: usize| (row * (columns + 1) + column) as u32;
    for row in 0..rows {
        for column in 0..columns {
            let (a, b) = (vertex(row, column), vertex(row, column + 1));
            let (c, d) = (vertex(row + 1, column), vertex(row + 1, column + 1));
            let cell = if (row + column) % 2 == 0 { [a, c, d, a, d, b] } else { [a, c, b, b, c, d] };
            indices.extend(cell);
        }
    }
    indices
}

const SAND: [f32; 3] = [0.93, 0.87, 0.76];
const INDIGO: [f32; 3] = [0.13, 0.22, 0.42];
const RUST: [f32; 3] = [0.74, 0.33, 0.18];

/// Woven stripes with a fine grid, for a sheet.
pub fn stripes() -> Image {
    to_texture(paint(512, 512, |uv| {
        let stripe = (12.0 * uv.x).rem_euclid(1.0);
        let color = match stripe {
            s if s < 0.46 => INDIGO,
            s if (0.62..0.68).contains(&s) || (0.78..0.84).contains(&s) => RUST,
            _ => SAND,
        };
        with_grid(color, uv, 1.0 / 24.0)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sheet_faces_up_and_has_the_size_asked_for() {
        let mesh = sheet_mesh(2.0, 3);
        assert_eq!(mesh.count_vertices(), 9);
        let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|values| values.as_float3()).expect("float3");
        assert_eq!((positions[0], positions[8]), ([-1.0, 0.0, -1.0], [1.0, 0.0, 1.0]));
        for triangle in mesh.triangles().expect("triangles") {
            let [a, b, c] = triangle.vertices.map(Vec3::from);
            assert_eq!((b - a).cross(c - a).normalize(), Vec3::Y);
        }
    }
}
