//! A cloth whose entity changes its scale.

use bevy::math::{DAffine3, DMat3, DVec3};

use super::error::ClothError;
use super::geometry::polar;
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
        let map = if whole.matrix3.determinant() > 0.0 {
            about(polar(whole.matrix3).1, self.anchor.translation)
        } else {
            whole
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
