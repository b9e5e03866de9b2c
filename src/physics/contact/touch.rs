//! The force of a touch: an augmented Lagrangian of Coulomb's law.
//!
//! Along the normal n acts `N = λ + k (o − n·x)`, where it pushes, and along the surface friction `T = τ − k u`, where
//! `|T| ≤ μ N`, with u the slip since the step began. λ and τ are the forces of the step before (Simo & Laursen 1992): so at rest
//! nothing has to be displaced for a force to be there, however soft the springs, and nothing creeps. Which of the cases holds for
//! a touch is decided where the step is linearized and judged again by where it leads.

use bevy::math::{DMat3, DVec3};

use crate::physics::assembly::Stencil;

/// Share of the thickness that may be missing to what was not in touch.
const DEEP: f64 = 0.3;

/// Share of the limit of friction that it may be above it by: else what is about to slip would begin and stop all the time.
const SLACK: f64 = 0.02;

/// A limit of friction that was so many times what it is was not known.
const UNKNOWN: f64 = 2.0;

/// Share of the thickness that what rests may slip by in a step: whatever its limit was taken for, little came of it.
const SHORT: f64 = 0.3;

/// In place of a corner or an edge: all of the surface.
pub(super) const SURFACE: u32 = u32::MAX;

/// Which case of the law holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Case {
    /// No force.
    Apart,
    /// Nothing slips.
    Stick,
    /// Slips along this unit vector: friction is at its limit.
    Slip(DVec3),
}

/// A point of the cloth at a plane.
#[derive(Clone, Debug)]
pub(super) struct Touch {
    /// The vertex, or three of a triangle with their weights.
    pub vertices: [u32; 3],
    pub weights: [f64; 3],
    /// Index of the collider, and its id: the index holds for one step.
    pub collider: u32,
    pub id: u64,
    /// The corner or edge of the collider; [`SURFACE`] for a vertex.
    pub feature: u32,
    /// n.
    pub normal: DVec3,
    /// o, m.
    pub offset: f64,
    /// Where n·x is on the surface itself, m.
    pub surface: f64,
    /// Where u is counted from, m.
    pub carried: DVec3,
    /// k, N/m.
    pub stiffness: f64,
    /// λ, N.
    pub lambda: f64,
    /// τ, N.
    pub tau: DVec3,
    /// N that the limit of friction is counted with, N: it lags behind.
    pub pressing: f64,
    /// μ.
    pub friction: f64,
    pub case: Case,
    /// N of the step before, N.
    pub last: f64,
    /// Whether N is about that of the step before, or little comes in: then the limit of friction is known. In an impact it is not,
    /// and a force as great as that, if it is wrong, would throw the point back.
    pub steady: bool,
    /// Of one that slips but is not steady: friction per metre of slip, N/m.
    pub drag: f64,
    /// How far it slips in the step, as far as is known, m.
    pub expected: f64,
    /// What inertia holds its point back by, N/m.
    pub inertia: f64,
    /// N and T together, once solved for, N.
    pub force: DVec3,
    /// What acted in the solve: with the limit of friction that was known then, N.
    pub acted: DVec3,
}

impl Touch {
    /// N if it could pull, with the point at `x`.
    pub fn normal_force(&self, x: DVec3) -> f64 {
        self.lambda + self.stiffness * (self.offset - self.normal.dot(x))
    }

    /// u.
    fn slip(&self, x: DVec3) -> DVec3 {
        let way = x - self.carried;
        way - self.normal.dot(way) * self.normal
    }

    /// T if there were no limit.
    fn trial(&self, x: DVec3) -> DVec3 {
        self.tau - self.stiffness * self.slip(x)
    }

    /// The limit of friction, N.
    pub fn limit(&self) -> f64 {
        self.friction * self.pressing
    }

    fn thickness(&self) -> f64 {
        self.offset - self.surface
    }

    /// Whether it has a force.
    pub fn is_active(&self) -> bool {
        self.case != Case::Apart
    }

    /// The case at `x`, which depends on nothing else: that of a potential.
    pub fn choose(&mut self, x: DVec3) {
        self.choose_between(x, x);
    }

    /// The case of what would be at `pressed` along the normal and at `slipped` along the surface.
    pub fn choose_between(&mut self, pressed: DVec3, slipped: DVec3) {
        self.case = if self.normal_force(pressed) <= 0.0 {
            Case::Apart
        } else {
            let trial = self.trial(slipped);
            if trial.length() <= self.limit() { Case::Stick } else { Case::Slip(-trial.normalize()) }
        };
    }

