//! Which vertices and triangles of a cloth come near a collider in a step.

use bevy::math::DVec3;

use super::between::{Limits, Passing};
use super::features::Features;
use super::layer::Surroundings;
use super::meeting::{Body, Meeting};
use super::surface::Nearest;
use super::touch::SURFACE;
use crate::physics::terms::Substep;

/// Points are watched which come as near as so many thicknesses.
pub(super) const REACH: f64 = 2.0;
/// Share of the thickness that a triangle may bulge into a round surface by, which its vertices keep.
const BULGE: f64 = 1.0;
/// Thicknesses, at most, that the vertices of a coarse cloth keep further off a round surface: places between them, each with a touch,
/// come and go as the cloth moves, and would not let it rest.
pub(super) const LIFT: f64 = 2.0;
/// Length of a side that this is made for, over that at rest.
const STRETCHED: f64 = 1.1;
/// Length that a side is stretched to at most, over that at rest, where it lies on something round.
pub(super) const MOST_STRETCHED: f64 = 2.0;
/// What is so many thicknesses inside came from another side.
const DEEPEST: f64 = 4.0;

/// A place of the cloth, and where it meets a collider.
pub(super) struct Found {
    /// Rising where there are several; the rest repeat the first.
    pub vertices: [u32; 3],
    pub weights: [f64; 3],
    pub feature: u32,
    pub meeting: Meeting,
}

impl Found {
    /// Whether it came from the free side of what is solid from one side only.
    pub fn passes(&self, body: &Body, moving: &Substep) -> bool {
        let places = self.vertices.iter().zip(self.weights);
        let start: DVec3 = places.map(|(&vertex, weight)| weight * moving.x[vertex as usize]).sum();
        body.is_passed_by(&self.meeting, start)
    }
}

/// The triangles of a cloth.
#[derive(Default)]
pub(super) struct Faces {
    pub triangles: Vec<[u32; 3]>,
    /// By vertex: length of the longest side of the triangles around it at rest, m.
    sides: Vec<f64>,
    /// Length of the longest side of all at rest, m.
    pub longest: f64,
}

impl Faces {
    /// Of these triangles, with the longest side around each vertex at rest, m.
    pub fn new(triangles: Vec<[u32; 3]>, sides: Vec<f64>) -> Self {
        let mut faces = Self { triangles, ..Self::default() };
        faces.measure(sides);
        faces
    }

    /// Changes the longest sides around vertices at rest, m.
    pub fn measure(&mut self, sides: Vec<f64>) {
        self.longest = sides.iter().copied().fold(0.0, f64::max);
        self.sides = sides;
    }

    /// Length of the longest side at the corners of a triangle at rest, m.
    fn longest_around(&self, triangle: &[u32; 3]) -> f64 {
        triangle.iter().map(|&vertex| self.sides[vertex as usize]).fold(0.0, f64::max)
    }

    /// Length of the longest side with the vertices at these places, m.
    pub fn longest_at(&self, x: &[DVec3]) -> f64 {
        let corners = self.triangles.iter().map(|triangle| triangle.map(|vertex| x[vertex as usize]));
        let squares = corners.flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]).map(|[a, b]| a.distance_squared(b));
        squares.fold(0.0, f64::max).sqrt()
    }
}

/// A cloth on its way among colliders.
#[derive(Clone, Copy)]
pub(super) struct Scene<'a> {
    pub around: &'a Surroundings<'a>,
    pub moving: &'a Substep<'a>,
    pub faces: &'a Faces,
}

/// A vertex near a collider, in the frame of that. It fills a cache line: triangles come by many times.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct Near {
    /// Where it would go, m.
    end: DVec3,
    /// The surface nearest to that.
    nearest: Nearest,
    /// How far it goes, m.
    travel: f64,
}

impl Near {
    /// Of a vertex that is not near.
    const FAR: Self =
        Self { end: DVec3::ZERO, nearest: Nearest { distance: f64::INFINITY, normal: DVec3::ZERO }, travel: 0.0 };

    fn is_far(&self) -> bool {
        self.nearest.distance == f64::INFINITY
    }
}

/// Where a vertex would go if nothing but gravity acted on it.
pub(super) fn free(moving: &Substep, vertex: usize) -> DVec3 {
    moving.x[vertex] + moving.dt * (moving.v[vertex] + moving.dt * moving.gravity)
}

/// Points that come nearer than this are watched, at most, m.
pub(super) fn reach(around: &Surroundings) -> f64 {
    around.settings.reach()
}

