//! What is inside a collider after the last solve all the same is moved out.

use bevy::math::DVec3;

use super::collider::Collider;
use super::features::of_shape;
use super::find::{self, Found, Scene};
use super::layer::{ContactLayer, Surroundings};
use super::meeting::{Body, Meeting};
use super::touch::SURFACE;
use crate::physics::terms::Substep;

/// Share of the thickness that what was rescued is away from the surface.
const MARGIN: f64 = 0.05;
/// Times that a vertex is moved out of a collider in a substep.
const RESCUES: u32 = 4;
/// Share of the thickness that what is between vertices may be inside by.
const INSIDE: f64 = 0.5;
/// Times that it is looked for: what is moved out moves what is beside it.
const LOOKS: u32 = 2;

/// Where a step has led.
struct Ended<'a> {
    /// m.
    x: &'a mut [DVec3],
    /// m/s.
    v: &'a mut [DVec3],
}

impl ContactLayer {
    /// Moves out what ended inside a collider, and stops it there. Says how many vertices that were.
    pub fn guard(
        &mut self,
        around: &Surroundings,
        moving: &Substep,
        end: &mut [DVec3],
        velocities: &mut [DVec3],
    ) -> u32 {
        if around.colliders.is_empty() {
            return 0;
        }
        let mut ended = Ended { x: end, v: velocities };
        let mut rescued = self.guard_vertices(around, moving, &mut ended);
        if self.guard_between(around, moving, &mut ended) {
            rescued += self.guard_vertices(around, moving, &mut ended);
        }
        rescued
    }

    fn guard_vertices(&mut self, around: &Surroundings, moving: &Substep, ended: &mut Ended) -> u32 {
        let Ended { x: end, v: velocities } = ended;
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

    /// The same between vertices, of what has corners or edges there. Says whether there was anything.
    fn guard_between(&mut self, around: &Surroundings, moving: &Substep, ended: &mut Ended) -> bool {
        let Self { faces, near, nearby, features, found, touches, .. } = self;
        let most = INSIDE * around.settings.thickness;
        let mut any = false;
        for &index in &nearby.colliders {
            let collider = &around.colliders[index as usize];
            let Some(features) = of_shape(features, &collider.shape) else { continue };
            let body = Body::new(collider, around.from, around.to);
            let may_be_inside = if body.roundness().is_some() {
                let bulges = |side| body.bulge(side) > most;
                bulges(find::MOST_STRETCHED * faces.longest) && bulges(faces.longest_at(ended.x))
            } else {
                around.is_impact || touches.iter().any(|touch| touch.collider == index && touch.feature != SURFACE)
            };
            if !may_be_inside {
                continue;
            }
            // As it is at the end: which way it came is of no account any more.
            let last = collider.start.towards(&collider.end, around.to);
            let still = Collider { start: last, end: last, ..collider.clone() };
            let there = Body::new(&still, 0.0, 1.0);
            for _ in 0..LOOKS {
                let resting = Substep { x: ended.x, v: ended.v, ..*moving };
                let scene = Scene { around, moving: &resting, faces };
                find::ending(&there, scene, near, |vertex| resting.x[vertex]);
                find::between(&there, features, scene, near, |_| most, |place| found.push(place));
                find::distinct(found);
                let mut moved = false;
                for place in found.drain(..) {
                    moved |= ended.move_out(&place, most, &body, moving);
                }
                any |= moved;
                if !moved {
                    break;
                }
            }
        }
        any
    }
}

impl Ended<'_> {
    /// Moves a place of the cloth out that is inside by more than `most` (m); says whether it was.
    fn move_out(&mut self, place: &Found, most: f64, body: &Body, moving: &Substep) -> bool {
        let Found { vertices, weights, meeting: Meeting { normal, surface, .. }, .. } = *place;
        let corners = vertices.map(|vertex| vertex as usize).into_iter().zip(weights);
        let of = |points: &[DVec3]| corners.clone().map(|(vertex, weight)| weight * points[vertex]).sum::<DVec3>();
        let (x, v) = (of(self.x), of(self.v));
        let free = corners.clone().filter(|&(vertex, _)| !moving.held[vertex]);
        let square: f64 = free.clone().map(|(_, weight)| weight * weight).sum();
        let deep = surface - normal.dot(x) - most;
        if deep <= 0.0 || square == 0.0 || place.passes(body, moving) {
            return false;
        }
        let inwards = normal.dot(v - body.velocity(x, moving.dt)).min(0.0);
        for (vertex, weight) in free {
            self.x[vertex] += weight / square * deep * normal;
            self.v[vertex] -= weight / square * inwards * normal;
        }
        true
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
