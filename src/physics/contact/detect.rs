//! What of a cloth comes near which colliders: before a solve, after it, and at the end.

use std::sync::Arc;

use bevy::math::DVec3;
use parry3d::shape::SharedShape;

use super::features::Features;
use super::find::{self, Found, free};
use super::layer::{ContactLayer, Moving, Surroundings};
use super::meeting::Body;
use super::touch::{SURFACE, Touch};

/// Share of the thickness that what was rescued is away from the surface.
const MARGIN: f64 = 0.05;
/// Times that a vertex is moved out of a collider in a substep.
const RESCUES: usize = 3;
/// Cosine of the angle between two planes that a vertex meets a collider at, above which they are the same side of it.
const SAME_SIDE: f64 = 0.9;

/// Which colliders the free ways of the vertices come near to.
#[derive(Default)]
pub(super) struct Nearby {
    colliders: Vec<u32>,
    /// How far a vertex may end from its free way without coming near any other, m.
    room: f64,
    /// Whether this holds for a whole step that nothing was done in yet.
    fresh: bool,
}

/// Box of the ways of all vertices, m.
fn ways(moving: &Moving) -> (DVec3, DVec3) {
    let nowhere = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    (0..moving.x.len()).fold(nowhere, |(low, high), vertex| {
        let (x, y) = (moving.x[vertex], free(moving, vertex));
        (low.min(x).min(y), high.max(x).max(y))
    })
}

impl ContactLayer {
    /// How far a vertex would come into what contact keeps free if nothing stopped it in a whole step, at most, m; 0 if that is less
    /// than `least`.
    pub fn coming(&mut self, around: &Surroundings, moving: &Moving, least: f64) -> f64 {
        if around.colliders.is_empty() {
            return 0.0;
        }
        self.look_around(around, moving);
        self.nearby.fresh = true;
        if self.nearby.colliders.is_empty() {
            return 0.0;
        }
        let squares = (0..moving.x.len()).map(|v| moving.x[v].distance_squared(free(moving, v)));
        let fastest = squares.fold(0.0, f64::max).sqrt();
        let bodies =
            self.nearby.colliders.iter().map(|&i| Body::new(&around.colliders[i as usize], around.from, around.to));
        let fast = bodies.filter(|body| fastest + body.travel() > least);
        fast.map(|body| find::coming(&body, &self.faces, around, moving, least)).fold(0.0, f64::max)
    }

    fn look_around(&mut self, around: &Surroundings, moving: &Moving) {
        let (low, high) = ways(moving);
        let reach = find::reach(around);
        let Nearby { colliders, room, .. } = &mut self.nearby;
        colliders.clear();
        *room = f64::INFINITY;
        for (index, collider) in (0..).zip(around.colliders) {
            let apart = Body::new(collider, around.from, around.to).distance_to_box(low, high);
            if apart > reach {
                *room = room.min(apart - reach);
            } else {
                colliders.push(index);
            }
        }
    }

    /// Finds the touches of a substep.
    pub fn detect(&mut self, around: &Surroundings, moving: &Moving) {
        self.touches.clear();
        self.room.clear();
        self.room.resize(moving.x.len(), f64::INFINITY);
        if !(self.nearby.fresh && around.from == 0.0 && around.to == 1.0) {
            self.look_around(around, moving);
        }
        self.nearby.fresh = false;
        let mut found = Vec::new();
        let mut before = core::mem::take(&mut self.features);
        for near in 0..self.nearby.colliders.len() {
            let index = self.nearby.colliders[near] as usize;
            let collider = &around.colliders[index];
            let body = Body::new(collider, around.from, around.to);
            let same = |features: &[(_, _)]| {
                features.iter().position(|(s, _): &(SharedShape, Features)| Arc::ptr_eq(&s.0, &collider.shape.0))
            };
            let known = same(&self.features).unwrap_or_else(|| {
                let of_shape = match same(&before) {
                    Some(known) => before.swap_remove(known),
                    None => (collider.shape.clone(), Features::new(&collider.shape)),
                };
                self.features.push(of_shape);
                self.features.len() - 1
            });
            let Self { faces, near, room, features, .. } = self;
            find::vertices(&body, around, moving, faces, near, room, |vertex| found.push(vertex));
            find::between(&body, &features[known].1, faces, around, moving, near, |place| found.push(place));
            find::distinct(&mut found);
            for found in found.drain(..) {
                self.begin(found, index, &body, around, moving);
            }
        }
    }

