//! How far a motion is from another, in several measures.

use bevy::math::DVec3;
use serde::Serialize;

use super::body::{Body, Figures, Ruler};

/// A motion, frame by frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// Positions at the end of each frame, m.
    pub frames: Vec<Vec<DVec3>>,
    /// What the cloth is like then.
    pub figures: Vec<Figures>,
}

/// How far a method is from the truth. All are relative to something: the side of a sheet is 1 m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Root mean square distance from the true motion over half a second, m.
    pub motion_m: f64,
    /// Root mean square distance from the shape at rest after two seconds in thick air that began there, m.
    pub settled_m: f64,
    /// Root mean square difference, over the frames, of the root mean square elongation from that of the true motion, relative to
    /// its mean there.
    pub stretch: f64,
    /// Root mean square difference of the total energy from that of the true motion, in weights of the sheet times its side.
    pub energy: f64,
}

/// One of the [`Errors`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Measure {
    /// [`Errors::motion_m`].
    Motion,
    /// [`Errors::settled_m`].
    Settled,
    /// [`Errors::stretch`].
    Stretch,
    /// [`Errors::energy`].
    Energy,
}

impl Trace {
    /// Adds what a body is like now.
    pub fn push(&mut self, body: &dyn Body, ruler: &mut Ruler) {
        self.frames.push(body.positions().to_vec());
        self.figures.push(ruler.measure(body));
    }

    /// How far it is from the true one, but for [`Errors::settled_m`].
    pub fn errors(&self, truth: &Self, ruler: &Ruler) -> Errors {
        let count = truth.frames.len() as f64;
        let squares = self.frames.iter().zip(&truth.frames).map(|(a, b)| mean_square_distance(a, b));
        let gap = |of: fn(&Figures) -> f64| {
            let squares = self.figures.iter().zip(&truth.figures).map(|(a, b)| (of(a) - of(b)).powi(2));
            (squares.sum::<f64>() / count).sqrt()
        };
        let stretch = truth.figures.iter().map(|figures| figures.stretch).sum::<f64>() / count;
        Errors {
            motion_m: (squares.sum::<f64>() / count).sqrt(),
            settled_m: 0.0,
            stretch: gap(|figures| figures.stretch) / stretch,
            energy: gap(|figures| figures.energy) / ruler.scale(),
        }
    }
}

impl Measure {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Motion, Self::Settled, Self::Stretch, Self::Energy];

    /// The size of this error.
    pub fn of(self, errors: &Errors) -> f64 {
        match self {
            Self::Motion => errors.motion_m,
            Self::Settled => errors.settled_m,
            Self::Stretch => errors.stretch,
            Self::Energy => errors.energy,
        }
    }

    /// In a word.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Motion => "motion",
            Self::Settled => "settled",
            Self::Stretch => "stretch",
            Self::Energy => "energy",
        }
    }

    /// What it is, and in which unit: of [`Measure::scale`].
    pub const fn title(self) -> &'static str {
        match self {
            Self::Motion => "RMS distance from the converged motion over 0.5 s, mm",
            Self::Settled => "RMS distance from the shape at rest, mm",
            Self::Stretch => "RMS stretch over 0.5 s, off the converged by, %",
            Self::Energy => "energy over 0.5 s, off the converged by, % of weight × side",
        }
    }

    /// That many units are 1.
    pub const fn scale(self) -> f64 {
        match self {
            Self::Motion | Self::Settled => 1e3,
            Self::Stretch | Self::Energy => 1e2,
        }
    }
}

/// Mean square distance of two states, m².
pub fn mean_square_distance(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.distance_squared(*b)).sum::<f64>() / a.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trade::scene::{Scene, Stage};

    #[test]
    fn errors_are_what_they_say() {
        let ruler = Ruler::new(&Stage::new(Scene::Sheet, 3));
        let trace = |offset: f64, stretch, energy| Trace {
            frames: vec![vec![DVec3::ZERO, DVec3::X], vec![DVec3::Y * offset, DVec3::X]],
            figures: vec![Figures { stretch, energy }, Figures { stretch, energy: 0.0 }],
        };
        // The weight of 0.15 kg.
        let errors = trace(0.2, 0.9, 0.15 * 9.81).errors(&trace(0.0, 1.0, 0.0), &ruler);
        assert!((errors.motion_m - 0.1).abs() < 1e-12 && (errors.stretch - 0.1).abs() < 1e-12, "{errors:?}");
        assert!((errors.energy - 0.5_f64.sqrt()).abs() < 1e-7, "{errors:?}");
        assert_eq!(
            Measure::ALL.map(|measure| measure.of(&errors)),
            [errors.motion_m, 0.0, errors.stretch, errors.energy]
        );
    }
}
