//! All touches of a cloth: found before a step, remembered after it.

use std::sync::Arc;

use bevy::math::DVec3;
use parry3d::shape::SharedShape;

use super::collider::{Collider, Contact, ContactSettings};
use super::features::Features;
use super::find::{self, Faces, Found, Near, free};
use super::meeting::Body;
use super::memory::{Memories, Memory};
use super::touch::{Case, SURFACE, Touch};
use crate::physics::assembly::ContactTerm;
use crate::physics::material::Fabric;

/// Stiffness of a touch over that of inertia in a step, m/Δt², at least.
const OVER_INERTIA: f64 = 4.0;
/// Share of the thickness that its load presses it in by.
const GIVE: f64 = 0.05;
/// Its stiffness over that of the fabric, at most: what a harder one would hold out, the forces of earlier steps do.
const STIFFEST: f64 = 10.0;
/// Its stiffness over that of the fabric, where the fabric pulls it in.
const OVER_FABRIC: f64 = 0.05;
/// A force that has not grown by more than this factor in a step lasts.
const STEADY: f64 = 2.0;
/// Share of the thickness that what is no impact comes in by.
const GENTLE: f64 = 0.3;
/// Share of the way back to the surface that what lies too far away is drawn by in a step.
const DRAWN_BACK: f64 = 0.02;
/// Share of the thickness that what was rescued is away from the surface.
const MARGIN: f64 = 0.05;
/// Times that a vertex is moved out of a collider in a substep.
const RESCUES: usize = 3;
/// Share of the forces of contact that may be wrong.
const WRONG: f64 = 0.1;

/// What the touches need to know of a substep. All vertices are numbered as the engine does.
#[derive(Clone, Copy)]
pub(crate) struct Surroundings<'a> {
    pub colliders: &'a [Collider],
    pub settings: ContactSettings,
    /// The substep as shares of the way of the colliders.
    pub from: f64,
    pub to: f64,
}

/// State of the substep that touches are found for.
pub(crate) struct Moving<'a> {
    pub x: &'a [DVec3],
    pub v: &'a [DVec3],
    pub held: &'a [bool],
    pub masses: &'a [f64],
    pub gravity: DVec3,
    pub dt: f64,
}

/// The touches of one cloth.
#[derive(Default)]
pub(crate) struct ContactLayer {
    touches: Vec<Touch>,
    /// Those of the substep before.
    memory: Memories,
    faces: Faces,
    /// Of the shapes that were near in the last substep: the shape tells them apart.
    features: Vec<(SharedShape, Features)>,
    /// All vertices, in the frame of the collider that is looked at.
    near: Vec<Near>,
    /// By vertex: how far it may end from where it was looked for without being inside anything, m.
    room: Vec<f64>,
    terms: Vec<ContactTerm>,
    /// Stiffness of the fabric, N/m.
    fabric: f64,
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
    /// For a cloth of these triangles, whose longest side is so many metres at rest.
    pub fn new(fabric: &Fabric, triangles: Vec<[u32; 3]>, longest: f64) -> Self {
        let mut layer = Self { faces: Faces { triangles, longest }, ..Self::default() };
        layer.set_fabric(fabric);
        layer
    }

    /// Changes the fabric, which says how stiff contact must be.
    pub fn set_fabric(&mut self, fabric: &Fabric) {
        self.fabric = f64::from(fabric.warp_stiffness.max(fabric.weft_stiffness));
    }

    /// Length of the longest side of a triangle at rest, m.
    pub fn longest_side(&self) -> f64 {
        self.faces.longest
    }

    /// How far a vertex would come into what contact keeps free if nothing stopped it, at most, m; 0 if that is less than `least`.
    pub fn coming(&self, around: &Surroundings, moving: &Moving, least: f64) -> f64 {
        let mut box_of_ways = None;
        let mut deepest = 0.0_f64;
        for collider in around.colliders {
            let body = Body::new(collider, around.from, around.to);
            let (low, high, fastest) = *box_of_ways.get_or_insert_with(|| {
                let (low, high) = ways(moving);
                let fastest = (0..moving.x.len()).map(|v| moving.x[v].distance_squared(free(moving, v)));
                (low, high, fastest.fold(0.0, f64::max).sqrt())
            });
            if body.distance_to_box(low, high) == 0.0 && fastest + body.travel() > least {
                deepest = deepest.max(find::coming(&body, around, moving, least));
            }
        }
        deepest
    }

