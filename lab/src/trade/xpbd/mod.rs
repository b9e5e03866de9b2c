//! The baseline: extended position-based dynamics in small steps.
//!
//! Compliant constraints of Macklin, Müller & Chentanez 2016, "XPBD: Position-Based Simulation of Compliant Constrained
//! Dynamics": a constraint C of compliance α takes the multiplier of eq. 18, or with damping that of eq. 26,
//!
//! ```text
//! Δλ = −(C + α̃ λ + γ ∇C·(x − xₙ)) / ((1 + γ) ∇C M⁻¹ ∇Cᵀ + α̃),   Δx = M⁻¹ ∇Cᵀ Δλ,   α̃ = α/Δt²,   γ = α̃ Δt² β/Δt.
//! ```
//!
//! Many substeps of one iteration each, so that λ starts at zero and is never stored: Macklin et al. 2019, "Small Steps in
//! Physics Simulation". Constraints are solved one after the other (Gauss–Seidel); those of one colour share no vertex, so eight
//! of them go side by side.
//!
//! The energies are those of the implicit step: `triangles` have the Green strain as a vector of three constraints, whose
//! compliance is the inverse of the material's matrix; `hinges` have the dihedral angle. So the limit of many substeps is the
//! same motion. Damping is stiffness-proportional there, β = dp α⁻¹, which gives γ = dp/Δt for every constraint.

mod batch;
mod colouring;
mod hinges;
mod order;
mod pass;
mod settings;
mod triangles;
mod twin;

use bevy::math::DVec3;
use bevy_cloth::physics::math::{Oct, Padded, RowKernel, Scalar};
use bevy_cloth::physics::{Fabric, RestShape};

use self::hinges::Hinges;
use self::order::Order;
use self::pass::Pass;
pub use self::settings::{Damping, Settings};
use self::triangles::Triangles;

/// A vertex: its position at the beginning of the substep, m, and how far it has moved in it, m.
///
/// Apart, because in f32 a move of a substep is too small beside a position to be the difference of two.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
struct Point<T: Scalar> {
    at: Padded<T>,
    moved: Padded<T>,
}

/// A held vertex.
#[derive(Clone, Copy, Debug)]
struct Held {
    vertex: u32,
    /// At the beginning of the frame, m.
    from: DVec3,
    /// At its end, m.
    to: DVec3,
}

/// A cloth.
pub struct Xpbd<T: Scalar> {
    settings: Settings,
    /// Length of a frame, s.
    frame: f64,
    gravity: DVec3,
    /// dp, s, and α, 1/s.
    damping: f64,
    air_drag: f64,
    order: Order,
    /// In that order, and one more that belongs to nobody: for what batches are filled up with.
    points: Vec<Point<T>>,
    triangles: Triangles<T>,
    hinges: Hinges<T>,
    held: Vec<Held>,
    positions: Vec<DVec3>,
    velocities: Vec<DVec3>,
}

impl<T: Scalar> Xpbd<T> {
    /// A cloth at its rest positions, at rest, under standard gravity, stepped in frames of this length (s). The vertices in
    /// question are held, where they are.
    ///
    /// # Panics
    /// If the membrane of the fabric is not stiff in every direction: it has no compliance then. If bending is to be solved in
    /// substeps that do not exist.
    pub fn new(shape: &RestShape, fabric: &Fabric, held: &[u32], frame: f64, settings: Settings) -> Self {
        assert!(settings.substeps.is_multiple_of(settings.bending_every), "bending would be left out in part");
        let count = shape.vertex_count();
        let order = Order::new(shape);
        let mut inverse_masses: Vec<f64> =
            order.outer.iter().map(|&v| 1.0 / (shape.vertex_areas[v as usize] * f64::from(fabric.density))).collect();
        let held: Vec<_> = held
            .iter()
            .map(|&v| {
                let (vertex, x) = (order.inner[v as usize], shape.positions[v as usize]);
                inverse_masses[vertex as usize] = 0.0;
                Held { vertex, from: x, to: x }
            })
            .collect();
        inverse_masses.push(0.0);
        let zero = Point { at: Padded::zero(), moved: Padded::zero() };
        let mut cloth = Self {
            triangles: Triangles::new(shape, fabric, &order.inner, &inverse_masses),
            hinges: Hinges::new(shape, fabric, &order.inner, &inverse_masses),
            points: vec![zero; count + 1],
            order,
            held,
            settings,
            frame,
            gravity: DVec3::new(0.0, -9.81, 0.0),
            damping: fabric.damping.into(),
            air_drag: fabric.air_drag.into(),
            positions: vec![DVec3::ZERO; count],
            velocities: vec![DVec3::ZERO; count],
        };
        cloth.set_state(&shape.positions, &vec![DVec3::ZERO; count]);
        cloth
    }

