//! Generic fabrics.
//!
//! Typical values of the class, not measurements of one cloth. Bending comes from a typical bending length c of the
//! cantilever test (ASTM D1388), D = ρ g c³, such that silk, cotton, wool and denim drape as fabrics of their class do on Cusick's
//! drapemeter; stretch is the initial slope of a typical load–extension curve; the bias
//! is what a weave gives way to, so its stiffness is far below warp and weft. Leather and rubber are isotropic sheets of the
//! thickness and Young's modulus named. Damping is chosen by eye.

use super::{Fabric, presets};

const GRAVITY: f32 = 9.81;

/// Flexural rigidity (N·m) of a sheet of `density` (kg/m²) whose bending length is `c` metres: D = ρ g c³.
const fn from_bending_length(density: f32, c: f32) -> f32 {
    density * GRAVITY * c * c * c
}

struct Weave {
    density: f32,
    stretch: [f32; 2],
    shear: f32,
    /// Bending lengths along warp, weft and bias, m.
    bending_lengths: [f32; 3],
    damping: f32,
}

const fn woven(weave: Weave) -> Fabric {
    let [warp, weft, bias] = weave.bending_lengths;
    let [warp_stiffness, weft_stiffness] = weave.stretch;
    Fabric {
        density: weave.density,
        warp_stiffness,
        weft_stiffness,
        // Crimp interchange couples the yarns weakly.
        coupling: 0.1 * if warp_stiffness < weft_stiffness { warp_stiffness } else { weft_stiffness },
        shear_stiffness: weave.shear,
        warp_bending: from_bending_length(weave.density, warp),
        weft_bending: from_bending_length(weave.density, weft),
        bias_bending: from_bending_length(weave.density, bias),
        bending_poisson: 0.0,
        damping: weave.damping,
        air_drag: 1.0,
    }
}

presets! { GENERIC:
    /// Plain-weave cotton, shirt or bed-sheet weight: 150 g/m², bending length about 2 cm.
    cotton => woven(Weave { density: 0.15, stretch: [2000.0, 1500.0], shear: 80.0, bending_lengths: [0.021, 0.019, 0.020], damping: 0.005 });
    /// Light silk: 60 g/m², flows and shimmers; bending length about 1.2 cm.
    silk => woven(Weave { density: 0.06, stretch: [1500.0, 1200.0], shear: 25.0, bending_lengths: [0.013, 0.011, 0.011], damping: 0.003 });
    /// Wool suiting: 250 g/m², soft and a little elastic; bending length about 2 cm.
    wool => woven(Weave { density: 0.25, stretch: [900.0, 600.0], shear: 50.0, bending_lengths: [0.019, 0.017, 0.017], damping: 0.01 });
    /// Denim: 400 g/m², stiff; bending length about 3 cm.
    denim => woven(Weave { density: 0.40, stretch: [5000.0, 3000.0], shear: 250.0, bending_lengths: [0.033, 0.028, 0.028], damping: 0.01 });
    /// Canvas, sail or tent cloth: 450 g/m², very stiff; bending length about 4.5 cm.
    canvas => woven(Weave { density: 0.45, stretch: [8000.0, 7000.0], shear: 800.0, bending_lengths: [0.048, 0.044, 0.040], damping: 0.01 });
    /// Single-jersey knit (T-shirt): 180 g/m², stretches by hand; bending length about 1.3 cm.
    jersey => woven(Weave { density: 0.18, stretch: [120.0, 60.0], shear: 60.0, bending_lengths: [0.013, 0.012, 0.012], damping: 0.01 });
    /// Leather, 1 mm: E = 30 MPa, ν = 0.4, 900 g/m²; D = E h³/12(1−ν²).
    leather => Fabric { damping: 0.02, ..Fabric::isotropic(0.9, 30e3, 0.4, 30e6 * 1e-9 / (12.0 * (1.0 - 0.16))) };
    /// Rubber sheet, 1 mm: E = 1.5 MPa, ν = 0.49, 1.1 kg/m²; D = E h³/12(1−ν²).
    rubber => Fabric { damping: 0.01, ..Fabric::isotropic(1.1, 1.5e3, 0.49, 1.5e6 * 1e-9 / (12.0 * (1.0 - 0.2401))) };
}