    /// Finds the touches of a substep.
    pub fn detect(&mut self, around: &Surroundings, moving: &Moving) {
        self.touches.clear();
        self.room.clear();
        self.room.resize(moving.x.len(), f64::INFINITY);
        let (low, high) = ways(moving);
        let reach = find::reach(around);
        let mut closest = f64::INFINITY;
        let mut found = Vec::new();
        let mut features = core::mem::take(&mut self.features);
        for (index, collider) in around.colliders.iter().enumerate() {
            let body = Body::new(collider, around.from, around.to);
            let apart = body.distance_to_box(low, high);
            if apart > reach {
                closest = closest.min(apart - reach);
                continue;
            }
            found.clear();
            let Self { faces, near, room, .. } = self;
            find::vertices(&body, around, moving, faces, near, room, |vertex| found.push(vertex));
            let of_shape = match features.iter().position(|(shape, _)| Arc::ptr_eq(&shape.0, &collider.shape.0)) {
                Some(known) => features.swap_remove(known),
                None => (collider.shape.clone(), Features::new(&collider.shape)),
            };
            find::between(&body, &of_shape.1, faces, around, moving, near, |place| found.push(place));
            self.features.push(of_shape);
            // An edge of the cloth is a side of two triangles.
            found.sort_by_key(|found| (found.feature, found.vertices));
            found.dedup_by_key(|found| (found.feature, found.vertices));
            for found in found.drain(..) {
                self.touch(found, index, &body, around, moving);
            }
        }
        for room in &mut self.room {
            *room = room.min(closest);
        }
    }

    /// Makes a touch of what was found.
    fn touch(&mut self, found: Found, index: usize, body: &Body, around: &Surroundings, moving: &Moving) {
        let Found { vertices, weights, feature, meeting } = found;
        let Surroundings { colliders, settings, .. } = around;
        let collider = &colliders[index];
        let at = |points: &dyn Fn(usize) -> DVec3| -> DVec3 {
            vertices.iter().zip(weights).map(|(&vertex, weight)| weight * points(vertex as usize)).sum()
        };
        let inertial = at(&|vertex| moving.x[vertex] + moving.dt * moving.v[vertex]);
        let y = at(&|vertex| free(moving, vertex));
        // What a force on the place must move.
        let mobility: f64 = (vertices.iter().zip(weights))
            .filter(|&(&vertex, _)| !moving.held[vertex as usize])
            .map(|(&vertex, weight)| weight * weight / moving.masses[vertex as usize])
            .sum();
        let inertia = 1.0 / (mobility * moving.dt * moving.dt);
        let mut touch = Touch {
            vertices,
            weights,
            collider: index as u32,
            feature,
            normal: meeting.normal,
            offset: meeting.offset,
            surface: meeting.surface,
            carried: meeting.carried,
            stiffness: 0.0,
            lambda: 0.0,
            tau: DVec3::ZERO,
            pressing: inertia * (meeting.offset - meeting.normal.dot(y)).max(0.0),
            friction: (collider.friction * settings.friction).sqrt(),
            case: Case::Apart,
            last: 0.0,
            steady: false,
            drag: 0.0,
            force: DVec3::ZERO,
            acted: DVec3::ZERO,
        };
        let mut slipping = None;
        let give = GIVE * settings.thickness;
        if let Some(memory) = self.memory.recall(collider.id, &touch) {
            let tangential = |way: DVec3| way - touch.normal.dot(way) * touch.normal;
            // The force of an impact would throw the vertex off again: what lasts is in two steps.
            let steady = memory.normal_force < STEADY * memory.before;
            touch.lambda = if steady { memory.normal_force } else { memory.before };
            // Where it lies a little further away than it must, it lies well: drawn back at once to where forces are counted from, it
            // would come as far inside, and swing.
            let away = touch.normal.dot(touch.carried) - touch.offset;
            if away > 0.0 && steady {
                touch.offset += (1.0 - DRAWN_BACK) * away;
            }
            touch.last = memory.normal_force;
            touch.pressing = memory.normal_force;
            let friction_force = tangential(body.turn(memory.friction));
            touch.tau = friction_force.clamp_length_max(touch.friction * touch.lambda);
            touch.steady = steady;
            slipping = memory.slipping.and_then(|way| tangential(body.turn(way)).try_normalize());
        }
        // As stiff as its force needs, so that what is loaded lightly is let go and found again smoothly: of the step
        // before, or to stop what comes in, with the fabric that pulls it.
        let coming = (touch.offset - touch.normal.dot(inertial)).max(0.0);
        let load = touch.last.max(inertia * coming);
        touch.steady |= coming < GENTLE * settings.thickness;
        let thickness = settings.thickness;
        let pulled = OVER_FABRIC * self.fabric * (coming / thickness).min(1.0);
        let stiff = (load / give).min(STIFFEST * self.fabric);
        touch.stiffness = pulled + (OVER_INERTIA * inertia).max(stiff);
        // What is not held up by the surface may be by the fabric: gravity alone brings nothing into touch.
        let pulled_in = touch.last > 0.0 && touch.normal.dot(y - inertial) < 0.0;
        touch.choose_between(if pulled_in { y } else { inertial }, inertial);
        touch.stay(slipping, inertial);
        self.touches.push(touch);
    }

