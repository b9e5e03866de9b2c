//! Pareto fronts of cost and error, and how much cheaper one is than another.

/// What something costs, ms, and how wrong it is, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// ms.
    pub cost: f64,
    /// m.
    pub error: f64,
}

/// Those that no other beats in both, by rising cost and falling error. What is not finite does not count.
pub fn front(points: impl IntoIterator<Item = Point>) -> Vec<Point> {
    let mut points: Vec<_> = points.into_iter().filter(|p| p.cost.is_finite() && p.error.is_finite()).collect();
    points.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.error.total_cmp(&b.error)));
    let mut front: Vec<Point> = Vec::new();
    for point in points {
        if front.last().is_none_or(|last| point.error < last.error) {
            front.push(point);
        }
    }
    front
}

/// The cost of an error, straight between the points of a front in logarithms: of a method that takes any number of substeps.
/// Where the error is larger than all of them, the first: `None` where it is smaller, and never reached.
pub fn cost_between(front: &[Point], error: f64) -> Option<f64> {
    let next = front.iter().position(|point| point.error <= error)?;
    let after = front[next];
    let Some(before) = next.checked_sub(1).map(|i| front[i]) else { return Some(after.cost) };
    let share = (error / before.error).ln() / (after.error / before.error).ln();
    Some(before.cost * (after.cost / before.cost).powf(share))
}

/// The cost of an error, of a method that only has these points.
pub fn cost_of(front: &[Point], error: f64) -> Option<f64> {
    front.iter().find(|point| point.error <= error).map(|point| point.cost)
}

/// How many times cheaper ours is than theirs at an error: infinite where theirs never reaches it, zero where ours does not
/// and theirs does, `None` where neither does.
pub fn gain(ours: &[Point], theirs: &[Point], error: f64) -> Option<f64> {
    match (cost_of(ours, error), cost_between(theirs, error)) {
        (Some(ours), Some(theirs)) => Some(theirs / ours),
        (Some(_), None) => Some(f64::INFINITY),
        (None, Some(_)) => Some(0.0),
        (None, None) => None,
    }
}

/// The least gain over all errors from `most` down to `least`, and where it is; `None` if neither reaches any of them.
pub fn least_gain(ours: &[Point], theirs: &[Point], most: f64, least: f64) -> Option<(f64, f64)> {
    // Between the errors of ours the gain only grows as the error falls: so what counts is the largest error that each point of
    // ours has to serve, which is just below that of the point before; and the smallest errors, which ours may not reach.
    let below = |point: &Point| point.error * (1.0 - 1e-9);
    let errors = ours.iter().map(below).chain(theirs.last().map(|last| last.error)).chain([most, least]);
    let judged = errors.filter(|error| (least..=most).contains(error));
    let gains = judged.filter_map(|error| gain(ours, theirs, error).map(|gain| (gain, error)));
    gains.min_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(values: &[(f64, f64)]) -> Vec<Point> {
        values.iter().map(|&(cost, error)| Point { cost, error }).collect()
    }

    #[test]
    fn a_front_leaves_out_what_is_beaten() {
        let all = [(4.0, 0.1), (1.0, 0.5), (2.0, 0.6), (8.0, 0.1), (2.0, 0.2), (1.5, f64::NAN), (9.0, 0.01)];
        assert_eq!(front(points(&all)), points(&[(1.0, 0.5), (2.0, 0.2), (4.0, 0.1), (9.0, 0.01)]));
    }

    #[test]
    fn costs_lie_between_points_in_logarithms() {
        let front = points(&[(1.0, 0.1), (100.0, 0.001)]);
        let cost = |error| cost_between(&front, error);
        assert!(cost(0.01).is_some_and(|cost| (cost - 10.0).abs() < 1e-9));
        assert_eq!((cost(0.5), cost(0.1), cost(0.0005)), (Some(1.0), Some(1.0), None));
        assert_eq!([0.5, 0.1, 0.01, 1e-4].map(|e| cost_of(&front, e)), [Some(1.0), Some(1.0), Some(100.0), None]);
    }

    #[test]
    fn the_least_gain_is_where_a_dearer_level_begins_to_be_needed() {
        // Theirs: cost 1/error. Ours: 10 times cheaper at their own errors, but only two of them.
        let theirs = points(&[(10.0, 0.1), (1000.0, 0.001)]);
        let ours = points(&[(2.0, 0.05), (20.0, 0.005)]);
        assert_eq!(gain(&ours, &theirs, 0.05).map(f64::round), Some(10.0));
        let (least, at) = least_gain(&ours, &theirs, 0.05, 0.005).unwrap();
        assert!((least - 1.0).abs() < 1e-6 && (at - 0.05).abs() < 1e-6, "{least} at {at}");
        // Theirs goes on where ours ends.
        assert_eq!(least_gain(&ours, &theirs, 0.05, 0.001).map(|(gain, _)| gain), Some(0.0));
        // Even where it goes on beyond what is judged.
        assert_eq!(least_gain(&ours, &theirs, 0.05, 0.002).map(|(gain, _)| gain), Some(0.0));
        // Theirs never gets there.
        let bad = points(&[(1.0, 0.2)]);
        assert_eq!(least_gain(&ours, &bad, 0.05, 0.001).map(|(gain, _)| gain), Some(f64::INFINITY));
        assert_eq!(least_gain(&bad, &bad, 0.05, 0.001), None);
        assert_eq!(least_gain(&[], &theirs, 0.05, 0.001).map(|(gain, _)| gain), Some(0.0));
    }
}
