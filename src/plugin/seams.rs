//! Cloths that look like one: a mesh of several materials comes from a glTF file as several meshes beside each other.

use bevy::platform::collections::HashSet;
use bevy::prelude::*;

use super::state::ClothState;

type Sibling<'a> = (NameOrEntity, &'a ClothState, &'a ChildOf, &'a Transform);

/// Tells of cloths that have just started, and of the border that they have in common with others of the same parent.
pub(super) fn tell_of_seams(
    started: Query<Entity, (Added<ClothState>, With<ChildOf>)>,
    cloths: Query<Sibling>,
    families: Query<&Children>,
) {
    for entity in &started {
        let Ok((name, state, parent, transform)) = cloths.get(entity) else { continue };
        let siblings = families.get(parent.parent()).into_iter().flatten();
        let border: HashSet<_> = state.border().collect();
        for (other, other_state, ..) in siblings
            // Of two that have just started, the later one tells.
            .filter(|&&sibling| sibling < entity || (sibling != entity && !started.contains(sibling)))
            .filter_map(|&sibling| cloths.get(sibling).ok())
            .filter(|(_, other, _, at)| *at == transform && other.source_mesh() != state.source_mesh())
        {
            let common = other_state.border().collect::<HashSet<_>>().intersection(&border).count();
            if common > 1 {
                tracing::warn!(
                    "cloth {name}: {common} vertices of its border are those of cloth {other} beside it, as where one mesh has \
                     several materials: they are two cloths, and come apart there; to make them one, put `ClothMesh` on their \
                     parent instead"
                );
            }
        }
    }
}

impl ClothState {
    /// Places of the vertices at the border, in the space of the mesh, as bits: the parts of one mesh agree to the last.
    fn border(&self) -> impl Iterator<Item = [u32; 3]> {
        let vertices = self.cloth.shape().boundary.as_flattened().iter();
        vertices.map(|&vertex| {
            let place = self.binding.mesh.positions[self.binding.representatives[vertex as usize] as usize];
            // Zero has two signs.
            (place + Vec3::ZERO).to_array().map(f32::to_bits)
        })
    }
}