/// How much further off a round collider a vertex keeps that has a side of this length (m), so that what is between vertices keeps off
/// as far as a thickness allows, m.
fn lift(body: &Body, scene: Scene, side: f64) -> f64 {
    let thickness = scene.around.settings.thickness;
    (body.bulge(STRETCHED * side) - BULGE * thickness).clamp(0.0, LIFT * thickness)
}

/// How far off a collider a vertex keeps, and how near it is watched, m.
pub(super) fn limits(body: &Body, scene: Scene, vertex: usize) -> [f64; 2] {
    limits_of_side(body, scene, scene.faces.sides[vertex])
}

/// The same for the vertex that keeps furthest off.
fn most_limits(body: &Body, scene: Scene) -> [f64; 2] {
    limits_of_side(body, scene, scene.faces.longest)
}

fn limits_of_side(body: &Body, scene: Scene, side: f64) -> [f64; 2] {
    let (thickness, lift) = (scene.around.settings.thickness, lift(body, scene, side));
    [thickness + lift, REACH * thickness + lift]
}

/// How far an arc of a triangle may be over its chord where both ends keep off as far as vertices do, m.
pub(super) fn bulge(body: &Body, scene: Scene, triangle: &[u32; 3]) -> f64 {
    let sides = triangle.map(|vertex| scene.faces.sides[vertex as usize]);
    BULGE * scene.around.settings.thickness + lift(body, scene, sides.into_iter().fold(f64::INFINITY, f64::min))
}

/// Whether there may be anything between vertices: not where a fine cloth lies on something smooth.
pub(super) fn may_be_between(body: &Body, scene: Scene) -> bool {
    let side = MOST_STRETCHED * scene.faces.longest;
    let allowed = BULGE * scene.around.settings.thickness + lift(body, scene, scene.faces.longest);
    body.roundness().is_none_or(|radius| 2.0 * radius < side || body.bulge(side) > allowed)
}

/// Finds vertices near the surface. Takes down where it is nearest to each that is not far, if there is a place for that, and how much
/// room those have that are not near.
pub(super) fn vertices(
    body: &Body,
    scene: Scene,
    free: &[DVec3],
    mut near: Option<&mut Vec<Near>>,
    room: &mut [f64],
    mut then: impl FnMut(Found),
) {
    let moving = scene.moving;
    let aside = if near.is_some() { aside(body, scene) } else { most_limits(body, scene)[1] };
    if let Some(near) = &mut near {
        near.clear();
    }
    for (vertex, room) in room.iter_mut().enumerate() {
        let limits = limits(body, scene, vertex);
        let looked = look(body, moving.x[vertex], free[vertex], aside);
        if let Some(near) = &mut near {
            near.push(looked.map_or(Near::FAR, |(_, found)| found));
        }
        let (start, Near { end, nearest, .. }) = match looked {
            Ok(looked) => looked,
            Err(apart) => {
                *room = room.min(apart - limits[1]);
                continue;
            }
        };
        if moving.held[vertex] {
            continue;
        }
        match body.meet([start, end], nearest, limits, moving.dt) {
            Ok(meeting) => {
                *room = 0.0;
                then(Found { vertices: [vertex as u32; 3], weights: [1.0, 0.0, 0.0], feature: SURFACE, meeting });
            }
            Err(free) => *room = room.min(free),
        }
    }
}

/// Takes down where vertices are near the surface that end as these do, instead of where they would go.
pub(super) fn ending(body: &Body, scene: Scene, near: &mut Vec<Near>, end: impl Fn(usize) -> DVec3) {
    let (aside, x) = (aside(body, scene), scene.moving.x);
    let looked = |vertex: usize| look(body, x[vertex], end(vertex), aside).map_or(Near::FAR, |(_, found)| found);
    near.clear();
    near.extend((0..x.len()).map(looked));
}

/// How far off a collider a vertex is near: as far as a triangle of it can reach, stretched to twice its sides, m.
fn aside(body: &Body, scene: Scene) -> f64 {
    most_limits(body, scene)[1] + 2.0 * scene.faces.longest
}

/// Where a vertex begins its way and where the surface is nearest to its end, if it may be near; else how far it is at least, m.
fn look(body: &Body, x: DVec3, y: DVec3, aside: f64) -> Result<(DVec3, Near), f64> {
    let apart = body.distance_to_box(x.min(y), x.max(y));
    if apart > aside {
        return Err(apart);
    }
    let [start, end] = body.local(x, y);
    let travel = start.distance(end);
    Ok((start, Near { end, nearest: body.nearest(end, aside + 2.0 * travel), travel }))
}