    /// Whether nothing is near.
    pub fn is_empty(&self) -> bool {
        self.touches.is_empty()
    }

    /// Vertices of touches that have a force; some more than once.
    pub fn touched(&self) -> impl Iterator<Item = usize> {
        self.touches.iter().filter(|touch| touch.is_active()).flat_map(|touch| {
            let corners = touch.vertices.iter().zip(touch.weights);
            corners.filter(|&(_, weight)| weight != 0.0).map(|(&vertex, _)| vertex as usize)
        })
    }

    /// Puts what touches onto its plane, what sticks where it sticks. Vertices that are held stay.
    pub fn project(&self, points: &mut [DVec3], held: &[bool]) {
        for touch in self.touches.iter().filter(|touch| touch.is_active()) {
            let x = touch.point(points);
            let mut way = (touch.offset - touch.normal.dot(x)) * touch.normal;
            if touch.case == Case::Stick {
                let back = touch.carried - x;
                way += back - touch.normal.dot(back) * touch.normal;
            }
            let corners = touch.vertices.into_iter().zip(touch.weights).filter(|&(vertex, _)| !held[vertex as usize]);
            let square: f64 = corners.clone().map(|(_, weight)| weight * weight).sum();
            for (vertex, weight) in corners {
                points[vertex as usize] += weight / square * way;
            }
        }
    }

    /// Whether any touch has a force.
    pub fn any_active(&self) -> bool {
        self.touches.iter().any(Touch::is_active)
    }

    /// The terms of A and b, linearised at these points.
    pub fn terms(&mut self, points: &[DVec3]) -> &[ContactTerm] {
        let Self { touches, terms, .. } = self;
        terms.clear();
        let active = touches.iter_mut().filter(|touch| touch.is_active());
        terms.extend(active.map(|touch| touch.term(touch.point(points))));
        terms
    }

    /// Judges every touch by where a solve led. Says whether so much of the forces was wrong that it must be solved again: a few
    /// touches that were will be right in the next step.
    pub fn judge(&mut self, points: impl Fn(usize) -> DVec3) -> bool {
        let (mut wrong, mut right) = (0.0, 0.0);
        for touch in &mut self.touches {
            let x = touch.at(&points);
            wrong += touch.judge(x);
            right += touch.force.length();
        }
        wrong > WRONG * right
    }

    /// Before a search from these points for a lower potential.
    pub fn brace(&mut self, points: &[DVec3]) {
        for touch in &mut self.touches {
            touch.brace(touch.point(points));
        }
    }

    /// The case of every touch as its potential has it.
    pub fn choose(&mut self, points: &[DVec3]) {
        for touch in &mut self.touches {
            touch.choose(touch.point(points));
        }
    }

    /// Potential of all touches, J.
    pub fn potential(&self, points: &[DVec3]) -> f64 {
        self.touches.iter().map(|touch| touch.potential(touch.point(points))).sum()
    }

    /// Work that colliders did on the cloth on its way from `x` to `y`, counting none that they took, J.
    pub fn work(&self, x: &[DVec3], y: &[DVec3]) -> f64 {
        let done = |touch: &Touch| {
            let way = touch.point(y) - touch.point(x);
            let along = touch.normal.dot(way) * touch.normal.dot(touch.acted);
            along.max(0.0) + (touch.acted.dot(way) - along).max(0.0)
        };
        self.touches.iter().map(done).sum()
    }

