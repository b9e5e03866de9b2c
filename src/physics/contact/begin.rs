//! How a touch begins: with what is remembered of it, and as stiff as its load needs.

use bevy::math::DVec3;

use super::find::{Found, free};
use super::layer::{ContactLayer, Surroundings};
use super::meeting::Body;
use super::touch::{Case, Touch};
use crate::physics::terms::Substep;

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

impl ContactLayer {
    /// Makes a touch of what was found.
    pub(super) fn begin(&mut self, found: Found, index: usize, body: &Body, around: &Surroundings, moving: &Substep) {
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
            id: collider.id,
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
            expected: (inertial - meeting.carried).reject_from_normalized(meeting.normal).length(),
            inertia,
            force: DVec3::ZERO,
            acted: DVec3::ZERO,
        };
        let mut slipping = None;
        let fresh = self.memory.is_empty();
        if fresh {
            // Nothing is known yet of what holds the cloth up, so every place of it is stopped for itself.
            let free_slip = (y - touch.carried).reject_from_normalized(touch.normal);
            touch.lambda = touch.pressing;
            touch.tau = (-inertia * free_slip).clamp_length_max(touch.limit());
        }
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
        let thickness = settings.thickness;
        touch.steady |= coming < GENTLE * thickness;
        let pulled = OVER_FABRIC * self.fabric * (coming / thickness).min(1.0);
        let stiff = (load / (GIVE * thickness)).min(STIFFEST * self.fabric);
        touch.stiffness = pulled + (OVER_INERTIA * inertia).max(stiff);
        // What is not held up by the surface may be by the fabric: gravity alone brings nothing into touch.
        let pulled_in = (touch.last > 0.0 || fresh) && touch.normal.dot(y - inertial) < 0.0;
        touch.choose_between(if pulled_in { y } else { inertial }, inertial);
        if !touch.is_active() && touch.last > 0.0 {
            // What pushed goes on until it is seen to pull.
            touch.case = Case::Stick;
        }
        touch.stay(slipping, inertial);
        self.touches.push(touch);
    }
}

impl Touch {
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