/// Sorts places between vertices before vertices, and leaves one of each: an edge of the cloth is a side of two triangles.
pub(super) fn distinct(found: &mut Vec<Found>) {
    found.sort_by_key(|found| (found.feature, found.vertices));
    found.dedup_by_key(|found| (found.feature, found.vertices));
}

/// Adds how far vertices that go further than `least` would be pushed out of what is kept free, m.
pub(super) fn pushes(body: &Body, scene: Scene, free: &[DVec3], least: f64, pushes: &mut [DVec3]) {
    let moving = scene.moving;
    for vertex in (0..moving.x.len()).filter(|&vertex| !moving.held[vertex]) {
        let (end, limits) = (free[vertex], limits(body, scene, vertex));
        let way = body.local(moving.x[vertex], end);
        if way[0].distance_squared(way[1]) > least * least
            && let Ok(meeting) =
                body.meet(way, body.nearest(way[1], limits[1] + way[0].distance(way[1])), limits, moving.dt)
        {
            pushes[vertex] += (meeting.offset - meeting.normal.dot(end)).max(0.0) * meeting.normal;
        }
    }
}

/// Finds corners and edges between the vertices of triangles, of which it is known where they are.
pub(super) fn between(
    body: &Body,
    features: &Features,
    scene: Scene,
    near: &[Near],
    most: impl Fn(&[u32; 3]) -> f64,
    mut then: impl FnMut(Found),
) {
    let Scene { around, moving, faces } = scene;
    let thickness = around.settings.thickness;
    let reach = REACH * thickness;
    let limits = Limits { thickness, reach, deepest: features.core.min(DEEPEST * thickness) };
    // How far a side goes into a surface that turns by an angle along it, as an arc over its chord; both squared.
    let bulges = |turn: f64, side: f64, most: f64| turn * side > (8.0 * most) * (8.0 * most);
    let fast = faces.longest.max(limits.reach);
    for triangle in &faces.triangles {
        let corners = triangle.map(|vertex| &near[vertex as usize]);
        let most_of = |[a, b, c]: [f64; 3]| a.max(b).max(c);
        let travel = most_of(corners.map(|corner| corner.travel));
        // A triangle that meets something somewhere has no vertex further from it than its sides are long.
        let closest = corners.iter().map(|corner| corner.nearest.distance).fold(f64::INFINITY, f64::min);
        if closest > limits.reach + faces.longest + travel || corners.iter().any(|corner| corner.is_far()) {
            continue;
        }
        let sides = [0, 1, 2].map(|i| [corners[i], corners[(i + 1) % 3]]);
        let longest = most_of(sides.map(|[a, b]| a.end.distance_squared(b.end)));
        let at_rest = faces.longest_around(triangle);
        let (side, most) = (longest.max(at_rest * at_rest), most(triangle));
        let turn = most_of(sides.map(|[a, b]| a.nearest.normal.distance_squared(b.nearest.normal)));
        if travel < fast && !bulges(turn, side, most) {
            continue;
        }
        if triangle.iter().all(|&vertex| moving.held[vertex as usize]) {
            continue;
        }
        let start = triangle.map(|vertex| body.local_start(moving.x[vertex as usize]));
        let passing = Passing { start, end: corners.map(|corner| corner.end) };
        let [low, high] = passing.bounds(limits.reach);
        features.near(low, high, |index, feature| {
            let turn = feature.angle.min(side.sqrt() / feature.radius.max(f64::MIN_POSITIVE));
            if !bulges(turn * turn, side, most) {
                return;
            }
            passing.meet(feature, limits, |between| {
                // Between held vertices nothing can give way.
                if (0..3).all(|i| between.weights[i] == 0.0 || moving.held[triangle[i] as usize]) {
                    return;
                }
                let from: DVec3 = (0..3).map(|i| between.weights[i] * passing.start[i]).sum();
                let meeting = body.meet_between(from, &between, feature.radius, thickness, moving.dt);
                let (vertices, weights) = in_order(*triangle, between.weights);
                then(Found { vertices, weights, feature: index, meeting });
            });
        });
    }
}

/// The same for every triangle that has the place: vertices rising, without those that have no part in it.
fn in_order(vertices: [u32; 3], weights: [f64; 3]) -> ([u32; 3], [f64; 3]) {
    let mut pairs = [0, 1, 2].map(|i| (weights[i] == 0.0, vertices[i], weights[i]));
    pairs.sort_unstable_by_key(|&(none, vertex, _)| (none, vertex));
    let first = pairs[0].1;
    (pairs.map(|(none, vertex, _)| if none { first } else { vertex }), pairs.map(|pair| pair.2))
}
