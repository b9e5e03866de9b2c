//! What the cloth is made of: [`Fabric`], in physical units, and named presets.

mod fabric;
mod generic;
mod wang2011;

pub use fabric::{Fabric, MaterialError};

/// Makes one constructor per named fabric on [`Fabric`], and the list that [`Fabric::by_name`] searches.
macro_rules! presets {
    ($list:ident: $($(#[$doc:meta])* $name:ident => $value:expr;)+) => {
        impl Fabric {
            $($(#[$doc])* pub const fn $name() -> Self { $value })+
        }
        pub(super) const $list: &[(&str, fn() -> Fabric)] = &[$((stringify!($name), Fabric::$name)),+];
    };
}
use presets;

impl Fabric {
    /// All presets, with the name of each: the generic ones first, then the measured ones.
    pub fn presets() -> impl Iterator<Item = (&'static str, Fabric)> {
        generic::GENERIC.iter().chain(wang2011::WANG_2011).map(|(name, make)| (*name, make()))
    }

    /// The preset called `name`; `-` and `_` are the same, case does not matter.
    pub fn by_name(name: &str) -> Option<Self> {
        let wanted = name.to_lowercase().replace('-', "_");
        Self::presets().find(|(preset, _)| *preset == wanted).map(|(_, fabric)| fabric)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_valid_and_found_by_its_name() {
        let names: Vec<_> = Fabric::presets().map(|(name, _)| name).collect();
        assert_eq!(names.len(), 18);
        for name in names {
            let fabric = Fabric::by_name(&name.to_uppercase().replace('_', "-")).expect(name);
            fabric.validate().unwrap_or_else(|error| panic!("{name}: {error}"));
        }
        assert_eq!(Fabric::by_name("chainmail"), None);
    }
}