    /// The colliders that matter where vertices end as these do, which may be elsewhere than where they were looked for.
    fn bodies<'a>(
        &self,
        around: &Surroundings<'a>,
        moving: &Moving,
        end: impl Fn(usize) -> DVec3,
    ) -> Vec<(usize, Body<'a>)> {
        let body = |index: usize| (index, Body::new(&around.colliders[index], around.from, around.to));
        let room = self.nearby.room * self.nearby.room;
        let astray = |vertex: usize| end(vertex).distance_squared(free(moving, vertex)) >= room;
        if room.is_finite() && (0..moving.x.len()).any(astray) {
            (0..around.colliders.len()).map(body).collect()
        } else {
            self.nearby.colliders.iter().map(|&index| body(index as usize)).collect()
        }
    }

    /// Whether a vertex that ends there may be near what it was not seen to come near.
    fn strays(&self, moving: &Moving, vertex: usize, end: DVec3) -> bool {
        let room = self.room[vertex].min(self.nearby.room);
        !moving.held[vertex] && end.distance_squared(free(moving, vertex)) >= room * room
    }

    /// Finds what would end inside a collider that it was not seen to come near, after a solve that leads to `end`. Says whether
    /// there was anything.
    pub fn find_late(&mut self, around: &Surroundings, moving: &Moving, end: impl Fn(usize) -> DVec3) -> bool {
        let mut any = false;
        let bodies = self.bodies(around, moving, &end);
        for vertex in 0..moving.x.len() {
            let end = end(vertex);
            if !self.strays(moving, vertex, end) {
                continue;
            }
            for &(index, ref body) in &bodies {
                let limits = find::limits(body, &self.faces, around);
                let way = body.local(moving.x[vertex], end);
                let nearest = body.nearest(way[1], limits[1] + way[0].distance(way[1]));
                let Ok(meeting) = body.meet(way, nearest, limits, moving.dt) else { continue };
                if meeting.surface - meeting.normal.dot(end) < 0.0 {
                    continue;
                }
                let of_this = |touch: &&mut Touch| {
                    touch.feature == SURFACE && touch.vertices[0] as usize == vertex && touch.collider as usize == index
                };
                match self.touches.iter_mut().find(of_this) {
                    Some(touch) if touch.is_active() && touch.normal.dot(meeting.normal) > SAME_SIDE => continue,
                    Some(touch) => {
                        touch.normal = meeting.normal;
                        touch.offset = meeting.offset;
                        touch.surface = meeting.surface;
                        touch.choose(end);
                    }
                    None => {
                        let vertices = [vertex as u32; 3];
                        let found = Found { vertices, weights: [1.0, 0.0, 0.0], feature: SURFACE, meeting };
                        self.begin(found, index, body, around, moving);
                        if let Some(touch) = self.touches.last_mut() {
                            touch.choose(end);
                        }
                    }
                }
                any = true;
            }
        }
        // In an impact, triangles come in elsewhere than they were seen to.
        if around.to - around.from < 1.0 {
            any |= self.find_between_late(&bodies, around, moving, end);
        }
        any
    }

    /// The same between vertices.
    fn find_between_late(
        &mut self,
        bodies: &[(usize, Body)],
        around: &Surroundings,
        moving: &Moving,
        end: impl Fn(usize) -> DVec3,
    ) -> bool {
        let (mut any, mut found) = (false, Vec::new());
        for &(index, ref body) in bodies {
            let shape = &around.colliders[index].shape;
            let Some((_, features)) = self.features.iter().find(|(known, _)| Arc::ptr_eq(&known.0, &shape.0)) else {
                continue;
            };
            find::ending(body, around, moving, &self.faces, &mut self.near, &end);
            find::between(body, features, &self.faces, around, moving, &self.near, |place| found.push(place));
            find::distinct(&mut found);
            for found in found.drain(..) {
                let places = found.vertices.iter().zip(found.weights);
                let x: DVec3 = places.map(|(&vertex, weight)| weight * end(vertex as usize)).sum();
                let held = |touch: &Touch| {
                    (touch.collider as usize, touch.feature, touch.vertices) == (index, found.feature, found.vertices)
                        && touch.is_active()
                };
                if found.meeting.normal.dot(x) > found.meeting.surface || self.touches.iter().any(held) {
                    continue;
                }
                self.begin(found, index, body, around, moving);
                if let Some(touch) = self.touches.last_mut() {
                    touch.choose(x);
                }
                any = true;
            }
        }
        any
    }

    /// Moves out what ended inside a collider all the same, and stops it there. Says how many vertices that were.
    pub fn guard(&self, around: &Surroundings, moving: &Moving, end: &mut [DVec3], velocities: &mut [DVec3]) -> u32 {
        if around.colliders.is_empty() {
            return 0;
        }
        let mut rescued = 0;
        let bodies = self.bodies(around, moving, |vertex| end[vertex]);
        let margin = MARGIN * around.settings.thickness;
        for vertex in 0..end.len() {
            if !self.strays(moving, vertex, end[vertex]) {
                continue;
            }
            // What is moved out of one part of a collider may be in another.
            for body in bodies.iter().flat_map(|(_, body)| [body; RESCUES]) {
                let way = body.local(moving.x[vertex], end[vertex]);
                let nearest = body.nearest(way[1], way[0].distance(way[1]) + around.settings.thickness);
                let Ok(meeting) = body.meet(way, nearest, [0.0, 0.0], moving.dt) else { continue };
                let depth = meeting.surface - meeting.normal.dot(end[vertex]);
                if depth > 0.0 {
                    rescued += 1;
                    end[vertex] += (depth + margin) * meeting.normal;
                    let surface = (meeting.carried - moving.x[vertex]) / moving.dt;
                    let inwards = meeting.normal.dot(velocities[vertex] - surface).min(0.0);
                    velocities[vertex] -= inwards * meeting.normal;
                }
            }
        }
        rescued
    }
}
