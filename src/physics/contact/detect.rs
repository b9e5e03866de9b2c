//! What of a cloth comes near which colliders: before a solve, after it, and at the end.

use std::sync::Arc;

use bevy::math::DVec3;
use parry3d::shape::SharedShape;

use super::features::{Features, of_shape};
use super::find::{self, Found, Scene};
use super::known::features_of;
use super::layer::{ContactLayer, Surroundings};
use super::meeting::Body;
use super::touch::{SURFACE, Touch};
use crate::physics::terms::Substep;

/// Cosine of the angle between two planes that a vertex meets a collider at, above which they are the same side of it.
const SAME_SIDE: f64 = 0.9;

/// Which colliders the free ways of the vertices come near to.
#[derive(Default)]
pub(super) struct Nearby {
    pub colliders: Vec<u32>,
    /// How far a vertex may end from its free way without coming near any other, m.
    room: f64,
    /// By vertex: where its free way ends in the substep that was looked around in, m.
    free: Vec<DVec3>,
    /// By vertex: how far colliders would push it out of where its free way ends, m; empty if none is fast.
    pushes: Vec<DVec3>,
    /// Whether this holds for a whole step that nothing was done in yet.
    fresh: bool,
}

impl ContactLayer {
    /// How much further than a vertex beside it colliders would push a vertex in a whole step, at most, m; 0 if nothing is pushed
    /// further than `least`. What is pushed on alone is torn about.
    pub fn shear(&mut self, around: &Surroundings, moving: &Substep, least: f64) -> f64 {
        if around.colliders.is_empty() {
            return 0.0;
        }
        let fastest = self.look_around(around, moving);
        self.nearby.fresh = true;
        let Self { faces, nearby: Nearby { colliders, free, pushes, .. }, .. } = self;
        let scene = Scene { around, moving, faces };
        pushes.clear();
        for &index in &*colliders {
            let body = Body::new(&around.colliders[index as usize], around.from, around.to);
            if fastest + body.travel() > least {
                pushes.resize(moving.x.len(), DVec3::ZERO);
                find::pushes(&body, scene, free, least, pushes);
            }
        }
        if pushes.iter().all(|push| push.length_squared() <= least * least) {
            return 0.0;
        }
        let sides = faces.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let ends = sides.map(|side| side.map(|vertex| pushes[vertex as usize]));
        ends.map(|[a, b]| a.distance_squared(b)).fold(0.0, f64::max).sqrt()
    }

    /// Notes which colliders are near, and says how long the longest free way is, m.
    fn look_around(&mut self, around: &Surroundings, moving: &Substep) -> f64 {
        let Nearby { colliders, room, free, .. } = &mut self.nearby;
        free.clear();
        free.extend((0..moving.x.len()).map(|vertex| find::free(moving, vertex)));
        let (mut low, mut high, mut fastest) = (DVec3::INFINITY, DVec3::NEG_INFINITY, 0.0_f64);
        for (&x, &y) in moving.x.iter().zip(&*free) {
            (low, high) = (low.min(x).min(y), high.max(x).max(y));
            fastest = fastest.max(x.distance_squared(y));
        }
        let reach = find::reach(around);
        colliders.clear();
        *room = f64::INFINITY;
        for (index, collider) in (0..).zip(around.colliders) {
            let body = Body::new(collider, around.from, around.to);
            let apart = body.distance_to_box(low, high);
            if apart > reach {
                *room = room.min(apart - reach);
            } else {
                colliders.push(index);
            }
        }
        fastest.sqrt()
    }

    /// Finds the touches of a substep.
    pub fn detect(&mut self, around: &Surroundings, moving: &Substep) {
        self.touches.clear();
        self.room.clear();
        self.room.resize(moving.x.len(), f64::INFINITY);
        if !(self.nearby.fresh && around.is_whole()) {
            self.look_around(around, moving);
        }
        self.nearby.fresh = false;
        let mut found = core::mem::take(&mut self.found);
        let mut before = core::mem::take(&mut self.features);
        for near in 0..self.nearby.colliders.len() {
            let index = self.nearby.colliders[near] as usize;
            let collider = &around.colliders[index];
            let body = Body::new(collider, around.from, around.to);
            let same = |features: &[(_, _)]| {
                features.iter().position(|(s, _): &(SharedShape, Arc<Features>)| Arc::ptr_eq(&s.0, &collider.shape.0))
            };
            let known = same(&self.features).unwrap_or_else(|| {
                let its = match same(&before) {
                    Some(known) => before.swap_remove(known),
                    None => (collider.shape.clone(), features_of(&collider.shape)),
                };
                self.features.push(its);
                self.features.len() - 1
            });
            let Self { faces, near, room, features, nearby: Nearby { free, .. }, .. } = self;
            let scene = Scene { around, moving, faces };
            let features = &features[known].1;
            let looked = !features.is_empty() && find::may_be_between(&body, scene);
            find::vertices(&body, scene, free, looked.then_some(&mut *near), room, |vertex| found.push(vertex));
            if looked {
                let vertices = found.len();
                let most = |triangle: &[u32; 3]| find::bulge(&body, scene, triangle);
                find::between(&body, features, scene, near, most, |place| found.push(place));
                // Vertices are last among what is put onto planes: theirs hold exactly then.
                if found.len() > vertices {
                    find::distinct(&mut found);
                }
            }
            for found in found.drain(..).filter(|found| !found.passes(&body, moving)) {
                self.begin(found, index, &body, around, moving);
            }
        }
        self.found = found;
        let all = self.nearby.room;
        for (room, &held) in self.room.iter_mut().zip(moving.held) {
            let least = room.min(all);
            *room = if held { f64::INFINITY } else { least * least };
        }
    }

