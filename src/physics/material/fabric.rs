//! The constants of a fabric.

use bevy::reflect::Reflect;
use bevy::reflect::std_traits::ReflectDefault;
use thiserror::Error;

use crate::physics::energy::mid_edge::FlexuralRigidity;

/// A fabric in physical units, per unit width or area: thickness never appears.
///
/// Membrane: energy per rest area `½ k0 ε00² + k1 ε00 ε11 + ½ k2 ε11² + k3 ε01²` of the Green strain ε in warp/weft
/// axes (orthotropic St. Venant–Kirchhoff; Narain et al. 2012). Bending: energy per area `½ D κ²`, where D depends on the
/// direction. The values are those of the sheet: they do not depend on mesh, time step or solver.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, PartialEq)]
pub struct Fabric {
    /// Mass per area ρ, kg/m².
    pub density: f32,
    /// Tensile stiffness along the warp, k0 = C11, N/m.
    pub warp_stiffness: f32,
    /// Tensile stiffness along the weft, k2 = C22, N/m.
    pub weft_stiffness: f32,
    /// Coupling of warp and weft (Poisson effect), k1 = C12, N/m. Needs `k0·k2 ≥ k1²`.
    pub coupling: f32,
    /// Shear term k3 = 2 G h, N/m: twice the shear stiffness per unit width.
    pub shear_stiffness: f32,
    /// Flexural rigidity D for curvature along the warp, N·m.
    pub warp_bending: f32,
    /// Flexural rigidity for curvature along the weft, N·m.
    pub weft_bending: f32,
    /// Flexural rigidity for curvature at 45° to both, N·m.
    pub bias_bending: f32,
    /// Poisson's ratio ν of bending, from −1 to 1: how far a sheet bent one way bends the other way across by itself.
    /// Hinges do not know it.
    pub bending_poisson: f32,
    /// Material damping dp, s: stiffness-proportional (Rayleigh), of deformation only. A mode of angular frequency ω
    /// decays at the rate `½ dp ω²`.
    pub damping: f32,
    /// Drag of the still air α, 1/s: mass-proportional, velocities decay as `exp(−α t)`.
    pub air_drag: f32,
}

/// A constant that no fabric can have.
#[derive(Clone, Debug, Error, PartialEq, Reflect)]
pub enum MaterialError {
    /// A constant is not a finite number, or is negative (the density: not above zero).
    #[error("`{constant}` is {value}: it must be a finite number, {}", if *constant == "density" {"above zero"} else {"not negative"})]
    OutOfRange {
        /// Name of the field.
        constant: &'static str,
        /// Its value.
        value: f32,
    },
    /// The bending energy would be unbounded below.
    #[error("`bending_poisson` is {value}: it must be from -1 to 1")]
    Poisson {
        /// ν.
        value: f32,
    },
    /// The membrane energy would be unbounded below.
    #[error(
        "`coupling`² ({coupling}²) exceeds `warp_stiffness` · `weft_stiffness` ({warp} · {weft}): such a sheet gains energy by stretching"
    )]
    NotPositive {
        /// k1.
        coupling: f32,
        /// k0.
        warp: f32,
        /// k2.
        weft: f32,
    },
}

impl Fabric {
    /// An isotropic sheet of Young's modulus times thickness `eh` (N/m), Poisson's ratio `nu` of stretch and bending, flexural
    /// rigidity `bending` (N·m) and `density` (kg/m²): k0 = k2 = Eh/(1−ν²), k1 = ν k0, k3 = Eh/(1+ν).
    pub const fn isotropic(density: f32, eh: f32, nu: f32, bending: f32) -> Self {
        let k0 = eh / (1.0 - nu * nu);
        Self {
            density,
            warp_stiffness: k0,
            weft_stiffness: k0,
            coupling: nu * k0,
            shear_stiffness: eh / (1.0 + nu),
            warp_bending: bending,
            weft_bending: bending,
            bias_bending: bending,
            bending_poisson: nu,
            damping: 0.005,
            air_drag: 1.0,
        }
    }

    /// `self` without damping of any kind: what is left is the integrator's.
    pub const fn undamped(self) -> Self {
        Self { damping: 0.0, air_drag: 0.0, ..self }
    }

    /// Checks every constant.
    ///
    /// # Errors
    /// The first constant that is not a finite number, is negative, or breaks `k0·k2 ≥ k1²`.
    pub fn validate(&self) -> Result<(), MaterialError> {
        let not_negative = [
            ("warp_stiffness", self.warp_stiffness),
            ("weft_stiffness", self.weft_stiffness),
            ("shear_stiffness", self.shear_stiffness),
            ("warp_bending", self.warp_bending),
            ("weft_bending", self.weft_bending),
            ("bias_bending", self.bias_bending),
            ("damping", self.damping),
            ("air_drag", self.air_drag),
        ];
        for (constant, value) in not_negative {
            if !(value.is_finite() && value >= 0.0) {
                return Err(MaterialError::OutOfRange { constant, value });
            }
        }
        if !(self.density.is_finite() && self.density > 0.0) {
            return Err(MaterialError::OutOfRange { constant: "density", value: self.density });
        }
        if !(-1.0..=1.0).contains(&self.bending_poisson) {
            return Err(MaterialError::Poisson { value: self.bending_poisson });
        }
        let (k0, k1, k2) = (self.warp_stiffness as f64, self.coupling as f64, self.weft_stiffness as f64);
        // A hair of slack: k1 = k0 = k2 is allowed and must survive rounding.
        if k1.is_nan() || k1 * k1 > k0 * k2 * (1.0 + 1e-6) {
            return Err(MaterialError::NotPositive {
                coupling: self.coupling,
                warp: self.warp_stiffness,
                weft: self.weft_stiffness,
            });
        }
        Ok(())
    }

