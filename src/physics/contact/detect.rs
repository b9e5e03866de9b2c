//! What of a cloth comes near which colliders: before a solve, after it, and at the end.

use std::sync::Arc;

use bevy::math::DVec3;
use parry3d::shape::SharedShape;

use super::features::Features;
use super::find::{self, Found, Scene};
use super::layer::{ContactLayer, Moving, Surroundings};
use super::meeting::{Body, Meeting};
use super::touch::{SURFACE, Touch};

/// Share of the thickness that what was rescued is away from the surface.
const MARGIN: f64 = 0.05;
/// Times that a vertex is moved out of a collider in a substep.
const RESCUES: u32 = 4;
/// Cosine of the angle between two planes that a vertex meets a collider at, above which they are the same side of it.
const SAME_SIDE: f64 = 0.9;

/// Which colliders the free ways of the vertices come near to.
#[derive(Default)]
pub(super) struct Nearby {
    colliders: Vec<u32>,
    /// How far a vertex may end from its free way without coming near any other, m.
    room: f64,
    /// By vertex: where its free way ends in the substep that was looked around in, m.
    free: Vec<DVec3>,
    /// Whether this holds for a whole step that nothing was done in yet.
    fresh: bool,
}

impl ContactLayer {
    /// How far a vertex would come into what contact keeps free if nothing stopped it in a whole step, at most, m; 0 if that is less
    /// than `least`.
    pub fn coming(&mut self, around: &Surroundings, moving: &Moving, least: f64) -> f64 {
        if around.colliders.is_empty() {
            return 0.0;
        }
        let fastest = self.look_around(around, moving);
        self.nearby.fresh = true;
        let Nearby { colliders, free, .. } = &self.nearby;
        let scene = Scene { around, moving, faces: &self.faces };
        let bodies = colliders.iter().map(|&i| Body::new(&around.colliders[i as usize], around.from, around.to));
        let fast = bodies.filter(|body| fastest + body.travel() > least);
        fast.map(|body| find::coming(&body, scene, free, least)).fold(0.0, f64::max)
    }

    /// Notes which colliders are near, and says how long the longest free way is, m.
    fn look_around(&mut self, around: &Surroundings, moving: &Moving) -> f64 {
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
            let apart = Body::new(collider, around.from, around.to).distance_to_box(low, high);
            if apart > reach {
                *room = room.min(apart - reach);
            } else {
                colliders.push(index);
            }
        }
        fastest.sqrt()
    }

    /// Finds the touches of a substep.
    pub fn detect(&mut self, around: &Surroundings, moving: &Moving) {
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
            let Self { faces, near, room, features, nearby: Nearby { free, .. }, .. } = self;
            let scene = Scene { around, moving, faces };
            let features = &features[known].1;
            let noted = (!features.is_empty()).then_some(&mut *near);
            find::vertices(&body, scene, free, noted, room, |vertex| found.push(vertex));
            if !features.is_empty() {
                let vertices = found.len();
                find::between(&body, features, scene, near, |place| found.push(place));
                // Vertices are last among what is put onto planes: theirs hold exactly then.
                if found.len() > vertices {
                    find::distinct(&mut found);
                }
            }
            for found in found.drain(..) {
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
    fn look_astray(&mut self, end: impl Fn(usize) -> DVec3) -> f64 {
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
    fn bodies<'a>(&self, around: &Surroundings<'a>, furthest: f64) -> Vec<(usize, Body<'a>)> {
        let body = |index: usize| (index, Body::new(&around.colliders[index], around.from, around.to));
        if furthest >= self.nearby.room * self.nearby.room {
            (0..around.colliders.len()).map(body).collect()
        } else {
            self.nearby.colliders.iter().map(|&index| body(index as usize)).collect()
        }
    }

    /// Finds what would end inside a collider that it was not seen to come near, after a solve that leads to `end`. Says whether
    /// there was anything.
    pub fn find_late(&mut self, around: &Surroundings, moving: &Moving, end: impl Fn(usize) -> DVec3) -> bool {
        let mut any = false;
        let furthest = self.look_astray(&end);
        let bodies = self.bodies(around, furthest);
        let astray = core::mem::take(&mut self.astray);
        for &(index, ref body) in &bodies {
            let limits = find::limits(body, Scene { around, moving, faces: &self.faces });
            for vertex in astray.iter().map(|&vertex| vertex as usize) {
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
        moving: &Moving,
        end: impl Fn(usize) -> DVec3,
    ) -> bool {
        let (mut any, mut found) = (false, Vec::new());
        for &(index, ref body) in bodies {
            // What is round all over is met by vertices, but in an impact.
            if body.is_round() && around.is_whole() {
                continue;
            }
            let shape = &around.colliders[index].shape;
            let known = self.features.iter().find(|(known, _)| Arc::ptr_eq(&known.0, &shape.0));
            let Some((_, features)) = known.filter(|(_, features)| !features.is_empty()) else { continue };
            let scene = Scene { around, moving, faces: &self.faces };
            find::ending(body, scene, &mut self.near, &end);
            find::between(body, features, scene, &self.near, |place| found.push(place));
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
    pub fn guard(
        &mut self,
        around: &Surroundings,
        moving: &Moving,
        end: &mut [DVec3],
        velocities: &mut [DVec3],
    ) -> u32 {
        if around.colliders.is_empty() {
            return 0;
        }
        let mut rescued = 0;
        let furthest = self.look_astray(|vertex| end[vertex]);
        let bodies = self.bodies(around, furthest);
        let margin = MARGIN * around.settings.thickness;
        for vertex in self.astray.iter().map(|&vertex| vertex as usize) {
            let x = moving.x[vertex];
            let inside = |end: DVec3| bodies.iter().find_map(|(_, body)| entered(body, x, end, around, moving.dt));
            let mut rescues = 0;
            while let Some(meeting) = inside(end[vertex]) {
                let surface = (meeting.carried - x) / moving.dt;
                if rescues == RESCUES {
                    // In a corner, or between two solids: it is taken along from where it was.
                    (end[vertex], velocities[vertex]) = (meeting.carried, surface);
                    break;
                }
                // What is moved out of one part of a collider may be in another.
                rescues += 1;
                end[vertex] += (meeting.surface - meeting.normal.dot(end[vertex]) + margin) * meeting.normal;
                let inwards = meeting.normal.dot(velocities[vertex] - surface).min(0.0);
                velocities[vertex] -= inwards * meeting.normal;
            }
            rescued += rescues.min(1);
        }
        rescued
    }
}

/// The meeting of a point that goes from `x` to `end` with a collider that it ends inside of.
fn entered(body: &Body, x: DVec3, end: DVec3, around: &Surroundings, dt: f64) -> Option<Meeting> {
    let way = body.local(x, end);
    let travel = way[0].distance(way[1]);
    let nearest = body.nearest(way[1], travel + around.settings.thickness);
    if nearest.distance > travel {
        // It is outside, and did not come far enough to have been anywhere else.
        return None;
    }
    let meeting = body.meet(way, nearest, [0.0, 0.0], dt).ok()?;
    (meeting.surface > meeting.normal.dot(end)).then_some(meeting)
}
