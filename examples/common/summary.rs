//! What a run amounted to: one line for the reader, one JSON object for scripts.

use crate::penetration::deepest;
use bevy::prelude::*;
use bevy_cloth::{
    plugin::ClothSystems,
    prelude::{ClothMaterial, ClothState},
};
use serde::Serialize;
use std::{
    fmt,
    path::{Path, PathBuf},
    time::Duration,
};

/// Adds up what every step costs.
pub struct StepFiguresPlugin;

impl Plugin for StepFiguresPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<StepFigures>().add_systems(FixedUpdate, add_up.after(ClothSystems::Step));
    }
}

/// Costs so far, summed over cloths and steps.
#[derive(Resource, Default)]
pub struct StepFigures {
    steps: u32,
    total: Duration,
    assembly: Duration,
    solve: Duration,
    iterations: u64,
}

fn add_up(mut figures: ResMut<StepFigures>, cloths: Query<&ClothState>) {
    if cloths.is_empty() {
        return;
    }
    figures.steps += 1;
    for report in cloths.iter().filter_map(|cloth| cloth.last_report()) {
        figures.total += report.total;
        figures.assembly += report.assembly;
        figures.solve += report.solve;
        figures.iterations += u64::from(report.iterations);
    }
}

/// Figures of a whole run.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Summary {
    /// What is simulated.
    pub scene: String,
    /// Name of the fabric.
    pub fabric: String,
    /// Graphics adapter that drew the pictures.
    pub adapter: Option<String>,
    /// Number of cloths.
    pub cloths: usize,
    /// Vertices of the meshes.
    pub render_vertices: usize,
    /// Vertices simulated: seams welded.
    pub vertices: usize,
    pub triangles: usize,
    /// Vertices held.
    pub pinned: usize,
    pub steps: u32,
    /// Simulated time in seconds.
    pub seconds: f64,
    /// Mean cost of a step of all cloths, in milliseconds of one thread.
    pub ms_per_step: f64,
    pub assembly_ms_per_step: f64,
    pub solve_ms_per_step: f64,
    /// Mean solver iterations per cloth and step.
    pub iterations_per_step: f64,
    /// Largest elongation relative to rest.
    pub max_stretch: f64,
    /// Root mean square elongation relative to rest, the worst cloth.
    pub rms_stretch: f64,
    /// Depth of the deepest vertex inside a collider, in metres.
    pub penetration: f32,
    /// In joules.
    pub kinetic_energy: f64,
    pub membrane_energy: f64,
    pub bending_energy: f64,
    /// In joules, zero at the world's origin.
    pub gravity_energy: f64,
    pub total_energy: f64,
    /// Least and greatest corner of the cloths, in metres.
    pub bounds: [[f64; 3]; 2],
    /// Pictures written.
    pub pictures: Vec<PathBuf>,
    /// The draped mesh.
    pub mesh: Option<PathBuf>,
}

impl Summary {
    /// Reads the figures off the world as it is now.
    pub fn of(world: &mut World, scene: &str) -> Self {
        let seconds_per_step = world.resource::<Time<Fixed>>().timestep().as_secs_f64();
        let penetration = deepest(world);
        let mut cloths = world.query::<(&ClothState, &ClothMaterial)>();
        let figures = world.resource::<StepFigures>();
        let per_step = |time: Duration| 1e3 * time.as_secs_f64() / f64::from(figures.steps.max(1));
        let mut summary = Self {
            scene: scene.into(),
            fabric: String::new(),
            adapter: None,
            cloths: 0,
            render_vertices: 0,
            vertices: 0,
            triangles: 0,
            pinned: 0,
            steps: figures.steps,
            seconds: seconds_per_step * f64::from(figures.steps),
            ms_per_step: per_step(figures.total),
            assembly_ms_per_step: per_step(figures.assembly),
            solve_ms_per_step: per_step(figures.solve),
            iterations_per_step: 0.0,
            max_stretch: f64::NEG_INFINITY,
            rms_stretch: 0.0,
            penetration,
            kinetic_energy: 0.0,
            membrane_energy: 0.0,
            bending_energy: 0.0,
            gravity_energy: 0.0,
            total_energy: 0.0,
            bounds: [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]],
            pictures: Vec::new(),
            mesh: None,
        };
        for (state, material) in cloths.iter(world) {
            let cloth = state.cloth();
            let (energy, stretch) = (cloth.energy(), cloth.stretch());
            summary.fabric = fabric_name(material).into();
            summary.cloths += 1;
            summary.render_vertices += cloth.shape().simulated.len();
            summary.vertices += cloth.shape().vertex_count();
            summary.triangles += cloth.shape().triangles.len();
            summary.pinned += cloth.pinned().count();
            summary.max_stretch = summary.max_stretch.max(stretch.max);
            summary.rms_stretch = summary.rms_stretch.max(stretch.rms);
            summary.kinetic_energy += energy.kinetic;
            summary.membrane_energy += energy.membrane;
            summary.bending_energy += energy.bending;
            summary.gravity_energy += energy.gravity;
            summary.total_energy += energy.total();
            for position in cloth.positions() {
                for axis in 0..3 {
                    summary.bounds[0][axis] = summary.bounds[0][axis].min(position[axis]);
                    summary.bounds[1][axis] = summary.bounds[1][axis].max(position[axis]);
                }
            }
        }
        let solves = u64::from(figures.steps) * summary.cloths as u64;
        summary.iterations_per_step = figures.iterations as f64 / solves.max(1) as f64;
        summary
    }

    /// Writes one JSON object.
    pub fn write_json(&self, path: &Path) -> Result<(), String> {
        let json = serde_json::to_string_pretty(self).map_err(|error| error.to_string())?;
        std::fs::write(path, json + "\n").map_err(|error| format!("cannot write {}: {error}", path.display()))
    }
}

/// Name of the preset, or "custom".
pub fn fabric_name(material: &ClothMaterial) -> &'static str {
    bevy_cloth::physics::Fabric::presets().find(|(_, fabric)| *fabric == material.0).map_or("custom", |(name, _)| name)
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "{}, {}: {} vertices, {} steps ({:.1} s) at {:.2} ms per step, {:.0} iterations; stretch max {:.2} %, \
             RMS {:.3} %; energy kinetic {:.2e} J, membrane {:.2e} J, bending {:.2e} J, total {:.3} J",
            self.scene,
            self.fabric,
            self.vertices,
            self.steps,
            self.seconds,
            self.ms_per_step,
            self.iterations_per_step,
            100.0 * self.max_stretch,
            100.0 * self.rms_stretch,
            self.kinetic_energy,
            self.membrane_energy,
            self.bending_energy,
            self.total_energy,
        )
    }
}
