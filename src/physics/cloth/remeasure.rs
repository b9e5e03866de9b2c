//! The same cloth, larger, smaller or mirrored.

use bevy::math::{DAffine3, DMat3, DVec3};

use super::Cloth;
use crate::physics::mesh::{MeshError, RestShapeOptions, SurfaceMesh};
use crate::physics::step::State;

/// Share of a length by which a map may distort before the turns of mid-edge normals are found anew: the sweeps of the next
/// steps follow less than that.
const DISTORTED: f64 = 0.1;

impl Cloth {
    /// Measures the undeformed cloth again, with the vertices of its mesh elsewhere: stretched, squashed or mirrored. Masses and
    /// elements follow. `map` carries the state along: positions, pin targets, what the integrator remembers, and velocities
    /// relative to those of the held vertices, or to their mean where none is: the cape of a running figure that grows runs no
    /// faster.
    ///
    /// Takes a pass over vertices, triangles and edges, where a cloth built anew finds their order, the pattern of the matrix
    /// and the levels of the solver, too.
    ///
    /// # Errors
    /// See [`RestShape::remeasure`](crate::physics::RestShape::remeasure). The cloth then stays as it was.
    pub fn remeasure(
        &mut self,
        mesh: &SurfaceMesh,
        options: &RestShapeOptions,
        map: DAffine3,
    ) -> Result<(), MeshError> {
        self.shape.remeasure(mesh, options)?;
        for (mass, area) in self.masses.iter_mut().zip(&self.shape.vertex_areas) {
            *mass = area * f64::from(self.fabric.density);
        }
        for (mass, &vertex) in self.inner_masses.iter_mut().zip(&self.ordering.outer) {
            *mass = self.masses[vertex as usize];
        }
        self.mass = self.masses.iter().sum();
        self.engine.map(map, &self.state, &self.pins);
        let drift = self.pins.mean(&self.state.velocities);
        self.state.map(map, drift);
        self.pins.transform(map);
        self.engine.measure(&self.shape, &self.fabric, &self.ordering);
        if distorts(map.matrix3) {
            self.engine.settle(&self.state.positions);
        }
        self.show();
        Ok(())
    }
}

impl State {
    /// Maps positions, and velocities relative to `drift`, m/s.
    pub fn map(&mut self, map: DAffine3, drift: DVec3) {
        for x in &mut self.positions {
            *x = map.transform_point3(*x);
        }
        for v in &mut self.velocities {
            *v = drift + map.transform_vector3(*v - drift);
        }
    }

    /// The same for a state from which the cloth has drifted since, m and m/s.
    pub fn map_earlier(&mut self, map: DAffine3, drifted: DVec3, drift: DVec3) {
        let back = map.transform_vector3(drifted) - drifted;
        self.map(DAffine3 { translation: map.translation + back, ..map }, drift);
    }
}

/// Whether lengths in different directions change by different factors.
fn distorts(linear: DMat3) -> bool {
    let squares = linear.transpose() * linear;
    let mean = squares.diagonal().element_sum() / 3.0;
    let off = squares - DMat3::from_diagonal(DVec3::splat(mean));
    // Squares differ by twice as much.
    !off.to_cols_array().into_iter().all(|entry| entry.abs() <= 2.0 * DISTORTED * mean)
}