    /// Finds what would end inside a collider that it was not seen to come near, after a solve that leads to `end`. Says whether
    /// there was anything.
    pub fn find_late(&mut self, around: &Surroundings, moving: &Moving, end: impl Fn(usize) -> DVec3) -> bool {
        let limits = [around.settings.thickness, find::reach(around)];
        let mut any = false;
        let bodies: Vec<_> = around.colliders.iter().map(|c| Body::new(c, around.from, around.to)).collect();
        for vertex in 0..moving.x.len() {
            let (room, end) = (self.room[vertex], end(vertex));
            if moving.held[vertex] || end.distance_squared(free(moving, vertex)) < room * room {
                continue;
            }
            for (index, body) in bodies.iter().enumerate() {
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
                    Some(touch) if touch.is_active() && touch.normal.dot(meeting.normal) > 0.9 => continue,
                    Some(touch) => {
                        touch.normal = meeting.normal;
                        touch.offset = meeting.offset;
                        touch.surface = meeting.surface;
                        touch.choose(end);
                    }
                    None => {
                        let vertices = [vertex as u32; 3];
                        let found = Found { vertices, weights: [1.0, 0.0, 0.0], feature: SURFACE, meeting };
                        self.touch(found, index, body, around, moving);
                        if let Some(touch) = self.touches.last_mut() {
                            touch.choose(end);
                        }
                    }
                }
                any = true;
            }
        }
        any
    }

    /// Moves out what ended inside a collider all the same, and stops it there. Says how many vertices that were.
    pub fn guard(&self, around: &Surroundings, moving: &Moving, end: &mut [DVec3], velocities: &mut [DVec3]) -> u32 {
        let mut rescued = 0;
        let bodies: Vec<_> = around.colliders.iter().map(|c| Body::new(c, around.from, around.to)).collect();
        let margin = MARGIN * around.settings.thickness;
        for (vertex, &room) in self.room.iter().enumerate() {
            if moving.held[vertex] || end[vertex].distance_squared(free(moving, vertex)) < room * room {
                continue;
            }
            // What is moved out of one part of a collider may be in another.
            for body in bodies.iter().flat_map(|body| [body; RESCUES]) {
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

    /// Takes what the potential says at these points for the forces of the substep.
    pub fn settle(&mut self, points: &[DVec3]) {
        for touch in &mut self.touches {
            touch.settle(touch.point(points));
        }
    }

    /// What a user sees of the touches that have a force, with the cloth at these points.
    pub fn show(&self, points: &[DVec3], colliders: &[Collider]) -> Vec<Contact> {
        let contact = |touch: &Touch| {
            let x = touch.point(points);
            let above = touch.normal.dot(x) - touch.surface;
            Contact {
                vertices: touch.vertices,
                weights: touch.weights,
                collider: colliders.get(touch.collider as usize).map_or(0, |collider| collider.id),
                point: x - above * touch.normal,
                normal: touch.normal,
                force: touch.acted,
            }
        };
        self.touches.iter().filter(|touch| touch.is_active()).map(contact).collect()
    }

    /// Remembers the touches for the next substep.
    pub fn remember(&mut self, around: &Surroundings) {
        let mut body: Option<(u32, Body)> = None;
        let Self { touches, memory, .. } = self;
        memory.replace(touches.iter().filter(|touch| touch.is_active()).map(|touch| {
            let collider = &around.colliders[touch.collider as usize];
            let body = match &mut body {
                Some((index, body)) if *index == touch.collider => body,
                other => &mut other.insert((touch.collider, Body::new(collider, around.from, around.to))).1,
            };
            let normal_force = touch.normal.dot(touch.force);
            Memory {
                collider: collider.id,
                feature: touch.feature,
                vertices: touch.vertices,
                normal_force,
                before: touch.last,
                friction: body.turn_back(touch.force - normal_force * touch.normal),
                slipping: if let Case::Slip(way) = touch.case { Some(body.turn_back(way)) } else { None },
            }
        }));
    }

    /// Forgets everything: the cloth was put elsewhere.
    pub fn forget(&mut self) {
        self.touches.clear();
        self.room.clear();
        self.memory.clear();
        self.features.clear();
    }
}

impl Touch {
    /// Its point of the cloth.
    fn at(&self, points: impl Fn(usize) -> DVec3) -> DVec3 {
        if self.weights[0] == 1.0 {
            return points(self.vertices[0] as usize);
        }
        self.vertices.iter().zip(self.weights).map(|(&vertex, weight)| weight * points(vertex as usize)).sum()
    }

    pub fn point(&self, points: &[DVec3]) -> DVec3 {
        self.at(|vertex| points[vertex])
    }

    /// Keeps the case of friction of the step before where that has not ended: what slips goes on, and what stuck is tried to
    /// stick.
    fn stay(&mut self, slipping: Option<DVec3>, y: DVec3) {
        if !self.is_active() || self.last == 0.0 {
            return;
        }
        self.case = match slipping {
            Some(way) if (y - self.carried).dot(way) >= 0.0 => match self.case {
                Case::Slip(now) if now.dot(way) > 0.5 => Case::Slip(now),
                Case::Slip(_) => Case::Stick,
                _ => Case::Slip(way),
            },
            _ => Case::Stick,
        };
    }
}
