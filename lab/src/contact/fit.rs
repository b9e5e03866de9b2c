//! Constants read off a motion.

/// The acceleration, m/s², of places `way` (m) that are `dt` seconds apart: the slope, by least squares, of the speeds between
/// them. NaN if there are fewer than three.
pub fn acceleration(way: &[f64], dt: f64) -> f64 {
    let speeds: Vec<_> = way.windows(2).map(|pair| (pair[1] - pair[0]) / dt).collect();
    let count = speeds.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = speeds.iter().sum::<f64>() / count;
    let (mut covariance, mut variance) = (0.0, 0.0);
    for (i, speed) in speeds.iter().enumerate() {
        let off = i as f64 - middle;
        covariance += off * (speed - mean);
        variance += off * off;
    }
    covariance / (variance * dt)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_acceleration_is_found_in_noise() {
        let way = |noise: f64| -> Vec<f64> {
            let place = |i: u32| {
                let t = f64::from(i) / 60.0;
                0.3 - 0.2 * t + 0.5 * 2.5 * t * t + noise * (f64::from(i) * 2.4).sin()
            };
            (0..90).map(place).collect()
        };
        assert!((acceleration(&way(0.0), 1.0 / 60.0) - 2.5).abs() < 1e-9);
        assert!((acceleration(&way(1e-4), 1.0 / 60.0) - 2.5).abs() < 0.02);
        assert!(acceleration(&[0.0, 1.0], 1.0).is_nan());
    }
}
