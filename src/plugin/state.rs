//! A running cloth.

use bevy::asset::Handle;
use bevy::ecs::change_detection::Tick;
use bevy::math::{DAffine3, DMat3, DVec3};
use bevy::prelude::*;

use super::advice::Told;
use super::budget::{Rung, Share};
use super::contact::Met;
use super::error::{ClothError, Faults};
use super::follow::{Carried, Follower};
use super::geometry::extent;
use super::mesh_io::SourceMesh;
use super::motion::Limits;
use super::pace::Pace;
use super::parts::ClothPart;
use super::picture::Obstacle;
use super::quality::ClothQuality;
use super::shading::Shading;
use crate::physics::{Cloth, MeshError, Pose, RestShape, RestShapeOptions, StepReport, SurfaceMesh};

/// The simulation of an entity with [`ClothMesh`](super::ClothMesh): inserted once its mesh is there.
#[derive(Component)]
pub struct ClothState {
    pub(super) cloth: Cloth,
    pub(super) binding: Binding,
    /// Vertices of the mesh that the rules hold, and when the rules last changed.
    pub(super) pins: Vec<u32>,
    pub(super) pins_changed: Option<Tick>,

    /// Positions before the last step, m.
    pub(super) previous_positions: Vec<DVec3>,
    /// The entity's transform in the last step and the one before, from mesh to world.
    pub(super) anchor: DAffine3,
    pub(super) previous_anchor: DAffine3,
    /// Its transform in the last tick, in which there may have been no step.
    pub(super) seen_anchor: DAffine3,
    /// See [`ClothInertia`](super::ClothInertia).
    pub(super) limits: Limits,
    /// What it felt of that motion, and what is held where.
    pub(super) follower: Follower,
    /// Put where its entity was drawn, which is not where a tick sees it.
    pub(super) placed: bool,
    /// What it may have touched in the last step.
    pub(super) met: Vec<Met>,
    pub(super) pace: Pace,
    /// Number of the next tick, as its turns are counted; `None` before the first.
    pub(super) ticks: Option<u32>,
    /// The colliders of the last step by [`ClothId`](super::ClothId), in order.
    pub(super) near: Vec<(u64, Entity)>,
    /// Where colliders were in the last step, by id, if the cloth was put back into that.
    pub(super) resumed: Vec<(u64, Pose)>,
    /// The level it is solved at; `None` with settings given one by one.
    pub(super) quality: Option<ClothQuality>,
    pub(super) share: Share,
    /// Stepped since it was placed: only then is there anything to interpolate.
    pub(super) stepped: bool,
    /// Disabled, or without a usable transform: not stepped, and carried along when it resumes.
    pub(super) suspended: bool,
    /// Counts changes of the positions.
    pub(super) revision: u64,

    pub(super) shown: Shown,
    pub(super) report: Option<StepReport>,
    /// Length of the last step, s.
    pub(super) step_length: f64,
    pub(super) faults: Faults,
    pub(super) told: Told,
}

/// How the cloth hangs together with its mesh.
pub(super) struct Binding {
    /// Whose vertices, one after another, are those of `mesh`; never empty.
    pub parts: Vec<ClothPart>,
    pub options: RestShapeOptions,
    pub mesh: SourceMesh,
    pub shading: Shading,
    /// A vertex of the mesh for each simulated one.
    pub representatives: Vec<u32>,
    /// Linear part of the transform that the rest shape was measured with.
    pub rest_linear: DMat3,
    /// Box around the rest positions, in the space of the mesh.
    pub bounds: [DVec3; 2],
}

/// What the own mesh shows, in its space.
pub(super) struct Shown {
    pub positions: Vec<Vec3>,
    pub normals: Vec<[f32; 3]>,
    /// What it was computed from: nothing is written while this stays the same.
    pub from: Option<ShownFrom>,
}

#[derive(PartialEq)]
pub(super) struct ShownFrom {
    pub revision: u64,
    pub alpha: f32,
    /// World to mesh.
    pub frame: DAffine3,
    /// What the picture is led around, and with it the transform that the entity is drawn at.
    pub obstacles: Vec<Obstacle>,
    pub drawn: DAffine3,
}

impl ClothState {
    /// The physics: positions, velocities, energy, stretch, in world space.
    pub fn cloth(&self) -> &Cloth {
        &self.cloth
    }

    /// The mesh asset that the cloth was made of, as [`Mesh3d`] was set; of several [`parts`](Self::parts), that of the first.
    pub fn source_mesh(&self) -> &Handle<Mesh> {
        self.binding.parts[0].source_mesh()
    }

    /// The copy that this cloth deforms: what [`Mesh3d`] is now; of several [`parts`](Self::parts), that of the first.
    pub fn own_mesh(&self) -> &Handle<Mesh> {
        self.binding.parts[0].own_mesh()
    }

    /// The simulated vertex that moves a vertex of the mesh; `None` for a vertex without triangle.
    pub fn simulated_vertex(&self, mesh_vertex: u32) -> Option<u32> {
        *self.cloth.shape().simulated.get(mesh_vertex as usize)?
    }

    /// Vertices of the mesh held by [`ClothPins`](super::ClothPins), in order.
    pub fn pinned_vertices(&self) -> &[u32] {
        &self.pins
    }

    /// How the last step went.
    pub fn last_report(&self) -> Option<&StepReport> {
        self.report.as_ref()
    }

    /// Length of the last step, s: what touched it gave a force times this as impulse.
    pub fn step_length(&self) -> f64 {
        self.step_length
    }

    /// The level that the cloth is solved at: the one asked for, or a lower one if a [`ClothBudget`](super::ClothBudget) says
    /// so. `None` with a [`ClothSolver`](super::ClothSolver).
    pub fn quality(&self) -> Option<ClothQuality> {
        self.quality
    }