    /// Changes gravity, m/s².
    pub fn set_gravity(&mut self, gravity: DVec3) {
        self.gravity = gravity;
    }

    /// Puts the cloth into a state. Held vertices are held where they are then.
    pub fn set_state(&mut self, positions: &[DVec3], velocities: &[DVec3]) {
        self.positions.copy_from_slice(positions);
        self.velocities.copy_from_slice(velocities);
        let dt = self.dt();
        for (point, &outer) in self.points.iter_mut().zip(&self.order.outer) {
            let (x, v) = (positions[outer as usize], velocities[outer as usize]);
            *point = Point { at: Padded::from_f64(x.to_array()), moved: Padded::from_f64((dt * v).to_array()) };
        }
        for held in &mut self.held {
            let x = positions[self.order.outer[held.vertex as usize] as usize];
            (held.from, held.to) = (x, x);
        }
    }

    /// Where a held vertex is to be at the end of the next frame, m: it goes there in a straight line.
    pub fn hold(&mut self, vertex: u32, target: DVec3) {
        let inner = self.order.inner[vertex as usize];
        for held in self.held.iter_mut().filter(|held| held.vertex == inner) {
            held.to = target;
        }
    }

    /// Positions, m.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Velocities, m/s.
    pub fn velocities(&self) -> &[DVec3] {
        &self.velocities
    }

    /// Advances by a frame.
    pub fn step(&mut self) {
        T::dispatch(Frame(self));
        let rate = 1.0 / self.dt();
        for (point, &outer) in self.points.iter().zip(&self.order.outer) {
            self.positions[outer as usize] = DVec3::from(point.at.to_f64());
            self.velocities[outer as usize] = rate * DVec3::from(point.moved.to_f64());
        }
        for held in &mut self.held {
            held.from = held.to;
        }
    }

    /// Length of a substep, s.
    fn dt(&self) -> f64 {
        self.frame / f64::from(self.settings.substeps)
    }
}

/// All substeps of a frame.
struct Frame<'a, T: Scalar>(&'a mut Xpbd<T>);