    /// Force on the cloth with the point at `x`, and what it falls by when the point moves on.
    fn law(&self, x: DVec3) -> (DVec3, DMat3) {
        let outer = |a: DVec3| DMat3::from_cols(a * a.x, a * a.y, a * a.z);
        let along_normal = outer(self.normal);
        let tangential = DMat3::IDENTITY - along_normal;
        let (friction, stiffness) = match self.case {
            Case::Apart => return (DVec3::ZERO, DMat3::ZERO),
            Case::Stick => (self.trial(x), self.stiffness * tangential),
            Case::Slip(_) if self.drag > 0.0 => (-self.drag * self.slip(x), self.drag * tangential),
            Case::Slip(way) => {
                // Turning with the way of slip, the limit acts across it like a spring.
                let across = self.limit() / self.slip(x).length().max(f64::MIN_POSITIVE);
                (-self.limit() * way, across.min(self.stiffness) * (tangential - outer(way)))
            }
        };
        (self.normal_force(x) * self.normal + friction, self.stiffness * along_normal + stiffness)
    }

    /// Leaves friction to what pushes already, so that the potential is continuous where a touch begins.
    pub fn brace(&mut self, x: DVec3) {
        (self.steady, self.drag) = (true, 0.0);
        if self.normal_force(x) <= 0.0 {
            self.pressing = 0.0;
        }
    }

    /// Takes the force at `x` as it is for that of the step.
    pub fn settle(&mut self, x: DVec3) {
        self.choose(x);
        self.force = self.law(x).0;
        self.acted = self.force;
    }

    /// Its part in A and b, linearized with the point at `x`.
    pub fn stencil(&mut self, x: DVec3) -> Stencil {
        if !self.steady {
            self.drag = (self.limit() / self.expected.max(f64::MIN_POSITIVE)).min(self.stiffness);
        }
        let (force, stiffness) = self.law(x);
        let ([a, b, c], [u, v, w]) = (self.vertices, self.weights);
        Stencil { vertices: [a, b, c, a], weights: [u, v, w, 0.0], force, stiffness }
    }

    /// Takes note of where the solve led, and says how much force was wrong because another case holds there, N.
    pub fn judge(&mut self, x: DVec3) -> f64 {
        let normal = self.normal_force(x);
        let case = self.case;
        self.acted = self.law(x).0;
        let wrong = if normal <= 0.0 {
            self.case = Case::Apart;
            if case == Case::Apart { 0.0 } else { -normal }
        } else {
            let known = self.limit();
            self.pressing = normal;
            if case == Case::Apart {
                self.choose(x);
                // What is not yet near the surface itself may wait for the next step.
                let missing = self.offset - self.normal.dot(x);
                if missing > DEEP * self.thickness() { normal } else { 0.0 }
            } else {
                self.judge_friction(known, x)
            }
        };
        // What was apart in the solve has no force yet: one taken from how deep it went would grow from step to step.
        let normal = if case == Case::Apart { normal.min(self.lambda) } else { normal }.max(0.0);
        self.force = match self.case {
            Case::Apart => DVec3::ZERO,
            Case::Stick => normal * self.normal + self.trial(x).clamp_length_max(self.friction * normal),
            Case::Slip(way) => normal * self.normal - self.friction * normal * way,
        };
        wrong
    }

    /// The same of friction, for the limit that was known in the solve.
    fn judge_friction(&mut self, known: f64, x: DVec3) -> f64 {
        let (slip, trial, limit) = (self.slip(x), self.trial(x), self.limit());
        if known > UNKNOWN * limit && slip.length() > SHORT * self.thickness() {
            self.steady = false;
        }
        match self.case {
            Case::Stick if trial.length() <= (1.0 + SLACK) * limit => (trial.length() - limit).max(0.0),
            case if !self.steady => {
                let acted = match case {
                    Case::Stick => trial.length(),
                    _ if self.drag > 0.0 => self.drag * slip.length(),
                    _ => known,
                };
                let excess = (acted - limit).max(0.0);
                self.case = Case::Slip(slip.try_normalize().unwrap_or(self.normal.any_orthonormal_vector()));
                // Without the force that was too much it slips further.
                self.expected = slip.length() + excess / self.inertia;
                excess
            }
            Case::Slip(way) if slip.dot(way) < 0.0 => {
                self.case = Case::Stick;
                2.0 * limit
            }
            Case::Stick => {
                self.case = Case::Slip(-trial.normalize());
                trial.length() - limit
            }
            Case::Slip(_) | Case::Apart => 0.0,
        }
    }