    /// Flexural rigidity Ĉ of the sheet: that for which curvature along warp, weft and bias meets the given three, with the
    /// coupling `ν √(D_warp D_weft)`. A bias softer than any sheet of such warp and weft has the softest there is.
    pub fn flexural_rigidity(&self) -> FlexuralRigidity {
        let [warp, bias, weft] = [self.warp_bending, self.bias_bending, self.weft_bending].map(f64::from);
        let coupling = f64::from(self.bending_poisson) * (warp * weft).sqrt();
        // For curvature along 45°, (½, ½, ½)ᵀ Ĉ (½, ½, ½) = D_bias.
        FlexuralRigidity { warp, weft, coupling, twist: (4.0 * bias - warp - weft - 2.0 * coupling).max(0.0) }
    }

    /// Flexural rigidity for curvature along a direction at `angle` radians from the warp, N·m.
    ///
    /// `a + b cos 2φ + c cos 4φ` through the three given values, which is how the bending stiffness of an orthotropic
    /// plate turns with its axes (Ashton & Whitney 1970, transformed D11).
    pub fn bending_along(&self, angle: f64) -> f64 {
        let [d0, d45, d90] = [self.warp_bending, self.bias_bending, self.weft_bending].map(f64::from);
        let a = (d0 + 2.0 * d45 + d90) / 4.0;
        let b = (d0 - d90) / 2.0;
        let c = (d0 - 2.0 * d45 + d90) / 4.0;
        (a + b * (2.0 * angle).cos() + c * (4.0 * angle).cos()).max(0.0)
    }
}

impl Default for Fabric {
    /// [`Fabric::cotton`].
    fn default() -> Self {
        Self::cotton()
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_4;

    use super::*;

    #[test]
    fn impossible_constants_are_refused_by_name() {
        let refused = |fabric: Fabric| match fabric.validate() {
            Err(MaterialError::OutOfRange { constant, .. }) => constant,
            other => panic!("{other:?}"),
        };
        let cotton = Fabric::cotton();
        assert_eq!(refused(Fabric { density: 0.0, ..cotton }), "density");
        assert_eq!(refused(Fabric { density: f32::NAN, ..cotton }), "density");
        assert_eq!(refused(Fabric { shear_stiffness: -1.0, ..cotton }), "shear_stiffness");
        assert_eq!(refused(Fabric { bias_bending: f32::INFINITY, ..cotton }), "bias_bending");
        for bending_poisson in [f32::NAN, -1.5, 1.1] {
            let error = Fabric { bending_poisson, ..cotton }.validate().unwrap_err();
            assert!(matches!(error, MaterialError::Poisson { .. }), "{error}");
        }
        for coupling in [f32::NAN, 2.0 * cotton.warp_stiffness, -2.0 * cotton.warp_stiffness] {
            let error = Fabric { coupling, ..cotton }.validate().unwrap_err();
            assert!(matches!(error, MaterialError::NotPositive { .. }), "{error}");
        }
        Fabric::isotropic(0.1, 100.0, 0.0, 0.0).validate().unwrap();
    }

    #[test]
    fn bending_passes_through_the_three_measured_directions() {
        let fabric = Fabric { warp_bending: 4.0, bias_bending: 3.0, weft_bending: 2.0, ..Fabric::cotton() };
        for bending_poisson in [0.0, 0.3, -0.2] {
            let FlexuralRigidity { warp, weft, coupling, twist } =
                Fabric { bending_poisson, ..fabric }.flexural_rigidity();
            for (turn, expected) in [(0.0, 4.0), (1.0, 3.0), (2.0, 2.0), (3.0, 3.0), (4.0, 4.0)] {
                let angle = turn * FRAC_PI_4;
                assert!((fabric.bending_along(angle) - expected).abs() < 1e-12);
                let [xx, yy, xy] = [angle.cos().powi(2), angle.sin().powi(2), angle.cos() * angle.sin()];
                let along = warp * xx * xx + weft * yy * yy + 2.0 * coupling * xx * yy + twist * xy * xy;
                // At 135° K_xy is −½, which K_xy² does not feel.
                assert!((along - expected).abs() < 1e-12, "{along}");
            }
        }
    }

    #[test]
    fn an_isotropic_sheet_is_a_plate_and_no_bias_is_softer_than_a_sheet_can_be() {
        let plate = Fabric::isotropic(0.1, 100.0, 0.25, 2.0).flexural_rigidity();
        assert_eq!(plate, FlexuralRigidity { warp: 2.0, weft: 2.0, coupling: 0.5, twist: 3.0 });
        let fabric = Fabric { warp_bending: 1.0, weft_bending: 1.0, bias_bending: 0.1, ..Fabric::cotton() };
        assert_eq!(fabric.flexural_rigidity().twist, 0.0);
    }
}
