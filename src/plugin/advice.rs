//! What is legal and surely not meant: told once, as a warning that says what to do.

use bevy::ecs::change_detection::Tick;
use bevy::ecs::name::NameOrEntityItem;
use bevy::math::{DMat3, DVec3};
use bevy::prelude::*;

use super::geometry::extent;
use super::pins::ClothPins;
use super::sets::Sets;
use super::state::ClothState;

/// Densities of fabrics, kg/m²: from chiffon to wet leather, with room to either side.
const DENSITIES: core::ops::RangeInclusive<f32> = 0.01..=5.0;
/// Sides of a mesh above this are no cloth, m.
const LARGEST: f64 = 50.0;
/// Nor are those below this, m.
const SMALLEST: f64 = 0.01;
/// Frames that a small scale must last: what grows out of nothing is small for a while.
const FRAMES: u32 = 60;

/// What was told of a cloth.
#[derive(Default)]
pub(super) struct Told {
    /// The rules that were looked at.
    rules: Option<Tick>,
    density: bool,
    size: bool,
    /// The scale that was looked at, and for how many frames it has lasted.
    linear: Option<DMat3>,
    frames: u32,
}

/// Looks at what has changed.
pub(super) fn advise(mut cloths: Query<(NameOrEntity, &mut ClothState, Option<Ref<ClothPins>>)>) {
    for (name, mut state, pins) in &mut cloths {
        let state = state.bypass_change_detection();
        if let Some(pins) = pins
            && state.pins_changed == Some(pins.last_changed())
            && state.told.rules != state.pins_changed
        {
            state.told.rules = state.pins_changed;
            state.judge_pins(&name, &pins);
        }
        let density = state.cloth.fabric().density;
        if !state.told.density && !DENSITIES.contains(&density) {
            state.told.density = true;
            tracing::warn!(
                "cloth {name}: a density of {density} kg/m² is that of no fabric, which have 0.02 to 1: is it in g/m²?"
            );
        }
        if !state.told.size {
            state.judge_size(&name);
        }
    }
}

impl ClothState {
    fn judge_pins(&self, name: &NameOrEntityItem, pins: &ClothPins) {
        let lost = pins.lost_predicates();
        if lost > 0 {
            tracing::warn!(
                "cloth {name}: `ClothPins` has lost {lost} predicates, which are code and are not saved: insert it again, or \
                 use `ClothPins::in_box`, `indices` or `where_color`"
            );
        }
        let simulated = &self.cloth.shape().simulated;
        let held: Vec<u32> = self.pins.iter().filter_map(|&vertex| simulated[vertex as usize]).collect();
        if held.is_empty() {
            if pins.asks_for_vertices() && lost == 0 {
                let positions = &self.binding.mesh.positions;
                // Zero has two signs, and one is told.
                let [min, max] = extent(positions.iter().map(|p| p.as_dvec3())).map(|corner| corner + DVec3::ZERO);
                tracing::warn!(
                    "cloth {name}: `ClothPins` holds none of {} vertices (the mesh spans x {}..{}, y {}..{}, z {}..{}; \
                     positions are those of the mesh, before the entity's transform)",
                    positions.len(),
                    min.x as f32,
                    max.x as f32,
                    min.y as f32,
                    max.y as f32,
                    min.z as f32,
                    max.z as f32,
                );
            }
            return;
        }
        let (all, loose) = self.pieces(held.into_iter().chain(self.cloth.pinned().map(|(vertex, _)| vertex)));
        if loose > 0 {
            tracing::warn!(
                "cloth {name}: {loose} of the {all} separate pieces of the mesh have no held vertex, and fall: pin them too, or \
                 join them to the others (`ClothMesh::weld_distance`)"
            );
        }
    }

    /// How many pieces the cloth is made of, and how many of them have none of these vertices.
    fn pieces(&self, held: impl Iterator<Item = u32>) -> (usize, usize) {
        let shape = self.cloth.shape();
        let mut sets = Sets::new(shape.vertex_count());
        for triangle in &shape.triangles {
            let [a, b, c] = triangle.vertices;
            sets.join(a, b, false);
            sets.join(b, c, false);
        }
        let mut is_held = vec![false; shape.vertex_count()];
        for vertex in held {
            is_held[sets.find(vertex).0 as usize] = true;
        }
        let pieces = (0..shape.vertex_count() as u32).filter(|&vertex| sets.find(vertex).0 == vertex);
        pieces.fold((0, 0), |(all, loose), piece| (all + 1, loose + usize::from(!is_held[piece as usize])))
    }

    fn judge_size(&mut self, name: &NameOrEntityItem) {
        let linear = self.binding.rest_linear;
        let lasts = self.told.linear == Some(linear);
        if !lasts {
            (self.told.linear, self.told.frames) = (Some(linear), 0);
        } else if self.told.frames < FRAMES {
            self.told.frames += 1;
        }
        // Once when it is new, and once when it has lasted.
        if lasts && self.told.frames != FRAMES {
            return;
        }
        let [min, max] = extent(self.cloth.shape().positions.iter().copied());
        let size = (max - min).max_element();
        let (too, hint) = if size > LARGEST {
            ("large", "are its units centimeters?")
        } else if size < SMALLEST && lasts {
            ("small", "is its unit a meter?")
        } else {
            self.told.frames += u32::from(lasts);
            return;
        };
        self.told.size = true;
        tracing::warn!(
            "cloth {name}: a mesh of {size:.3} m is too {too} for cloth: {hint} The entity's scale counts, and may put it right"
        );
    }
}
