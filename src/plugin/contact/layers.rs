//! Which cloth may touch which collider.

use bevy::ecs::entity::MapEntities;
use bevy::ecs::reflect::ReflectMapEntities;
use bevy::prelude::*;

/// Optional, on a cloth or a collider: groups that it is in, and groups that it touches, as bits.
///
/// Two of them touch if each is in a group that the other touches. Without the component: in all groups, touching all.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ClothLayers {
    /// Groups that it is in.
    pub memberships: u32,
    /// Groups that it touches.
    pub filters: u32,
}

impl ClothLayers {
    /// In every group, touching every group.
    pub const ALL: Self = Self { memberships: u32::MAX, filters: u32::MAX };

    /// In these groups, touching those.
    pub const fn new(memberships: u32, filters: u32) -> Self {
        Self { memberships, filters }
    }

    /// Whether both touch.
    pub const fn interacts_with(self, other: Self) -> bool {
        self.memberships & other.filters != 0 && other.memberships & self.filters != 0
    }
}

impl Default for ClothLayers {
    fn default() -> Self {
        Self::ALL
    }
}

/// Optional, on a cloth: it touches these colliders only, as far as [`ClothLayers`] let it.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq, Deref, DerefMut, MapEntities, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, MapEntities, Default, Clone, PartialEq)]
pub struct ClothCollidesWith(#[entities] pub Vec<Entity>);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_must_want_it() {
        let (cape, body, wall) = (ClothLayers::new(1, 2), ClothLayers::new(2, 1), ClothLayers::new(4, u32::MAX));
        assert!(cape.interacts_with(body) && body.interacts_with(cape));
        assert!(!cape.interacts_with(wall) && !wall.interacts_with(cape));
        assert!(ClothLayers::ALL.interacts_with(wall) && !ClothLayers::ALL.interacts_with(ClothLayers::new(0, 1)));
    }
}