    /// Looks for vertices that may end near what they were not seen to come near, and says how far any ended from its free way at most,
    /// squared, m².
    pub(super) fn look_astray(&mut self, end: impl Fn(usize) -> DVec3) -> f64 {
        let Self { astray, room, nearby: Nearby { free, .. }, .. } = self;
        astray.clear();
        let mut furthest = 0.0_f64;
        for (vertex, (&free, &room)) in free.iter().zip(&*room).enumerate() {
            let square = end(vertex).distance_squared(free);
            furthest = furthest.max(square);
            if square >= room {
                astray.push(vertex as u32);
            }
        }
        furthest
    }

    /// The colliders that matter to vertices that ended so far from their free ways.
    pub(super) fn bodies<'a>(&self, around: &Surroundings<'a>, furthest: f64) -> Vec<(usize, Body<'a>)> {
        let body = |index: usize| (index, Body::new(&around.colliders[index], around.from, around.to));
        if furthest >= self.nearby.room * self.nearby.room {
            (0..around.colliders.len()).map(body).collect()
        } else {
            self.nearby.colliders.iter().map(|&index| body(index as usize)).collect()
        }
    }

    /// Finds what would end inside a collider that it was not seen to come near, after a solve that leads to `end`. Says whether
    /// there was anything.
    pub fn find_late(&mut self, around: &Surroundings, moving: &Substep, end: impl Fn(usize) -> DVec3) -> bool {
        if around.colliders.is_empty() {
            return false;
        }
        let mut any = false;
        let furthest = self.look_astray(&end);
        let bodies = self.bodies(around, furthest);
        let astray = core::mem::take(&mut self.astray);
        for &(index, ref body) in &bodies {
            for vertex in astray.iter().map(|&vertex| vertex as usize) {
                let limits = find::limits(body, Scene { around, moving, faces: &self.faces }, vertex);
                let end = end(vertex);
                let way = body.local(moving.x[vertex], end);
                let travel = way[0].distance(way[1]);
                let nearest = body.nearest(way[1], limits[1] + travel);
                if nearest.distance > travel {
                    // It is outside, and did not come far enough to have been anywhere else.
                    continue;
                }
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
        self.astray = astray;
        // Where vertices end nearly as they were seen to, so do triangles.
        if furthest > around.settings.thickness * around.settings.thickness {
            any |= self.find_between_late(&bodies, around, moving, end);
        }
        any
    }

    /// The same between vertices.
    fn find_between_late(
        &mut self,
        bodies: &[(usize, Body)],
        around: &Surroundings,
        moving: &Substep,
        end: impl Fn(usize) -> DVec3,
    ) -> bool {
        let (mut any, mut found) = (false, Vec::new());
        for &(index, ref body) in bodies {
            // What is round all over is met by vertices, but in an impact.
            if body.roundness().is_some() && !around.is_impact {
                continue;
            }
            let Some(features) = of_shape(&self.features, &around.colliders[index].shape) else { continue };
            let scene = Scene { around, moving, faces: &self.faces };
            if !find::may_be_between(body, scene) {
                continue;
            }
            find::ending(body, scene, &mut self.near, &end);
            let most = |triangle: &[u32; 3]| find::bulge(body, scene, triangle);
            find::between(body, features, scene, &self.near, most, |place| found.push(place));
            find::distinct(&mut found);
            for found in found.drain(..) {
                let places = found.vertices.iter().zip(found.weights);
                let x: DVec3 = places.map(|(&vertex, weight)| weight * end(vertex as usize)).sum();
                let held = |touch: &Touch| {
                    (touch.collider as usize, touch.feature, touch.vertices) == (index, found.feature, found.vertices)
                        && touch.is_active()
                };
                let outside = found.meeting.normal.dot(x) > found.meeting.surface;
                if outside || self.touches.iter().any(held) || found.passes(body, moving) {
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
}
