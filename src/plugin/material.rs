//! The fabric of a cloth, as a component.

use bevy::prelude::*;

use crate::physics::Fabric;

/// What the cloth is made of: a [`Fabric`] in physical units (kg/m², N/m, N·m, s), [`Fabric::cotton`] by default.
/// May change at any time.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Deref, DerefMut, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ClothMaterial(pub Fabric);

/// The presets of [`Fabric`] by name.
macro_rules! presets {
    ($($name:ident)+) => {
        impl ClothMaterial {
            $(
                #[doc = concat!("[`Fabric::", stringify!($name), "`].")]
                pub const fn $name() -> Self {
                    Self(Fabric::$name())
                }
            )+
        }

        #[cfg(test)]
        const NAMES: &[(&str, ClothMaterial)] = &[$((stringify!($name), ClothMaterial::$name())),+];
    };
}

presets! {
    cotton silk wool denim canvas jersey leather rubber
    ivory_rib_knit pink_ribbon_brown white_dots_on_blk navy_sparkle_sweat camel_ponte_roma gray_interlock
    black_denim_11oz white_swim_solid tango_red_jet_set royal_target
}

impl ClothMaterial {
    /// The preset called `name`; `-` and `_` are the same, case does not matter.
    pub fn by_name(name: &str) -> Option<Self> {
        Fabric::by_name(name).map(Self)
    }
}

impl From<Fabric> for ClothMaterial {
    fn from(fabric: Fabric) -> Self {
        Self(fabric)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_of_the_physics_has_a_constructor() {
        let presets: Vec<_> = Fabric::presets().map(|(name, fabric)| (name, ClothMaterial(fabric))).collect();
        assert_eq!(presets, NAMES);
        assert_eq!(ClothMaterial::by_name("Royal-Target"), Some(ClothMaterial::royal_target()));
    }
}
