//! Held vertices.

use bevy::math::{DAffine3, DVec3};

/// Which vertices are held, and where each will be.
#[derive(Clone, Debug)]
pub(in crate::physics) struct Pins {
    held: Vec<bool>,
    /// By vertex: which of `pins` holds it, if it is held.
    pin_of: Vec<u32>,
    pins: Vec<Pin>,
}

#[derive(Clone, Copy, Debug)]
struct Pin {
    vertex: u32,
    /// Where the vertex is at the end of the whole step, m.
    target: DVec3,
    /// Where it is at the end of the present substep, m.
    waypoint: DVec3,
}

impl Pins {
    pub fn new(vertex_count: usize) -> Self {
        Self { held: vec![false; vertex_count], pin_of: vec![0; vertex_count], pins: Vec::new() }
    }

    pub fn set(&mut self, vertex: u32, target: DVec3) {
        let pin = Pin { vertex, target, waypoint: target };
        let index = vertex as usize;
        if core::mem::replace(&mut self.held[index], true) {
            self.pins[self.pin_of[index] as usize] = pin;
        } else {
            self.pin_of[index] = self.pins.len() as u32;
            self.pins.push(pin);
        }
    }

    pub fn unset(&mut self, vertex: u32) {
        let index = vertex as usize;
        if core::mem::replace(&mut self.held[index], false) {
            let place = self.pin_of[index];
            self.pins.swap_remove(place as usize);
            if let Some(moved) = self.pins.get(place as usize) {
                self.pin_of[moved.vertex as usize] = place;
            }
        }
    }

    pub fn clear(&mut self) {
        self.held.fill(false);
        self.pins.clear();
    }

    pub fn target(&self, vertex: u32) -> Option<DVec3> {
        self.pin(vertex as usize).map(|pin| pin.target)
    }

    pub fn transform(&mut self, map: DAffine3) {
        for pin in &mut self.pins {
            pin.target = map.transform_point3(pin.target);
        }
    }

    /// Mean of what the held vertices have, or all if none is held.
    pub fn mean(&self, values: &[DVec3]) -> DVec3 {
        if self.pins.is_empty() {
            return values.iter().sum::<DVec3>() / values.len() as f64;
        }
        self.pins.iter().map(|pin| values[pin.vertex as usize]).sum::<DVec3>() / self.pins.len() as f64
    }

    /// Mean of the velocities that the pins have in a substep of `dt` seconds from `positions`, m/s; `None` if no vertex is held.
    pub fn mean_velocity(&self, positions: &[DVec3], dt: f64) -> Option<DVec3> {
        let ways = self.pins.iter().map(|pin| pin.waypoint - positions[pin.vertex as usize]);
        self.any().then(|| ways.sum::<DVec3>() / (dt * self.pins.len() as f64))
    }

    /// Sets the waypoints a straight line onwards, with so many substeps `remaining`. The last ends on the target itself.
    pub fn advance(&mut self, positions: &[DVec3], remaining: u32) {
        for Pin { vertex, target, waypoint } in &mut self.pins {
            let x = positions[*vertex as usize];
            *waypoint = if remaining == 1 { *target } else { x + (*target - x) / f64::from(remaining) };
        }
    }

    /// True for held vertices.
    pub fn held(&self) -> &[bool] {
        &self.held
    }

    /// Where a vertex is at the end of the substep, if it is held, m.
    pub fn waypoint(&self, vertex: usize) -> Option<DVec3> {
        self.pin(vertex).map(|pin| pin.waypoint)
    }

    /// All held vertices, and where each is at the end of the substep, m.
    pub fn waypoints(&self) -> impl Iterator<Item = (usize, DVec3)> {
        self.pins.iter().map(|pin| (pin.vertex as usize, pin.waypoint))
    }

    pub fn any(&self) -> bool {
        !self.pins.is_empty()
    }

    fn pin(&self, vertex: usize) -> Option<&Pin> {
        self.held.get(vertex).is_some_and(|&held| held).then(|| &self.pins[self.pin_of[vertex] as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_is_held_once_and_goes_in_even_steps() {
        let mut pins = Pins::new(4);
        pins.set(2, DVec3::X);
        pins.set(0, DVec3::Y);
        pins.set(2, DVec3::Z);
        assert_eq!(pins.held(), [true, false, true, false]);
        assert_eq!([0, 1, 2, 7].map(|v| pins.target(v)), [Some(DVec3::Y), None, Some(DVec3::Z), None]);
        pins.advance(&[DVec3::ZERO; 4], 2);
        assert_eq!(pins.waypoints().collect::<Vec<_>>(), [(2, DVec3::Z / 2.0), (0, DVec3::Y / 2.0)]);
        pins.advance(&[DVec3::ZERO; 4], 1);
        assert_eq!([pins.waypoint(2), pins.waypoint(1)], [Some(DVec3::Z), None]);
        // One let go leaves the others where they are; a second time it is nothing.
        pins.set(3, DVec3::ONE);
        pins.unset(2);
        pins.unset(2);
        assert_eq!(pins.held(), [true, false, false, true]);
        assert_eq!([0, 2, 3].map(|v| pins.target(v)), [Some(DVec3::Y), None, Some(DVec3::ONE)]);
        pins.clear();
        assert!(!pins.any() && pins.held() == [false; 4]);
    }
}
