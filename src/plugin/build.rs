//! A cloth from the meshes that it is to be made of.

use bevy::asset::LoadState;
use bevy::math::{DAffine3, DVec3};
use bevy::prelude::*;

use super::advice::Told;
use super::budget::Share;
use super::error::{ClothError, Faults};
use super::follow::Follower;
use super::geometry::extent;
use super::inertia::ClothInertia;
use super::initialise::CandidateItem;
use super::mesh_io::{SourceMesh, own_copy};
use super::pace::Pace;
use super::parts::{ClothPart, Wanted};
use super::quality::ClothQuality;
use super::shading::Shading;
use super::state::{Binding, ClothState, Shown, ShownFrom, representatives, rest_shape, usable};
use crate::physics::Cloth;

/// Why there is no cloth (yet).
pub(super) enum NotBuilt {
    Loading,
    /// There is no asset, and nothing loads one. Somebody may have reserved its handle, and add it later.
    Missing,
    Refused(ClothError),
}

impl<E: Into<ClothError>> From<E> for NotBuilt {
    fn from(error: E) -> Self {
        Self::Refused(error.into())
    }
}

impl CandidateItem<'_, '_> {
    /// The cloth at rest. Its meshes are not shown yet.
    pub fn build(
        &self,
        wanted: &[Wanted],
        default_quality: ClothQuality,
        meshes: &mut Assets<Mesh>,
        server: Option<&AssetServer>,
    ) -> Result<ClothState, NotBuilt> {
        if wanted.is_empty() {
            return Err(ClothError::NoMesh.into());
        }
        self.cloth_mesh.validate()?;
        let assets =
            wanted.iter().map(|wanted| loaded(&wanted.source, meshes, server)).collect::<Result<Vec<_>, _>>()?;
        let anchor = usable(&self.transform)?;
        let options = self.cloth_mesh.rest_shape_options();
        let mesh = SourceMesh::read_parts(assets.iter().copied().zip(wanted.iter().map(|wanted| wanted.place)))?;
        let mut parts = Vec::with_capacity(assets.len());
        for (wanted, asset) in wanted.iter().zip(&assets) {
            let first = parts.last().map_or(0, |part: &ClothPart| part.vertices.end);
            parts.push(ClothPart::new(wanted, first, asset));
        }
        let shape = rest_shape(&mesh, anchor.matrix3, &options)?;
        let shading = Shading::new(&mesh, &shape.simulated);
        let described: Vec<_> = assets.iter().copied().zip(parts.iter().map(|part| part.range().len())).collect();
        let pins = self.pins.resolve(&described, &mesh.positions, &shading.rest_normals)?;

        let normals: Vec<[f32; 3]> = shading.rest_normals.iter().map(|n| n.to_array()).collect();
        let of_part = |(part, asset): (&ClothPart, &&Mesh)| own_copy(asset, &part.normals(&normals));
        let copies: Vec<Mesh> = parts.iter().zip(&assets).map(of_part).collect();
        let representatives = representatives(&shape);
        let places = representatives.iter().map(|&v| mesh.positions[v as usize].as_dvec3());
        let bounds = extent(places);
        let shown = Shown {
            positions: mesh.positions.clone(),
            normals,
            from: Some(ShownFrom {
                revision: 0,
                alpha: 1.0,
                frame: anchor.inverse(),
                obstacles: Vec::new(),
                drawn: DAffine3::IDENTITY,
            }),
        };
        let mut binding =
            Binding { parts, options, mesh, shading, representatives, rest_linear: anchor.matrix3, bounds };
        let positions = binding.rest_positions(anchor);
        let quality = *self.quality.unwrap_or(&default_quality);
        let settings = self.solver.as_ref().map_or_else(|| quality.settings(), |solver| solver.0);
        let mut cloth = Cloth::new(shape, self.material.0, settings)?;
        cloth.set_state(&positions, &vec![DVec3::ZERO; positions.len()]);
        // Last, so that a refused cloth leaves no asset behind.
        for (part, copy) in binding.parts.iter_mut().zip(copies) {
            part.own = meshes.add(copy);
        }
        Ok(ClothState {
            cloth,
            binding,
            pins,
            pins_changed: Some(self.pins.last_changed()),
            previous_positions: positions,
            anchor,
            previous_anchor: anchor,
            seen_anchor: anchor,
            limits: ClothInertia::default().limits()?,
            follower: Follower::default(),
            placed: true,
            met: Vec::new(),
            pace: Pace::default(),
            ticks: None,
            near: Vec::new(),
            resumed: Vec::new(),
            quality: self.solver.is_none().then_some(quality),
            share: Share::default(),
            stepped: false,
            suspended: false,
            revision: 0,
            shown,
            report: None,
            step_length: 0.0,
            faults: Faults::default(),
            told: Told::default(),
        })
    }
}

/// The mesh, once it is there.
fn loaded<'a>(
    source: &Handle<Mesh>,
    meshes: &'a Assets<Mesh>,
    server: Option<&AssetServer>,
) -> Result<&'a Mesh, NotBuilt> {
    let missing = || match server.and_then(|server| server.get_load_state(source)) {
        Some(LoadState::Failed(reason)) => ClothError::MeshNotLoaded { reason: reason.to_string() }.into(),
        Some(LoadState::NotLoaded | LoadState::Loading) => NotBuilt::Loading,
        Some(LoadState::Loaded) | None => NotBuilt::Missing,
    };
    meshes.get(source).ok_or_else(missing)
}