    /// Runs of the schedule of [`ClothPlugin`](super::ClothPlugin) from step to step: 1, unless the
    /// [`quality`](Self::quality) or a [`ClothBudget`](super::ClothBudget) makes it 2, 4 or 8.
    pub fn update_interval(&self) -> u32 {
        let of_quality = || self.quality.map_or(1, ClothQuality::interval);
        self.share.rung.map_or_else(of_quality, Rung::interval)
    }

    /// The entity of a collider of the last step, by its [`ClothId`](super::ClothId).
    pub(super) fn collider(&self, id: u64) -> Option<Entity> {
        let index = self.near.binary_search_by_key(&id, |&(id, _)| id).ok()?;
        Some(self.near[index].1)
    }

    /// The report of the step in the last tick, if there was one in it.
    pub(super) fn report_of_this_tick(&self) -> Option<StepReport> {
        self.report.filter(|_| self.stepped && !self.suspended && self.pace.since == 0)
    }

    /// Moves the cloth as it is, velocities included, and carries the anchor along.
    pub(super) fn carry_to(&mut self, anchor: DAffine3) {
        if anchor == self.anchor && anchor == self.seen_anchor {
            return;
        }
        self.cloth.carry(anchor * self.anchor.inverse());
        self.anchor = anchor;
        self.settle();
    }

    /// Puts the cloth at rest under the transform `anchor`.
    pub(super) fn rest_at(&mut self, anchor: DAffine3) {
        self.anchor = anchor;
        let positions = self.binding.rest_positions(anchor);
        self.cloth.set_state(&positions, &vec![DVec3::ZERO; positions.len()]);
        self.follower.rest();
        self.placed = true;
        self.settle();
    }

    /// After a jump: there is nothing to interpolate from.
    pub(super) fn settle(&mut self) {
        self.previous_anchor = self.anchor;
        self.seen_anchor = self.anchor;
        self.follower.carried = Carried::default();
        self.met.clear();
        self.pace.pending = 0.0;
        self.previous_positions.clear();
        self.previous_positions.extend_from_slice(self.cloth.positions());
        self.stepped = false;
        self.revision += 1;
    }

    /// Whether any vertex is held, so that the cloth belongs to its entity rather than to the world.
    pub(super) fn is_anchored(&self) -> bool {
        !self.pins.is_empty() || self.cloth.pinned().next().is_some()
    }
}

impl Binding {
    /// Rest positions of the simulated vertices under a transform, m.
    pub fn rest_positions(&self, transform: DAffine3) -> Vec<DVec3> {
        self.representatives.iter().map(|&vertex| transform.transform_point3(self.local(vertex))).collect()
    }

    /// Corners of the box around these vertices of the mesh, in its space; around all if there are none.
    pub fn corners(&self, vertices: &[u32]) -> [DVec3; 8] {
        let around = || extent(vertices.iter().map(|&vertex| self.local(vertex)));
        let [low, high] = if vertices.is_empty() { self.bounds } else { around() };
        core::array::from_fn(|i| {
            DVec3::new([low.x, high.x][i & 1], [low.y, high.y][i >> 1 & 1], [low.z, high.z][i >> 2])
        })
    }

    /// Rest position of a vertex in the space of the mesh.
    pub fn local(&self, vertex: u32) -> DVec3 {
        self.mesh.positions[vertex as usize].as_dvec3()
    }
}

/// The rest shape of a mesh scaled by the linear part of a transform.
pub(super) fn rest_shape(mesh: &SourceMesh, linear: DMat3, options: &RestShapeOptions) -> Result<RestShape, MeshError> {
    let positions: Vec<DVec3> = mesh.positions.iter().map(|p| linear * p.as_dvec3()).collect();
    let uvs = mesh.uvs.as_deref();
    RestShape::new(&SurfaceMesh { positions: &positions, triangles: &mesh.triangles, uvs }, options)
}

/// A vertex of the mesh for each simulated one.
pub(super) fn representatives(shape: &RestShape) -> Vec<u32> {
    let mut representatives = vec![0; shape.vertex_count()];
    for (vertex, simulated) in shape.simulated.iter().enumerate().rev() {
        if let Some(simulated) = simulated {
            representatives[*simulated as usize] = vertex as u32;
        }
    }
    representatives
}

/// The affine map of a transform in f64, if it is one that cloth can live under.
pub(super) fn usable(transform: &GlobalTransform) -> Result<DAffine3, ClothError> {
    let affine = transform.affine().as_daffine3();
    let axes = [affine.matrix3.x_axis, affine.matrix3.y_axis, affine.matrix3.z_axis].map(DVec3::length);
    let (shortest, longest) = axes.iter().fold((f64::MAX, 0.0_f64), |(s, l), &a| (s.min(a), l.max(a)));
    let volume = axes.iter().product::<f64>();
    let flat = shortest <= 1e-6 * longest || affine.matrix3.determinant().abs() <= 1e-6 * volume;
    if affine.is_finite() && !flat { Ok(affine) } else { Err(ClothError::Transform) }
}

/// Whether two linear maps measure lengths alike, up to a relative 1e-4: they differ by a rotation only.
pub(super) fn same_scale(a: DMat3, b: DMat3) -> bool {
    let [g, h] = [a.transpose() * a, b.transpose() * b];
    let largest = |m: DMat3| m.to_cols_array().into_iter().fold(0.0_f64, |max, x| max.max(x.abs()));
    // Squares differ by twice as much.
    largest(g - h) <= 2e-4 * largest(g) && a.determinant() * b.determinant() > 0.0
}
