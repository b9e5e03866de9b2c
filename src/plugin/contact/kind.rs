//! What a collider is to cloth.

use bevy::prelude::*;
use parry3d::shape::{SharedShape, TypedShape};

use super::collider::ClothCollider;
use crate::physics::contact::is_sheet;

/// On which sides a [`ClothCollider`] keeps cloth out, as [`ClothCollider::kind`] tells. For a mesh it depends on its triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
pub enum ClothColliderKind {
    /// It has an inside, which cloth is moved out of.
    Solid,
    /// An open surface that keeps cloth on the side its triangles are seen counter-clockwise from: ground, a floor, a dome. Cloth that
    /// is behind it is free, and may come through from there.
    OneSided,
    /// A surface without inside that keeps cloth on either side; an open mesh that is part of a compound is one. Less steady than the
    /// others.
    TwoSided,
}

impl ClothCollider {
    /// What it is to cloth.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_cloth::plugin::{ClothCollider, ClothColliderKind, ClothShapeError};
    /// let ground = ClothCollider::from_mesh(&Plane3d::default().mesh().size(9.0, 9.0).build())?;
    /// assert_eq!(ground.kind(), ClothColliderKind::OneSided);
    /// # Ok::<(), ClothShapeError>(())
    /// ```
    pub fn kind(&self) -> ClothColliderKind {
        of_shape(self.shape())
    }
}

fn of_shape(shape: &SharedShape) -> ClothColliderKind {
    match shape.as_typed_shape() {
        TypedShape::TriMesh(mesh) if mesh.pseudo_normals_if_oriented().is_none() => ClothColliderKind::TwoSided,
        TypedShape::TriMesh(mesh) if is_sheet(mesh) => ClothColliderKind::OneSided,
        TypedShape::Triangle(_) | TypedShape::Segment(_) | TypedShape::Polyline(_) => ClothColliderKind::TwoSided,
        TypedShape::Compound(compound) => {
            let two_sided = |part| of_shape(part) != ClothColliderKind::Solid;
            if compound.shapes().iter().all(|(_, part)| two_sided(part)) {
                ClothColliderKind::TwoSided
            } else {
                ClothColliderKind::Solid
            }
        }
        _ => ClothColliderKind::Solid,
    }
}