impl<T: Scalar> RowKernel<T> for Frame<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) {
        let cloth = self.0;
        let (dt, substeps) = (cloth.dt(), cloth.settings.substeps);
        let (positions, velocities) = Pass::of(&cloth.settings, dt, cloth.damping);
        let bending = positions.lasting(cloth.settings.bending_every);
        let kept = T::from_f64(1.0 / (1.0 + dt * cloth.air_drag));
        let fall = Padded::from_f64((dt * dt * cloth.gravity).to_array());
        let Xpbd { points, triangles, hinges, held, settings, .. } = cloth;
        for substep in 1..=substeps {
            for point in points.iter_mut() {
                point.moved = (point.moved + fall) * kept;
            }
            let share = f64::from(substep) / f64::from(substeps);
            for held in held.iter() {
                let point = &mut points[held.vertex as usize];
                let waypoint = held.from.lerp(held.to, share);
                point.moved = Padded::from_f64((waypoint - DVec3::from(point.at.to_f64())).to_array());
            }
            let bends = substep.is_multiple_of(settings.bending_every);
            if bends {
                hinges.solve(s, &bending, points);
            }
            triangles.solve(s, &positions, points);
            for point in points.iter_mut() {
                point.at += point.moved;
            }
            if let Some(velocities) = &velocities {
                if bends {
                    hinges.solve(s, &velocities.lasting(settings.bending_every), points);
                }
                triangles.solve(s, velocities, points);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy_cloth::physics::{BendingModel, Cloth, Precision, SolverKind, SolverSettings};

    use super::*;
    use crate::scenes::{DT, Meshing, Sheet};

    /// Root mean square distance, m, from our converged steps after a third of a second, of a sheet whose bending and damping
    /// matter, by so many substeps.
    fn distance(settings: Settings) -> f64 {
        let sheet = Sheet::new(7, Meshing::Irregular);
        let shape = sheet.shape(BendingModel::Hinge);
        let fabric = Fabric { damping: 0.02, ..Fabric::isotropic(0.15, 200.0, 0.3, 1e-3) };
        let held: Vec<_> = sheet.corners.iter().filter_map(|&v| shape.simulated[v as usize]).collect();
        let mut xpbd = Xpbd::<f64>::new(&shape, &fabric, &held, DT, settings);
        let reference = SolverSettings {
            kind: SolverKind::conjugate_gradient(1e-4),
            precision: Precision::Double,
            substeps: 32,
            ..Default::default()
        };
        let mut cloth = Cloth::new(shape.clone(), fabric, reference).unwrap();
        for &vertex in &held {
            cloth.pin(vertex, shape.positions[vertex as usize]);
        }
        for frame in 1..=20 {
            // One corner goes up.
            let target = shape.positions[held[0] as usize] + f64::from(frame) * DT * DVec3::new(0.0, 0.5, 0.0);
            xpbd.hold(held[0], target);
            cloth.pin(held[0], target);
            xpbd.step();
            cloth.step(DT);
        }
        let squares = xpbd.positions().iter().zip(cloth.positions()).map(|(a, b)| a.distance_squared(*b));
        (squares.sum::<f64>() / shape.vertex_count() as f64).sqrt()
    }

    #[test]
    fn many_substeps_lead_where_our_steps_lead() {
        let damped = |n| Settings { damping: Damping::Velocities, ..Settings::published(n) };
        let as_published = |n| Settings { damping: Damping::Constraints, ..Settings::published(n) };
        let tuned = |n| Settings { damping: Damping::Velocities, ..Settings::tuned(n) };
        for settings in [&damped as &dyn Fn(u32) -> Settings, &as_published, &tuned] {
            let [coarse, fine] = [200, 800].map(|n| distance(settings(n)));
            assert!(fine < 0.5 * coarse && fine < 5e-3, "{coarse} {fine} {:?}", settings(1));
        }
        // Without the damping they lead elsewhere.
        let undamped = distance(Settings::published(800));
        assert!(undamped > 2.0 * distance(damped(800)), "{undamped}");
    }

    /// λ(λ²−1)/2 = ρ g s/k at the distance s from the free end: the tip of 1 m drops 22.06 mm for ρ = 0.324 kg/m², k = 69 N/m.
    #[test]
    fn a_hung_sheet_stretches_as_it_should() {
        let shape = Sheet::new(16, Meshing::Grid).shape(BendingModel::Hinge);
        let fabric = Fabric { damping: 0.0, air_drag: 20.0, ..Fabric::isotropic(0.324, 69.0, 0.0, 1e-6) };
        let held: Vec<_> = (0..256).filter(|&v| shape.positions[v as usize].z == 0.0).collect();
        let mut xpbd = Xpbd::<f32>::new(&shape, &fabric, &held, DT, Settings::published(60));
        let hanging: Vec<_> = shape.positions.iter().map(|x| DVec3::new(x.x, -x.z, 0.0)).collect();
        xpbd.set_state(&hanging, &[DVec3::ZERO; 256]);
        for _ in 0..180 {
            xpbd.step();
        }
        let tip = (0..256).filter(|&v| shape.positions[v].z == 1.0).map(|v| xpbd.positions()[v].y).sum::<f64>() / 16.0;
        let drop = -1e3 * (tip + 1.0);
        assert!((drop / 22.06 - 1.0).abs() < 0.01, "{drop}");
    }

    #[test]
    fn nothing_moves_a_free_cloth_as_a_whole() {
        let shape = Sheet::new(9, Meshing::Shuffled).shape(BendingModel::Hinge);
        let fabric = Fabric { air_drag: 0.0, ..Fabric::cotton() };
        let settings = Settings { damping: Damping::Velocities, ..Settings::tuned(20) };
        let mut xpbd = Xpbd::<f64>::new(&shape, &fabric, &[], DT, settings);
        xpbd.set_gravity(DVec3::ZERO);
        // Stretched, bent and in motion.
        let bent: Vec<_> =
            shape.positions.iter().map(|x| DVec3::new(1.1 * x.x, 0.2 * (3.0 * x.z).sin(), x.z)).collect();
        let moving: Vec<_> = shape.positions.iter().map(|x| DVec3::new(x.z, 1.0, -2.0 * x.x * x.z)).collect();
        xpbd.set_state(&bent, &moving);
        let momentum = |cloth: &Xpbd<f64>| {
            let parts = shape.vertex_areas.iter().zip(cloth.velocities());
            parts.map(|(area, v)| f64::from(fabric.density) * area * *v).sum::<DVec3>()
        };
        let before = momentum(&xpbd);
        for _ in 0..10 {
            xpbd.step();
        }
        assert!(xpbd.positions().iter().zip(&bent).any(|(a, b)| a.distance(*b) > 0.1));
        assert!(momentum(&xpbd).distance(before) < 1e-12 * before.length(), "{before} {}", momentum(&xpbd));
    }
}
