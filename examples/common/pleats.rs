//! Cloth gathered to less than its width: a wave, which unrolls into the flat cloth.

use bevy::math::Vec3;
use std::f32::consts::TAU;

/// z = amplitude · (cos(2π x / length) − 1), with a crest at the left end.
pub struct Pleats {
    amplitude: f32,
    length: f32,
    /// Arc length at evenly spaced x over one wave.
    arc: Vec<f32>,
}

impl Pleats {
    const SAMPLES: usize = 512;

    /// So many waves whose arc length is the cloth's width.
    pub fn gathered(cloth_width: f32, hung_width: f32, count: usize) -> Self {
        let length = hung_width / count as f32;
        let wanted = cloth_width / count as f32;
        let (mut low, mut high) = (0.0, length);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if Self::new(middle, length).arc[Self::SAMPLES] < wanted { low = middle } else { high = middle }
        }
        Self::new(low, length)
    }

    fn new(amplitude: f32, length: f32) -> Self {
        let mut wave = Self { amplitude, length, arc: vec![0.0] };
        let step = length / Self::SAMPLES as f32;
        for sample in 0..Self::SAMPLES {
            let slope = wave.slope((sample as f32 + 0.5) * step);
            wave.arc.push(wave.arc[sample] + step * (1.0 + slope * slope).sqrt());
        }
        wave
    }

    /// Place, from the left end, and normal at this arc length.
    pub fn place(&self, arc: f32) -> (Vec3, Vec3) {
        let x = self.x_at(arc);
        let depth = self.amplitude * ((TAU * x / self.length).cos() - 1.0);
        (Vec3::new(x, 0.0, depth), Vec3::new(-self.slope(x), 0.0, 1.0).normalize())
    }

    fn slope(&self, x: f32) -> f32 {
        -self.amplitude * TAU / self.length * (TAU * x / self.length).sin()
    }

    /// The x reached after this arc length.
    fn x_at(&self, arc: f32) -> f32 {
        let whole = self.arc[Self::SAMPLES];
        // Crests must fall on vertices exactly: round away the error of the division.
        let waves = ((arc / whole) * 1e4).round() / 1e4;
        let rest = waves.fract() * whole;
        let sample = self.arc.partition_point(|&arc| arc <= rest).min(Self::SAMPLES);
        let (before, after) = (self.arc[sample - 1], self.arc[sample]);
        let inside = sample as f32 - 1.0 + (rest - before) / (after - before);
        (waves.trunc() + inside / Self::SAMPLES as f32) * self.length
    }
}
