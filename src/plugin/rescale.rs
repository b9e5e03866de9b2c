//! A cloth whose entity changes its scale.

use bevy::math::{DAffine3, DMat3, DVec3};

use super::error::ClothError;
use super::state::{ClothState, representatives, rest_shape};
use crate::physics::{Cloth, MeshError, SurfaceMesh};

impl ClothState {
    /// Measures the cloth again under a transform of another scale, and keeps its deformation. What is left of the way to
    /// `anchor` is a rigid motion, like any other: only a mirrored cloth is carried all the way.
    ///
    /// A cloth of which vertices are held grows about its entity, a free one about its own middle: it is in the world.
    pub(super) fn rescale_to(&mut self, anchor: DAffine3) -> Result<(), ClothError> {
        let whole = anchor * self.anchor.inverse();
        // With both scale and turn in a tick, the pins turn in the step.
        let map = match stretch(whole.matrix3) {
            Some(stretch) => about(stretch, self.anchor.translation),
            None => whole,
        };
        let of_cloth = if self.is_anchored() { map } else { about(map.matrix3, middle(self.cloth.positions())) };
        let Self { cloth, binding, .. } = self;
        let positions: Vec<DVec3> = binding.mesh.positions.iter().map(|p| anchor.matrix3 * p.as_dvec3()).collect();
        let uvs = binding.mesh.uvs.as_deref();
        let mesh = SurfaceMesh { positions: &positions, triangles: &binding.mesh.triangles, uvs };
        match cloth.remeasure(&mesh, &binding.options, of_cloth) {
            Ok(()) => {}
            // An absolute weld distance joins other vertices at another scale.
            Err(MeshError::OtherMesh) => return self.build_again_at(anchor),
            Err(error) => return Err(error.into()),
        }
        binding.rest_linear = anchor.matrix3;
        for x in &mut self.previous_positions {
            *x = of_cloth.transform_point3(*x);
        }
        for anchor in [&mut self.anchor, &mut self.previous_anchor, &mut self.seen_anchor] {
            *anchor = map * *anchor;
        }
        self.revision += 1;
        Ok(())
    }

    /// Puts a cloth of other vertices at rest.
    fn build_again_at(&mut self, anchor: DAffine3) -> Result<(), ClothError> {
        let Self { cloth: old, binding, .. } = self;
        let shape = rest_shape(&binding.mesh, anchor.matrix3, &binding.options)?;
        let representatives = representatives(&shape);
        let mut cloth = Cloth::new(shape, *old.fabric(), *old.settings())?;
        cloth.set_gravity(old.gravity());
        cloth.set_contact_settings(old.contact_settings())?;
        self.cloth = cloth;
        binding.representatives = representatives;
        binding.rest_linear = anchor.matrix3;
        self.rest_at(anchor);
        Ok(())
    }
}

/// A linear map about a point.
fn about(linear: DMat3, point: DVec3) -> DAffine3 {
    DAffine3 { matrix3: linear, translation: point - linear * point }
}

fn middle(positions: &[DVec3]) -> DVec3 {
    positions.iter().sum::<DVec3>() / positions.len() as f64
}

/// Iterations of Newton's method for the polar decomposition: a stretch of 1e6 along one axis takes 24.
const ITERATIONS: u32 = 40;

/// P of the polar decomposition Q P, with Q a rotation and P symmetric (Higham 1986). `None` if the map mirrors.
fn stretch(linear: DMat3) -> Option<DMat3> {
    if linear.determinant() <= 0.0 {
        return None;
    }
    let mut rotation = linear;
    for _ in 0..ITERATIONS {
        let next = (rotation + rotation.inverse().transpose()) * 0.5;
        let done = next.abs_diff_eq(rotation, 1e-15);
        rotation = next;
        if done {
            break;
        }
    }
    let stretch = rotation.transpose() * linear;
    Some((stretch + stretch.transpose()) * 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stretch_of_a_map_is_what_its_rotation_leaves() {
        let turn = DMat3::from_rotation_z(2.5) * DMat3::from_rotation_x(0.7);
        for scale in [DVec3::ONE, DVec3::splat(1e-3), DVec3::new(2.0, 1.0, 0.5), DVec3::new(1e5, 1.0, 1.0)] {
            let axes = DMat3::from_rotation_y(0.3);
            let expected = axes * DMat3::from_diagonal(scale) * axes.transpose();
            let found = stretch(turn * expected).unwrap();
            assert!(found.abs_diff_eq(expected, 1e-9 * scale.max_element()), "{found} is not {expected}");
        }
        assert_eq!(stretch(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0))), None);
    }
}