    /// Potential of its force at `x`, J.
    pub fn potential(&self, x: DVec3) -> f64 {
        let normal = self.normal_force(x).max(0.0);
        let (trial, limit) = (self.trial(x).length(), self.limit());
        let friction = if normal == 0.0 {
            0.0
        } else if trial <= limit {
            0.5 * trial * trial
        } else {
            limit * (trial - 0.5 * limit)
        };
        (0.5 * normal * normal + friction) / self.stiffness
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn touch() -> Touch {
        Touch {
            vertices: [0; 3],
            weights: [1.0, 0.0, 0.0],
            collider: 0,
            id: 0,
            feature: SURFACE,
            normal: DVec3::Y,
            offset: 0.003,
            surface: 0.0,
            carried: DVec3::new(0.1, 0.003, 0.0),
            stiffness: 100.0,
            lambda: 0.02,
            tau: DVec3::new(0.004, 0.0, 0.0),
            pressing: 0.02,
            friction: 0.5,
            case: Case::Stick,
            last: 0.0,
            steady: true,
            drag: 0.0,
            expected: 0.0,
            inertia: 25.0,
            force: DVec3::ZERO,
            acted: DVec3::ZERO,
        }
    }

    /// The force is minus the gradient of the potential, and the stiffness minus the gradient of the force, in every case.
    #[test]
    fn derivatives_agree_with_differences() {
        let places =
            [DVec3::new(0.10001, 0.00299, 0.00002), DVec3::new(0.102, 0.0028, 0.001), DVec3::new(0.1, 0.004, 0.0)];
        let cases = places.map(|x| {
            let mut touch = touch();
            touch.choose(x);
            let term = touch.stencil(x);
            let h = 1e-8;
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let difference = (touch.potential(x - h * axis) - touch.potential(x + h * axis)) / (2.0 * h);
                // Friction has no potential along the normal: its limit lags.
                assert!((difference - term.force.dot(axis)).abs() < 1e-6, "{x}: {difference} {}", term.force);
                if touch.case == Case::Stick {
                    let bend = (touch.stencil(x - h * axis).force - touch.stencil(x + h * axis).force) / (2.0 * h);
                    assert!(bend.distance(term.stiffness * axis) < 1e-3, "{bend}");
                }
            }
            touch.case
        });
        assert_eq!(cases[0], Case::Stick);
        assert!(matches!(cases[1], Case::Slip(_)));
        assert_eq!(cases[2], Case::Apart);
    }

    /// A point of 1 kg, pushed along by 50 N in a step of 1 s, at a surface whose limit is taken for a hundred times what it is.
    #[test]
    fn friction_of_an_unknown_limit_comes_down_to_what_presses() {
        let (mass, load) = (1.0, DVec3::new(50.0, 0.0, 0.0));
        let begin = DVec3::new(0.0, 0.0028, 0.0);
        let mut touch =
            Touch { carried: begin, lambda: 2.0, tau: DVec3::ZERO, pressing: 200.0, inertia: mass, ..touch() };
        let mut excess = f64::INFINITY;
        for _ in 0..8 {
            touch.case = if touch.case == Case::Apart { Case::Stick } else { touch.case };
            let term = touch.stencil(begin);
            let along = (load + term.force).x / (mass + term.stiffness.x_axis.x);
            excess = touch.judge(begin + DVec3::X * along);
        }
        // N is λ and what the surface gives, 2.02 N.
        let (limit, friction) = (touch.limit(), -touch.acted.x);
        assert!((limit - 1.01).abs() < 1e-12 && !touch.steady, "{limit}");
        assert!(excess < 0.02 * limit && (0.9..1.02).contains(&(friction / limit)), "{friction}");
    }

    #[test]
    fn what_pulls_is_let_go_and_what_slips_back_sticks() {
        let mut pulled = touch();
        assert!(pulled.judge(DVec3::new(0.1, 0.004, 0.0)) > 0.0 && pulled.case == Case::Apart);
        let mut dragged = touch();
        assert!(dragged.judge(DVec3::new(0.11, 0.003, 0.0)) > 0.9);
        let Case::Slip(way) = dragged.case else { panic!("{:?}", dragged.case) };
        assert!(way.distance(DVec3::X) < 1e-12);
        assert!((dragged.force - DVec3::new(-0.01, 0.02, 0.0)).length() < 1e-12, "{}", dragged.force);
        let mut back = Touch { case: Case::Slip(DVec3::X), ..touch() };
        assert!(back.judge(DVec3::new(0.099, 0.003, 0.0)) > 0.0 && back.case == Case::Stick);
        let mut resting = touch();
        assert!(resting.judge(DVec3::new(0.1, 0.003, 0.0)) == 0.0 && resting.case == Case::Stick);
        assert!((resting.force - DVec3::new(0.004, 0.02, 0.0)).length() < 1e-12);
    }
}
