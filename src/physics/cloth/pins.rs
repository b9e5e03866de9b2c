//! Held vertices.

use bevy::math::{DAffine3, DVec3};

/// Which vertices are held, and where each will be.
#[derive(Clone, Debug)]
pub(super) struct Pins {
    held: Vec<bool>,
    /// Where a held vertex is at the end of the whole step, m.
    targets: Vec<DVec3>,
    /// Where it is at the end of the present substep, m.
    waypoints: Vec<DVec3>,
}

impl Pins {
    pub fn new(vertex_count: usize) -> Self {
        let nowhere = vec![DVec3::ZERO; vertex_count];
        Self { held: vec![false; vertex_count], targets: nowhere.clone(), waypoints: nowhere }
    }

    pub fn set(&mut self, vertex: u32, target: DVec3) {
        self.held[vertex as usize] = true;
        self.targets[vertex as usize] = target;
    }

    pub fn clear(&mut self) {
        self.held.fill(false);
    }

    pub fn target(&self, vertex: u32) -> Option<DVec3> {
        let vertex = vertex as usize;
        self.held.get(vertex).is_some_and(|&held| held).then(|| self.targets[vertex])
    }

    pub fn transform(&mut self, map: DAffine3) {
        for target in &mut self.targets {
            *target = map.transform_point3(*target);
        }
    }

    /// Sets the waypoints a straight line onwards, with so many substeps `remaining`. The last ends on the target itself.
    pub fn advance(&mut self, positions: &[DVec3], remaining: u32) {
        for ((waypoint, &target), &x) in self.waypoints.iter_mut().zip(&self.targets).zip(positions) {
            *waypoint = if remaining == 1 { target } else { x + (target - x) / f64::from(remaining) };
        }
    }

    /// True for held vertices.
    pub fn held(&self) -> &[bool] {
        &self.held
    }

    /// Where held vertices are at the end of the substep, m; meaningless for others.
    pub fn waypoints(&self) -> &[DVec3] {
        &self.waypoints
    }

    pub fn any(&self) -> bool {
        self.held.contains(&true)
    }
}
